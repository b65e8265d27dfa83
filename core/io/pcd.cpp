#include "core/io/pcd.hpp"

#include <algorithm>
#include <bit>
#include <string>
#include <vector>

#include "core/base/bytes.hpp"
#include "core/io/cloud_builder.hpp"
#include "core/io/file_bytes.hpp"
#include "core/io/io_error.hpp"
#include "core/io/pcd_data.hpp"
#include "core/io/pcd_header.hpp"
#include "core/io/text.hpp"

namespace planecast {
namespace {

std::vector<std::string> other_fields(const PcdHeader& header) {
  std::vector<std::string> names;
  for (std::size_t i = 0; i < header.fields.size(); ++i) {
    const bool taken = std::find(header.xyz.begin(), header.xyz.end(), i) != header.xyz.end();
    if (!taken && header.fields[i].name != "_") names.push_back(header.fields[i].name);  // _ pads
  }
  return names;
}

CoordinateKind coordinate_kind(const PcdHeader& header) {
  if (header.encoding == PcdEncoding::kAscii) return CoordinateKind::kWide;
  for (const std::size_t i : header.xyz) {
    if (header.fields[i].size == 8) return CoordinateKind::kWide;
  }
  return CoordinateKind::kFloat32;
}

std::string header_text(const PointCloud& cloud) {
  const std::string size = has_origin(cloud) ? "8" : "4";
  const Pose& pose = cloud.viewpoint;
  std::string viewpoint;
  for (const double v : {pose.tx, pose.ty, pose.tz, pose.qw, pose.qx, pose.qy, pose.qz}) {
    viewpoint += ' ';
    append_number(viewpoint, v);
  }
  return "# .PCD v0.7 - Point Cloud Data file format\nVERSION 0.7\nFIELDS x y z\nSIZE " + size +
         " " + size + " " + size + "\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
         std::to_string(cloud.width) + "\nHEIGHT " + std::to_string(cloud.height) + "\nVIEWPOINT" +
         viewpoint + "\nPOINTS " + std::to_string(cloud.points.size()) + "\nDATA binary\n";
}

void store_points(const PointCloud& cloud, std::uint8_t* at) noexcept {
  const bool wide = has_origin(cloud);
  for (const Point3f& p : cloud.points) {
    if (wide) {
      const Point3d q = absolute_point(cloud, p);
      for (const double v : {q.x, q.y, q.z}) {
        store_le(at, std::bit_cast<std::uint64_t>(v));
        at += sizeof(double);
      }
    } else {
      for (const float v : {p.x, p.y, p.z}) {
        store_le(at, std::bit_cast<std::uint32_t>(v));
        at += sizeof(float);
      }
    }
  }
}

}  // namespace

Result<PointCloud> read_pcd(const std::filesystem::path& path) {
  const auto file = read_file_bytes(path);
  if (!file) return file.error();
  return parse_pcd(path, *file);
}

Result<PointCloud> parse_pcd(const std::filesystem::path& path,
                             std::span<const std::uint8_t> file) {
  const Result<PcdHeader> header = parse_pcd_header(path, file);
  if (!header) return header.error();
  const auto points = read_pcd_points(path, *header, file);
  if (!points) return points.error();
  auto cloud = build_cloud(path, header->width, header->height, *points, coordinate_kind(*header),
                           other_fields(*header));
  if (cloud) cloud->viewpoint = header->viewpoint;
  return cloud;
}

Result<WriteReport> write_pcd(const std::filesystem::path& path, const PointCloud& cloud) {
  if (std::uint64_t{cloud.width} * cloud.height != cloud.points.size()) {
    return file_error(path, "", "the cloud's width x height is not its number of points",
                      "set width and height before writing", Status::kUsage);
  }
  const std::string header = header_text(cloud);
  const std::size_t point_bytes = has_origin(cloud) ? 24 : 12;
  std::vector<std::uint8_t> bytes(header.size() + cloud.points.size() * point_bytes);
  std::copy(header.begin(), header.end(), bytes.begin());
  store_points(cloud, bytes.data() + header.size());
  const Result<Done> written = write_file_bytes(path, bytes);
  if (!written) return written.error();
  return WriteReport{cloud.points.size(), 0};
}

}  // namespace planecast
