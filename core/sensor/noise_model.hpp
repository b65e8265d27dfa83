// How far a reading strays from the truth: the noise of a sensor as one wire-exact number. It turns
// a tolerance in sigma into metres and weights the plane fits.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/status.hpp"

namespace planecast {

/// Noise of one depth reading along z. Stereo and structured light: sigma = S z^2, S in 1/m.
/// Time of flight: sigma = S, in metres. Unknown: sigma is 0 and a tolerance in sigma is refused.
struct NoiseModel {
  enum class Kind : std::uint8_t { kUnknown = 0, kStereo = 1, kTof = 2 };

  Kind kind = Kind::kUnknown;
  std::uint32_t s_e9 = 0;  ///< S in 1e-9 of its unit

  /// S in its unit: 1/m for stereo, m for time of flight.
  double s() const noexcept { return s_e9 / 1e9; }

  /// One standard deviation [m] of a reading at depth z_m [m].
  double sigma_m(double z_m) const noexcept {
    switch (kind) {
      case Kind::kStereo:
        return s() * z_m * z_m;
      case Kind::kTof:
        return s();
      case Kind::kUnknown:
        break;
    }
    return 0.0;
  }

  friend bool operator==(const NoiseModel&, const NoiseModel&) = default;
};

/// Reads "stereo:S", "tof:S" (0 < S <= 4) or the name of a sensor preset. Cold path.
/// Errors: kUsage, naming the text and what is accepted.
Result<NoiseModel> parse_noise(std::string_view text);

/// The text parse_noise reads back to the same model: "stereo:0.003", "tof:0.005" or "unknown".
std::string to_string(const NoiseModel& noise);

}  // namespace planecast
