// Whether a list has a point within a given distance of another, for many points fast: cells of
// that distance, sorted. Memory is taken once; filling and asking allocate nothing.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/cloud/sensor_frame.hpp"

namespace planecast {

class NearGrid {
 public:
  /// Room for lists of up to `most` points.
  void reserve(std::size_t most);

  /// Takes a list of finite points; `points` must stay. `distance_m` > 0. False: more points than
  /// there is room for. O(n log n), no allocation.
  bool fill(std::span<const Point3f> points, double distance_m) noexcept;

  /// Largest distance [m] of a point of this list to its nearest of `other`; infinite when one has
  /// none within the distance. Equal points, which coarse grids make many of, are looked up once,
  /// and a look-up ends as soon as it cannot raise the largest distance.
  double farthest_m(const NearGrid& other) const noexcept;

  /// Distance to the nearest point [m] when it is within the distance; infinite when none is. Any
  /// distance up to `enough_m` will do as an answer when it is not above that.
  double nearest_m(const Point3f& p, double enough_m = 0) const noexcept;

 private:
  struct Entry {
    std::uint64_t cell;
    std::uint32_t point;
  };
  std::uint64_t cell_of(double x, double y, double z) const noexcept;

  std::span<const Point3f> points_;
  std::vector<Entry> entries_;
  std::size_t used_ = 0;
  double distance_m_ = 1;
};

}  // namespace planecast
