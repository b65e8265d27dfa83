// One cloud through the point codec, for the programs that train and measure
// it.
#pragma once

#include <array>
#include <cmath>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/base/arena.hpp"
#include "core/io/cloud_builder.hpp"
#include "core/io/point_file.hpp"
#include "core/wire/point_pack.hpp"
#include "core/wire/point_unpack.hpp"

namespace planecast::bench {

/// A path that begins with '@' lies in the data folder, PLANECAST_DATA.
inline std::string data_path(const std::string& path) {
  if (path.empty() || path[0] != '@') return path;
  const char* folder = std::getenv("PLANECAST_DATA");
  return (folder != nullptr ? std::string(folder) : "../shared/data") + path.substr(1);
}

/// The points of a file on a grid of 1/256 of the tolerance, what rounding
/// takes off the bound left out of it; at tolerance 0 on a grid of whole
/// millimetres.
class PointRun {
 public:
  static Result<std::unique_ptr<PointRun>> open(const std::string& path, double units,
                                                double tolerance) {
    auto cloud = read_point_file(path);
    if (!cloud.ok()) return cloud.error();
    std::vector<Point3f> points;
    const auto scale = static_cast<float>(units);
    for (const Point3f& p : cloud->points)
      if (is_valid(p)) points.push_back({p.x * scale, p.y * scale, p.z * scale});
    return make(std::move(points), tolerance);
  }
  static std::unique_ptr<PointRun> make(std::vector<Point3f> points, double tolerance) {
    return std::unique_ptr<PointRun>(new PointRun(std::move(points), tolerance));
  }

  Status pack(std::size_t slice_bytes) {
    report_ = {};
    return packer_.pack(coding_, grid_, {}, slice_bytes, packed_, places_, report_);
  }

  Status unpack() {
    std::uint32_t used = 0;
    for (std::uint32_t i = 0; i < report_.slices; ++i) {
      const Status status = unpacker_.unpack_slice(coding_, 0, packet(i), decoded_grid_, used);
      if (status != Status::kOk) return status;
    }
    return used == grid_.size() ? Status::kOk : Status::kBadSymbol;
  }

  std::span<const std::uint8_t> packet(std::uint32_t i) const {
    return std::span(packed_).subspan(places_[i].offset, places_[i].bytes);
  }
  const FrameReport& report() const { return report_; }
  const std::vector<Point3f>& points() const { return points_; }
  std::vector<Point3f> decoded() const {
    std::vector<Point3f> points;
    for (const GridPoint& p : decoded_grid_)
      points.push_back({static_cast<float>(p.x * step_), static_cast<float>(p.y * step_),
                        static_cast<float>(p.z * step_)});
    return points;
  }
  PointLevels& levels() { return levels_; }
  std::size_t arena_bytes() const { return arena_.capacity(); }

 private:
  PointRun(std::vector<Point3f> points, double tolerance) : points_(std::move(points)) {
    const auto n = static_cast<std::uint32_t>(points_.size());
    step_ = tolerance > 0 ? tolerance / 256 : 0.001;
    // Half a step on each axis for the grid, and as much for the float that
    // comes out.
    coding_ = {tolerance > 0 ? 254U : 0U, n};
    const auto steps = [&](float v) { return static_cast<std::int32_t>(std::lround(v / step_)); };
    for (const Point3f& p : points_) grid_.push_back({steps(p.x), steps(p.y), steps(p.z)});
    Arena measuring = Arena::measuring();
    layout(measuring, n);
    arena_ = std::move(*Arena::map(measuring.bytes_needed()));
    layout(arena_, n);
    packed_.resize(point_frame_capacity(n));
    places_.resize(point_slice_capacity(n, kMinPointSliceBytes));
    decoded_grid_.resize(n);
  }
  void layout(Arena& arena, std::uint32_t n) {
    packer_.layout(arena, n);
    unpacker_.layout(arena, n);
    levels_.layout(arena, n);
  }

  std::vector<Point3f> points_;
  std::vector<GridPoint> grid_, decoded_grid_;
  double step_ = 0;
  PointCoding coding_;
  Arena arena_;
  PointFramePacker packer_;
  PointFrameUnpacker unpacker_;
  PointLevels levels_;
  std::vector<std::uint8_t> packed_;
  std::vector<SlicePlace> places_;
  FrameReport report_;
};

}  // namespace planecast::bench
