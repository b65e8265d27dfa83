#include "core/io/kitti_bin.hpp"

#include <bit>
#include <vector>

#include "core/base/bytes.hpp"
#include "core/io/cloud_builder.hpp"
#include "core/io/file_bytes.hpp"
#include "core/io/io_error.hpp"

namespace planecast {
namespace {

constexpr std::size_t kRecordBytes = 16;
constexpr std::size_t kPacketBytes = 1206;  // a Velodyne packet; such recordings are named .bin too

double load_float(const std::uint8_t* at) noexcept {
  return std::bit_cast<float>(load_le<std::uint32_t>(at));
}

}  // namespace

Result<PointCloud> read_kitti_bin(const std::filesystem::path& path) {
  const auto file = read_file_bytes(path);
  if (!file) return file.error();
  return parse_kitti_bin(path, *file);
}

Result<PointCloud> parse_kitti_bin(const std::filesystem::path& path,
                                   std::span<const std::uint8_t> file) {
  const std::size_t size = file.size();
  if (size % kRecordBytes != 0) {
    const bool packets = size % kPacketBytes == 0;
    return file_error(path, at_byte(size - size % kRecordBytes),
                      "the size of " + std::to_string(size) +
                          " bytes is not a multiple of 16 (float32 x y z intensity)",
                      packets
                          ? "it may hold LiDAR packets: convert them to PCD"
                          : "the file is cut short or of another kind: convert it to PCD or PLY");
  }
  if (size / kRecordBytes > kMaxFilePoints) {
    return file_error(path, "", "has more than " + std::to_string(kMaxFilePoints) + " points",
                      "split the cloud");
  }
  std::vector<Point3d> points(size / kRecordBytes);
  const std::uint8_t* at = file.data();
  for (Point3d& p : points) {
    p = {load_float(at), load_float(at + 4), load_float(at + 8)};
    at += kRecordBytes;
  }
  return build_cloud(path, static_cast<std::uint32_t>(points.size()), 1, points,
                     CoordinateKind::kFloat32, {"intensity"});
}

Result<WriteReport> write_kitti_bin(const std::filesystem::path& path, const PointCloud& cloud) {
  if (has_origin(cloud)) {
    return file_error(path, "", "float32 records cannot hold this cloud's large offset",
                      "write PLY or PCD, which keep it in double", Status::kUsage);
  }
  WriteReport report;
  std::vector<std::uint8_t> bytes(cloud.points.size() * kRecordBytes);
  std::uint8_t* at = bytes.data();
  for (const Point3f& p : cloud.points) {
    if (!is_valid(p)) {
      ++report.points_left_out;
      continue;
    }
    for (const float v : {p.x, p.y, p.z, 0.0F}) {
      store_le(at, std::bit_cast<std::uint32_t>(v));
      at += sizeof(float);
    }
    ++report.points_written;
  }
  bytes.resize(report.points_written * kRecordBytes);
  const Result<Done> written = write_file_bytes(path, bytes);
  if (!written) return written.error();
  return report;
}

}  // namespace planecast
