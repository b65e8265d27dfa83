// Well-known depth cameras by name. The figures are the NOMINAL ones commonly published for the
// model, not a calibration of anybody's unit: a focal length may be some percent off.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <string_view>

#include "core/sensor/camera.hpp"
#include "core/sensor/noise_model.hpp"

namespace planecast {

/// One depth mode of one camera model, nominal. Distortion is 0 throughout: it differs from unit to
/// unit and a wrong one is worse than none.
struct SensorPreset {
  std::string_view name;         ///< e.g. "realsense-d435"
  std::string_view description;  ///< for people
  std::uint32_t width, height;   ///< [px]
  Intrinsics intrinsics;
  NoiseModel noise;
  double rate_hz;
  double min_m, max_m;     ///< usual working range [m]
  double baseline_m;       ///< stereo and structured light; 0 for time of flight
  double steps_per_pixel;  ///< sub-pixel steps of the disparity; 0 for time of flight
};

/// All presets, in the order of preset_names(). Static storage.
std::span<const SensorPreset> sensor_presets() noexcept;

/// The preset with exactly this name, or nullptr. Static storage.
const SensorPreset* find_preset(std::string_view name) noexcept;

/// All names, separated by ", ", for help and error texts.
std::string preset_names();

}  // namespace planecast
