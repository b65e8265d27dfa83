// What a real sensor does to true depth: noise that neighbours partly share, drop-outs, the shadow
// beside near objects that a stereo pair cannot match, and rounding to the sensor's levels.
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/random.hpp"
#include "core/sensor/noise_model.hpp"

namespace planecast {

/// How a depth image is spoilt. Lattice: readings are z = C / k for whole k, C = focal length in
/// pixels times baseline times sub-pixel steps.
struct DepthNoiseConfig {
  NoiseModel noise;
  double correlated_share = 0.5;   ///< of the variance, shared over about 8 pixels; 0..1
  double dropout = 0.005;          ///< share of pixels without reading, drawn one by one
  double lattice_c_m = 0;          ///< C [m]; 0 = no lattice
  double shadow_px_m = 0;          ///< focal length times baseline [px m]; 0 = no shadows
  double metres_per_unit = 0.001;  ///< [m] of one depth count
  double min_m = 0, max_m = 65.0;  ///< readings outside are holes
};

/// Spoils depth images of one size; owns its scratch. Cold path, about 15 ns a pixel.
class DepthNoise {
 public:
  DepthNoise(const DepthNoiseConfig& config, std::uint32_t width, std::uint32_t height);

  /// Turns true depth (row-major, metres, 0 = nothing there) into counts (0 = no reading). `random`
  /// decides everything; the same state gives the same counts.
  void apply(std::span<const double> true_z_m, Pcg32& random, std::span<std::uint16_t> counts);

 private:
  void draw_coarse(Pcg32& random);
  double coarse(std::uint32_t u, std::uint32_t v) const noexcept;
  void cast_shadows(std::span<const double> true_z_m, std::uint32_t v);
  std::uint16_t reading(double z_m, double gauss) const noexcept;

  DepthNoiseConfig config_;
  std::uint32_t width_, height_;
  std::uint32_t coarse_width_;
  std::vector<double> coarse_;
  std::vector<std::uint8_t> shadow_;  // of one row
};

}  // namespace planecast
