// Finds the rays and the depth steps that the points of a raw cloud were computed from, so that
// most of their float bits follow from one number. Encoder half: what is found travels.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/wire/raw_syntax.hpp"

namespace planecast {

/// Fits clouds of one stream. Memory: about 0.4 MB from the arena.
class RawRaysFitter {
 public:
  void layout(Arena& arena) noexcept;

  /// The rays of an organised cloud, rounded to what travels: linear least squares over at most
  /// kSamples readings, taken when they explain them to some units of the last place. `present` is
  /// false when they do not. O(kSamples log kSamples) and one pass; no allocation.
  RawRays fit(std::span<const Point3f> points, std::uint32_t width, std::uint32_t height) noexcept;

  static constexpr std::size_t kSamples = 8192;

 private:
  struct Sample {
    double x = 0, y = 0;   ///< pixel from the middle of the image
    double main = 0;       ///< the primary coordinate
    double ratio[2] = {};  ///< the others over it
  };

  std::size_t take_samples(std::span<const Point3f> points, std::uint32_t width,
                           std::uint32_t height, RawRays& rays) noexcept;
  bool solve(std::span<const Sample> samples, double unit, double most_error,
             RawRays& rays) const noexcept;
  double rms_error(std::span<const Sample> samples, const RawRays& rays) const noexcept;
  bool find_steps(std::span<const Sample> samples, DepthSteps kind, RawRays& rays) noexcept;

  std::span<Sample> samples_;
  std::span<double> depths_;
};

}  // namespace planecast
