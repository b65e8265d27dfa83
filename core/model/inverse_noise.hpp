// How noisy an inverse depth is, by what a stream says of its sensor.
#pragma once

#include "core/model/stream_config.hpp"

namespace planecast {

/// Noise of an inverse depth: what one standard deviation (or, finer, one level of the sensor)
/// is worth in steps of 2^-31 per count.
class InverseNoise {
 public:
  InverseNoise() noexcept = default;

  /// Lattice and stereo: uniform; time of flight: sigma_z / z^2; unknown without lattice: 0.002 z^2
  /// [m], as of a stereo camera.
  explicit InverseNoise(const StreamConfig& config) noexcept;

  /// Sigma at an inverse depth `iv` > 0.
  double sigma(double iv) const noexcept { return uniform_ + quadratic_ * iv * iv; }

 private:
  double uniform_ = 1;
  double quadratic_ = 0;
};

}  // namespace planecast
