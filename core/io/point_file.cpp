#include "core/io/point_file.hpp"

#include <system_error>

#include "core/io/file_kind.hpp"
#include "core/io/io_error.hpp"
#include "core/io/kitti_bin.hpp"
#include "core/io/pcd.hpp"
#include "core/io/ply.hpp"
#include "core/io/text.hpp"
#include "core/io/xyz_text.hpp"

namespace planecast {
namespace {

bool is_missing(const std::filesystem::path& path) {
  std::error_code code;
  return !std::filesystem::exists(path, code);
}

Error not_writable(const std::filesystem::path& path) {
  return file_error(path, "", "points are not written in this format",
                    "name the output .ply, .pcd, .bin, .xyz, .txt or .asc", Status::kUsage);
}

}  // namespace

Result<PointCloud> read_point_file(const std::filesystem::path& path) {
  if (is_missing(path)) {
    return file_error(path, "", "no such file", "check the path", Status::kNotFound);
  }
  switch (file_kind(path)) {
    case FileKind::kPcd:
      return read_pcd(path);
    case FileKind::kPly:
      return read_ply(path);
    case FileKind::kKittiBin:
      return read_kitti_bin(path);
    case FileKind::kXyzText:
      return read_xyz_text(path);
    case FileKind::kDepthPng:
    case FileKind::kDepthRaw:
      return file_error(path, "", "is a depth image, not a list of points",
                        "give it where depth is asked for, with --camera");
    case FileKind::kUnread:
      break;
  }
  return refusal(path);
}

Result<WriteReport> write_point_file(const std::filesystem::path& path, const PointCloud& cloud) {
  switch (file_kind(path)) {
    case FileKind::kPcd:
      return write_pcd(path, cloud);
    case FileKind::kPly:
      return write_ply(path, cloud);
    case FileKind::kKittiBin:
      return write_kitti_bin(path, cloud);
    case FileKind::kXyzText: {
      const std::string extension = lower_case(path.extension().string());
      // A .csv without commas or a .pts without its count would mislead their readers.
      if (extension == ".csv" || extension == ".pts") return not_writable(path);
      return write_xyz_text(path, cloud);
    }
    case FileKind::kDepthPng:
    case FileKind::kDepthRaw:
    case FileKind::kUnread:
      break;
  }
  return not_writable(path);
}

}  // namespace planecast
