// Text of an option to its value. Every refusal says what was read, what is wrong and shows a good
// example; the caller puts the name of the option in front.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/status.hpp"
#include "core/model/stream_config.hpp"
#include "core/sensor/camera.hpp"
#include "core/sensor/noise_model.hpp"

namespace planecast {

/// The error contract asked for. value: kMetres metres, kSigma and kSurfaces multiples of sigma,
/// kLossless 0.
struct Tolerance {
  ToleranceKind kind = ToleranceKind::kSigma;
  double value = 2.0;
  friend bool operator==(const Tolerance&, const Tolerance&) = default;
};

/// A camera as asked for: by figures, or by the name of a preset, which also knows the size of the
/// image and the noise. Distortion is 0 here.
struct CameraChoice {
  std::string preset;                   ///< "" when given by figures
  Intrinsics intrinsics;                ///< metres_per_unit is 0.001 unless given or known
  bool unit_given = false;              ///< the text named metres per unit
  std::uint32_t width = 0, height = 0;  ///< [px] of a preset, else 0
  std::optional<NoiseModel> noise;      ///< of a preset
};

/// Coefficients in OpenCV's order.
struct Distortion {
  double k1 = 0, k2 = 0, p1 = 0, p2 = 0, k3 = 0;
};

/// Readings outside [min_m, max_m] are invalid.
struct RangeLimits {
  double min_m = 0;
  double max_m = 0;
};

struct ImageSize {
  std::uint32_t width = 0, height = 0;  ///< [px], 1..16384
};

// All: cold path, any thread; errors are kUsage.

/// A finite number between `least` and `most`.
Result<double> parse_number(std::string_view text, double least, double most,
                            std::string_view example);

/// A whole number between `least` and `most`.
Result<std::uint64_t> parse_whole(std::string_view text, std::uint64_t least, std::uint64_t most,
                                  std::string_view example);

/// A length above 0 with its unit, um, mm, cm or m ("10mm"), in metres.
Result<double> parse_length(std::string_view text, std::string_view example = "10mm");

/// "0", a length ("10mm", "0.01m", "5cm"), "2sigma", "surfaces" (3 sigma) or "surfaces:K".
Result<Tolerance> parse_tolerance(std::string_view text);

/// "FX,FY,CX,CY[,METRES_PER_UNIT]" in pixels, or the name of a preset.
Result<CameraChoice> parse_camera(std::string_view text);

/// "K1,K2,P1,P2[,K3]".
Result<Distortion> parse_distortion(std::string_view text);

/// "MIN,MAX" in metres, 0 <= MIN < MAX; a unit may follow each ("20cm,10m").
Result<RangeLimits> parse_range(std::string_view text);

/// "WxH" in pixels.
Result<ImageSize> parse_size(std::string_view text);

}  // namespace planecast
