#include "apps/common/parse_values.hpp"

#include <array>
#include <charconv>
#include <cmath>
#include <span>
#include <vector>

#include "apps/common/suggestion.hpp"
#include "core/sensor/sensor_preset.hpp"

namespace planecast {
namespace {

constexpr double kLargestSigmas = 1000.0;
constexpr double kSmallestBound = 1e-6;  // [m]; the wire counts in 0.1 um, floats end near there
constexpr double kLargestLength = 1000.0;
constexpr double kLargestPixel = 1e6;
constexpr double kLargestCoefficient = 100.0;
constexpr double kDefaultSurfaceSigmas = 3.0;

Error refuse(std::string_view text, std::string_view problem, std::string_view example) {
  std::string message =
      text.empty() ? "is empty" : "'" + std::string(text) + "' " + std::string(problem);
  return {Status::kUsage, message + "; write for example " + std::string(example)};
}

/// The number `text` starts with; what follows it goes to `rest`. Not finite counts as no number.
std::optional<double> leading_number(std::string_view text, std::string_view& rest) {
  double value = 0;
  const auto [stop, code] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (code != std::errc() || !std::isfinite(value)) return std::nullopt;
  rest = text.substr(static_cast<std::size_t>(stop - text.data()));
  return value;
}

std::optional<double> whole_number_text(std::string_view text) {
  std::string_view rest;
  const std::optional<double> value = leading_number(text, rest);
  return rest.empty() ? value : std::nullopt;
}

std::optional<double> metres_in(std::string_view unit) {
  if (unit == "m") return 1.0;
  if (unit == "cm") return 1e-2;
  if (unit == "mm") return 1e-3;
  if (unit == "um") return 1e-6;
  return std::nullopt;
}

std::string_view trimmed(std::string_view text) {
  while (text.starts_with(' ')) text.remove_prefix(1);
  while (text.ends_with(' ')) text.remove_suffix(1);
  return text;
}

std::vector<std::string_view> split(std::string_view text, char separator) {
  std::vector<std::string_view> parts;
  for (;;) {
    const std::size_t at = text.find(separator);
    parts.push_back(trimmed(text.substr(0, at)));
    if (at == std::string_view::npos) return parts;
    text.remove_prefix(at + 1);
  }
}

/// `least` to `most` comma-separated numbers.
Result<std::vector<double>> numbers(std::string_view text, std::size_t least, std::size_t most,
                                    std::string_view example) {
  const std::vector<std::string_view> parts = split(text, ',');
  if (parts.size() < least || parts.size() > most) {
    const std::string wanted =
        std::to_string(least) + (least == most ? "" : " or " + std::to_string(most));
    return refuse(text, "has " + std::to_string(parts.size()) + " values instead of " + wanted,
                  example);
  }
  std::vector<double> values;
  for (const std::string_view part : parts) {
    const std::optional<double> value = whole_number_text(part);
    if (!value)
      return refuse(text, "holds '" + std::string(part) + "', which is not a number", example);
    values.push_back(*value);
  }
  return values;
}

Result<Tolerance> sigmas(std::string_view text, std::string_view number, ToleranceKind kind,
                         std::string_view example) {
  const std::optional<double> k = whole_number_text(number);
  if (!k || !(*k > 0.0 && *k <= kLargestSigmas))
    return refuse(text, "needs a number of sigma above 0 and at most 1000", example);
  return Tolerance{kind, *k};
}

Result<CameraChoice> camera_by_name(std::string_view text) {
  const SensorPreset* preset = find_preset(text);
  if (preset == nullptr) {
    std::vector<std::string> names;
    for (const SensorPreset& known : sensor_presets()) names.emplace_back(known.name);
    return Error{Status::kUsage, "'" + std::string(text) + "' is not a known camera" +
                                     did_you_mean(text, names) + "\n  known: " + preset_names() +
                                     "\n  or give its figures: FX,FY,CX,CY[,METRES_PER_UNIT], "
                                     "for example 383.8,383.8,321.7,236.8,0.001"};
  }
  CameraChoice camera;
  camera.preset = preset->name;
  camera.intrinsics = preset->intrinsics;
  camera.width = preset->width;
  camera.height = preset->height;
  camera.noise = preset->noise;
  return camera;
}

}  // namespace

Result<double> parse_number(std::string_view text, double least, double most,
                            std::string_view example) {
  const std::optional<double> value = whole_number_text(trimmed(text));
  if (!value) return refuse(text, "is not a number", example);
  if (*value < least || *value > most) {
    std::array<char, 64> limits{};
    std::snprintf(limits.data(), limits.size(), "is not between %g and %g", least, most);
    return refuse(text, limits.data(), example);
  }
  return *value;
}

Result<std::uint64_t> parse_whole(std::string_view text, std::uint64_t least, std::uint64_t most,
                                  std::string_view example) {
  std::uint64_t value = 0;
  const std::string_view digits = trimmed(text);
  const char* end = digits.data() + digits.size();
  const auto [stop, code] = std::from_chars(digits.data(), end, value);
  if (code == std::errc::invalid_argument || stop != end)
    return refuse(text, "is not a whole number", example);
  if (code != std::errc() || value < least || value > most) {
    return refuse(text, "is not between " + std::to_string(least) + " and " + std::to_string(most),
                  example);
  }
  return value;
}

Result<double> parse_length(std::string_view text, std::string_view example) {
  std::string_view rest;
  const std::optional<double> value = leading_number(trimmed(text), rest);
  if (!value) return refuse(text, "is not a length", example);
  const std::optional<double> scale = metres_in(trimmed(rest));
  if (!scale) {
    return refuse(text, rest.empty() ? "has no unit" : "has a unit that is not um, mm, cm or m",
                  example);
  }
  const double metres = *value * *scale;
  if (!(metres > 0.0 && metres <= kLargestLength))
    return refuse(text, "is not above 0 and at most 1000m", example);
  return metres;
}

Result<Tolerance> parse_tolerance(std::string_view whole) {
  constexpr std::string_view kExample = "0 (lossless), 10mm, 2sigma, surfaces or surfaces:3";
  const std::string_view text = trimmed(whole);
  if (text == "0" || text == "lossless") return Tolerance{ToleranceKind::kLossless, 0.0};
  if (text == "surfaces") return Tolerance{ToleranceKind::kSurfaces, kDefaultSurfaceSigmas};
  if (text.starts_with("surfaces:"))
    return sigmas(text, text.substr(9), ToleranceKind::kSurfaces, kExample);
  std::string_view rest;
  const std::optional<double> value = leading_number(text, rest);
  if (!value) return refuse(text, "is not a tolerance", kExample);
  const std::string_view unit = trimmed(rest);
  if (unit == "sigma" || unit == "sigmas")
    return sigmas(text, text.substr(0, text.size() - rest.size()), ToleranceKind::kSigma, kExample);
  const Result<double> metres = parse_length(text, kExample);
  if (!metres) return metres.error();
  if (*metres < kSmallestBound) return refuse(text, "is below 1um", "0 for lossless, or 10mm");
  return Tolerance{ToleranceKind::kMetres, *metres};
}

Result<CameraChoice> parse_camera(std::string_view whole) {
  constexpr std::string_view kExample =
      "383.8,383.8,321.7,236.8,0.001 (FX,FY,CX,CY in pixels, metres per unit)";
  const std::string_view text = trimmed(whole);
  if (text.empty()) return refuse(text, "", kExample);
  const bool by_figures = text.find(',') != std::string_view::npos || whole_number_text(text);
  if (!by_figures) return camera_by_name(text);
  const Result<std::vector<double>> read = numbers(text, 4, 5, kExample);
  if (!read) return read.error();
  const std::vector<double>& value = *read;
  if (!(value[0] > 0 && value[1] > 0 && value[0] <= kLargestPixel && value[1] <= kLargestPixel))
    return refuse(text, "has a focal length that is not above 0", kExample);
  if (std::abs(value[2]) > kLargestPixel || std::abs(value[3]) > kLargestPixel)
    return refuse(text, "has a centre far outside any image", kExample);
  CameraChoice camera;
  camera.intrinsics.fx = value[0];
  camera.intrinsics.fy = value[1];
  camera.intrinsics.cx = value[2];
  camera.intrinsics.cy = value[3];
  if (value.size() == 5) {
    if (!(value[4] >= 1e-12 && value[4] <= 1.0))
      return refuse(text, "has metres per unit that are not above 0 and at most 1", kExample);
    camera.intrinsics.metres_per_unit = value[4];
    camera.unit_given = true;
  }
  return camera;
}

Result<Distortion> parse_distortion(std::string_view text) {
  constexpr std::string_view kExample = "-0.05,0.06,0.0002,-0.0001,-0.02 (K1,K2,P1,P2,K3)";
  const Result<std::vector<double>> read = numbers(text, 4, 5, kExample);
  if (!read) return read.error();
  const std::vector<double>& k = *read;
  for (const double value : k) {
    if (std::abs(value) > kLargestCoefficient)
      return refuse(text, "has a coefficient beyond 100", kExample);
  }
  return Distortion{k[0], k[1], k[2], k[3], k.size() == 5 ? k[4] : 0.0};
}

Result<RangeLimits> parse_range(std::string_view text) {
  constexpr std::string_view kExample = "0.2,10 (metres)";
  const std::vector<std::string_view> parts = split(text, ',');
  if (parts.size() != 2) return refuse(text, "is not MIN,MAX", kExample);
  std::array<double, 2> limits{};
  for (std::size_t i = 0; i < 2; ++i) {
    std::string_view rest;
    const std::optional<double> value = leading_number(parts[i], rest);
    const std::optional<double> scale = rest.empty() ? 1.0 : metres_in(trimmed(rest));
    if (!value || !scale)
      return refuse(text, "holds '" + std::string(parts[i]) + "', which is not a distance",
                    kExample);
    limits[i] = *value * *scale;
  }
  if (!(limits[0] >= 0.0 && limits[0] < limits[1]))
    return refuse(text, "does not hold 0 <= MIN < MAX", kExample);
  return RangeLimits{limits[0], limits[1]};
}

Result<ImageSize> parse_size(std::string_view text) {
  constexpr std::string_view kExample = "640x480";
  const std::vector<std::string_view> parts = split(text, 'x');
  if (parts.size() != 2) return refuse(text, "is not WIDTHxHEIGHT", kExample);
  std::array<std::uint32_t, 2> sides{};
  for (std::size_t i = 0; i < 2; ++i) {
    const Result<std::uint64_t> side = parse_whole(parts[i], 1, kMaxImageSide, kExample);
    if (!side)
      return refuse(text, "has a side that is not a whole number from 1 to 16384", kExample);
    sides[i] = static_cast<std::uint32_t>(*side);
  }
  return ImageSize{sides[0], sides[1]};
}

}  // namespace planecast
