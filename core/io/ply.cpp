#include "core/io/ply.hpp"

#include <bit>
#include <string>
#include <vector>

#include "core/base/bytes.hpp"
#include "core/io/cloud_builder.hpp"
#include "core/io/file_bytes.hpp"
#include "core/io/ply_data.hpp"
#include "core/io/ply_header.hpp"

namespace planecast {
namespace {

bool is_axis(const std::string& name) {
  return name == "x" || name == "y" || name == "z";
}

std::vector<std::string> other_content(const PlyHeader& header) {
  std::vector<std::string> names;
  for (const PlyProperty& property : header.elements[header.vertex].properties) {
    if (!is_axis(property.name)) names.push_back(property.name);
  }
  for (std::size_t i = 0; i < header.elements.size(); ++i) {
    const PlyElement& element = header.elements[i];
    if (i != header.vertex && element.count > 0) names.push_back("element " + element.name);
  }
  return names;
}

CoordinateKind coordinate_kind(const PlyHeader& header) {
  if (header.encoding == PlyEncoding::kAscii) return CoordinateKind::kWide;
  for (const PlyProperty& property : header.elements[header.vertex].properties) {
    if (is_axis(property.name) && property.type != PlyType::kF32) return CoordinateKind::kWide;
  }
  return CoordinateKind::kFloat32;
}

template <class Word>
void append_le(std::vector<std::uint8_t>& out, Word word) {
  out.resize(out.size() + sizeof(Word));
  store_le(out.data() + out.size() - sizeof(Word), word);
}

void append_point(std::vector<std::uint8_t>& out, const PointCloud& cloud, const Point3f& p) {
  if (has_origin(cloud)) {
    const Point3d q = absolute_point(cloud, p);
    for (const double v : {q.x, q.y, q.z}) append_le(out, std::bit_cast<std::uint64_t>(v));
  } else {
    for (const float v : {p.x, p.y, p.z}) append_le(out, std::bit_cast<std::uint32_t>(v));
  }
}

}  // namespace

Result<PointCloud> read_ply(const std::filesystem::path& path) {
  const auto file = read_file_bytes(path);
  if (!file) return file.error();
  return parse_ply(path, *file);
}

Result<PointCloud> parse_ply(const std::filesystem::path& path,
                             std::span<const std::uint8_t> file) {
  const Result<PlyHeader> header = parse_ply_header(path, file);
  if (!header) return header.error();
  const auto points = read_ply_points(path, *header, file);
  if (!points) return points.error();
  return build_cloud(path, static_cast<std::uint32_t>(points->size()), 1, *points,
                     coordinate_kind(*header), other_content(*header));
}

Result<WriteReport> write_ply(const std::filesystem::path& path, const PointCloud& cloud) {
  WriteReport report;
  for (const Point3f& p : cloud.points) {
    ++(is_valid(p) ? report.points_written : report.points_left_out);
  }
  const std::string type = has_origin(cloud) ? "double" : "float";
  const std::string header = "ply\nformat binary_little_endian 1.0\nelement vertex " +
                             std::to_string(report.points_written) + "\nproperty " + type +
                             " x\nproperty " + type + " y\nproperty " + type + " z\nend_header\n";
  std::vector<std::uint8_t> bytes(header.begin(), header.end());
  bytes.reserve(bytes.size() + report.points_written * (has_origin(cloud) ? 24 : 12));
  for (const Point3f& p : cloud.points) {
    if (is_valid(p)) append_point(bytes, cloud, p);
  }
  const Result<Done> written = write_file_bytes(path, bytes);
  if (!written) return written.error();
  return report;
}

}  // namespace planecast
