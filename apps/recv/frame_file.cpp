#include "apps/recv/frame_file.hpp"

#include <fmt/format.h>

#include <cctype>

#include "apps/common/points_setup.hpp"
#include "core/io/depth_png.hpp"
#include "core/io/kitti_bin.hpp"
#include "core/io/pcd.hpp"
#include "core/io/ply.hpp"

namespace planecast {
namespace {

std::string safe(const char* text) {
  std::string out;
  for (; *text != '\0'; ++text) {
    const bool fine = std::isalnum(static_cast<unsigned char>(*text)) != 0 || *text == '-' ||
                      *text == '_' || (*text == '.' && !out.empty());
    out += fine ? *text : '_';
  }
  return out.empty() ? "stream" : out;
}

PointCloud cloud_of(const SinkFrame& frame) {
  PointCloud cloud;
  cloud.width = frame.list() ? frame.pixels : frame.config.camera.width;
  cloud.height = frame.list() ? 1 : frame.config.camera.height;
  if (frame.list()) set_origin(frame.config, cloud);
  const auto points = frame.cloud.first(frame.pixels);
  cloud.points.assign(points.begin(), points.end());
  cloud.viewpoint = to_pose(frame.config.pose);
  return cloud;
}

Result<Done> done(const Result<WriteReport>& written) {
  if (!written.ok()) return written.error();
  return Done{};
}

}  // namespace

std::string frame_file_name(const SinkFrame& frame, FrameFormat format) {
  std::string name = safe(frame.config.frame_id.data());
  if (frame.stream != 0) name += fmt::format("_{}", frame.stream);
  if (frame.sender > 1) name += fmt::format(".{}", frame.sender);
  return fmt::format("{}-{:06}{}.{}", name, frame.frame, frame.complete ? "" : ".partial",
                     extension(format));
}

Result<Done> write_frame(const SinkFrame& frame, FrameFormat format,
                         const std::filesystem::path& path) {
  switch (format) {
    case FrameFormat::kPly:
      return done(write_ply(path, cloud_of(frame)));
    case FrameFormat::kPcd:
      return done(write_pcd(path, cloud_of(frame)));
    case FrameFormat::kBin:
      return done(write_kitti_bin(path, cloud_of(frame)));
    case FrameFormat::kPng:
      break;
  }
  if (frame.raw()) {
    return Error{Status::kUsage, path.string() +
                                     ": the stream carries float clouds, which have no depth "
                                     "image; choose ply or pcd"};
  }
  DepthImage image;
  image.width = frame.config.camera.width;
  image.height = frame.config.camera.height;
  const auto depth = frame.depth.first(frame.pixels);
  image.depth.assign(depth.begin(), depth.end());
  return write_depth_png(path, image);
}

}  // namespace planecast
