#include "core/model/inverse_noise.hpp"

#include <algorithm>

#include "core/model/cell_moments.hpp"

namespace planecast {
namespace {

constexpr double kUnknownNoise = 0.002;  // [1/m]

}  // namespace

InverseNoise::InverseNoise(const StreamConfig& config) noexcept {
  const double unit_m = static_cast<double>(config.camera.unit_pm) * 1e-12;
  uniform_ = kInverseDepthOne * unit_m * kUnknownNoise;
  if (config.lattice.present()) {
    // Levels are finer than sigma where both are known, and what predictions are judged by.
    uniform_ = kInverseDepthOne * 256.0 / config.lattice.c_q8;
    // Unless sigma decides which points stay.
    if (config.tolerance == ToleranceKind::kSurfaces &&
        config.noise.kind == NoiseModel::Kind::kStereo) {
      uniform_ = std::max(uniform_, kInverseDepthOne * unit_m * config.noise.s());
    }
  } else if (config.noise.kind == NoiseModel::Kind::kStereo && config.noise.s_e9 > 0) {
    uniform_ = kInverseDepthOne * unit_m * config.noise.s();
  } else if (config.noise.kind == NoiseModel::Kind::kTof && config.noise.s_e9 > 0) {
    uniform_ = 0;
    quadratic_ = config.noise.s() / (unit_m * kInverseDepthOne);
  }
}

}  // namespace planecast
