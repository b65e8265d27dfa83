#include "core/sensor/noise_model.hpp"

#include <charconv>

#include "core/sensor/sensor_preset.hpp"

namespace planecast {
namespace {

constexpr double kLargestS = 4.0;  // fits s_e9; far beyond any sensor

Error refuse(std::string_view text, const std::string& mend) {
  return {Status::kUsage, "noise model '" + std::string(text) + "': " + mend};
}

}  // namespace

Result<NoiseModel> parse_noise(std::string_view text) {
  const std::size_t colon = text.find(':');
  if (colon == std::string_view::npos) {
    if (const SensorPreset* preset = find_preset(text)) return preset->noise;
    return refuse(text, "give stereo:S (sigma = S z^2), tof:S (sigma = S metres) or one of " +
                            preset_names());
  }
  NoiseModel noise;
  const std::string_view kind = text.substr(0, colon);
  if (kind == "stereo") {
    noise.kind = NoiseModel::Kind::kStereo;
  } else if (kind == "tof") {
    noise.kind = NoiseModel::Kind::kTof;
  } else {
    return refuse(text, "the kind before ':' is stereo or tof");
  }
  const std::string_view number = text.substr(colon + 1);
  const char* end = number.data() + number.size();
  double s = 0;
  const auto [stop, code] = std::from_chars(number.data(), end, s);
  const bool readable = code == std::errc() && stop == end;
  if (!readable || !(s >= 1e-9 && s <= kLargestS)) {
    return refuse(text, "S after ':' is a number above 0 and at most 4, e.g. stereo:0.003");
  }
  noise.s_e9 = static_cast<std::uint32_t>(s * 1e9 + 0.5);
  return noise;
}

std::string to_string(const NoiseModel& noise) {
  if (noise.kind == NoiseModel::Kind::kUnknown) return "unknown";
  std::string fraction = std::to_string(noise.s_e9 % 1'000'000'000U);
  fraction.insert(0, 9 - fraction.size(), '0');
  while (!fraction.empty() && fraction.back() == '0') fraction.pop_back();
  std::string number = std::to_string(noise.s_e9 / 1'000'000'000U);
  if (!fraction.empty()) number += "." + fraction;
  return (noise.kind == NoiseModel::Kind::kStereo ? "stereo:" : "tof:") + number;
}

}  // namespace planecast
