#include "apps/common/picture.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace planecast {
namespace {

constexpr std::uint32_t kSeparatorPx = 2;
constexpr Rgb kSeparatorColour{255, 255, 255};
constexpr double kTailShare = 0.02;  // of the readings, beyond each end of the scale

std::uint8_t byte_of(double value) {
  return static_cast<std::uint8_t>(std::lround(255.0 * std::clamp(value, 0.0, 1.0)));
}

/// c0 + c1 t + ... + c5 t^5.
double polynomial(const std::array<double, 6>& c, double t) {
  double value = 0.0;
  for (std::size_t i = c.size(); i-- > 0;) value = value * t + c[i];
  return value;
}

bool reading(float z) {
  return std::isfinite(z) && z > 0.0F;
}

/// Hue, saturation and value in [0, 1] to RGB.
Rgb from_hsv(double hue, double saturation, double value) {
  const auto channel = [&](double offset) {
    const double k = std::fmod(offset + hue * 6.0, 6.0);
    return value - value * saturation * std::clamp(std::min(k, 4.0 - k), 0.0, 1.0);
  };
  return {byte_of(channel(5.0)), byte_of(channel(3.0)), byte_of(channel(1.0))};
}

}  // namespace

Picture::Picture(std::uint32_t w, std::uint32_t h, Rgb fill)
    : width(w), height(h), rgb(std::size_t{w} * h * 3) {
  for (std::size_t i = 0; i < std::size_t{w} * h; ++i) set(i, fill);
}

Rgb Picture::at(std::uint32_t x, std::uint32_t y) const {
  const std::size_t i = (std::size_t{y} * width + x) * 3;
  return {rgb[i], rgb[i + 1], rgb[i + 2]};
}

void Picture::set(std::size_t pixel, Rgb colour) {
  rgb[pixel * 3] = colour.r;
  rgb[pixel * 3 + 1] = colour.g;
  rgb[pixel * 3 + 2] = colour.b;
}

Rgb turbo(double t) {
  // Fifth-degree fit of the Turbo colour map (A. Mikhailov, Google, 2019).
  constexpr std::array<double, 6> kRed = {0.13572138,   4.61539260,    -42.66032258,
                                          132.13108234, -152.94239396, 59.28637943};
  constexpr std::array<double, 6> kGreen = {0.09140261,   2.19418839, 4.84296658,
                                            -14.18503333, 4.27729857, 2.82956604};
  constexpr std::array<double, 6> kBlue = {0.10667330,   12.64194608,  -60.58204836,
                                           110.36276771, -89.90310912, 27.34824973};
  const double x = std::isnan(t) ? 0.0 : std::clamp(t, 0.0, 1.0);
  return {byte_of(polynomial(kRed, x)), byte_of(polynomial(kGreen, x)),
          byte_of(polynomial(kBlue, x))};
}

ColourScale scale_of(std::span<const float> z_m) {
  std::vector<float> sorted;
  std::copy_if(z_m.begin(), z_m.end(), std::back_inserter(sorted), reading);
  if (sorted.empty()) return {0.0, 1.0};
  const auto tail = static_cast<std::ptrdiff_t>(kTailShare * static_cast<double>(sorted.size()));
  const auto low = sorted.begin() + tail;
  const auto high = sorted.end() - 1 - tail;
  std::nth_element(sorted.begin(), low, sorted.end());
  const double near_m = *low;
  std::nth_element(sorted.begin(), high, sorted.end());
  return {near_m, *high};
}

Picture depth_picture(std::span<const float> z_m, std::uint32_t width, std::uint32_t height,
                      ColourScale scale) {
  const double near_iv = 1.0 / std::max(scale.near_m, 1e-3);
  const double far_iv = 1.0 / std::max(scale.far_m, 1e-3);
  const double span = near_iv - far_iv;
  Picture out(width, height);
  for (std::size_t i = 0; i < z_m.size(); ++i) {
    if (!reading(z_m[i])) continue;
    const double t = span > 0.0 ? (1.0 / z_m[i] - far_iv) / span : 0.5;
    out.set(i, turbo(0.02 + 0.96 * std::clamp(t, 0.0, 1.0)));  // the ends are near black
  }
  return out;
}

std::vector<float> metres(std::span<const std::uint16_t> depth, double metres_per_unit) {
  std::vector<float> z_m(depth.size());
  std::transform(depth.begin(), depth.end(), z_m.begin(),
                 [&](std::uint16_t d) { return static_cast<float>(d * metres_per_unit); });
  return z_m;
}

Rgb label_colour(std::uint32_t label) {
  // Golden-ratio steps spread the hues of consecutive labels; brightness tells near hues apart.
  constexpr double kGolden = 0.61803398874989485;
  constexpr std::array kValues = {1.0, 0.75, 0.9};
  constexpr std::array kSaturations = {0.65, 0.9, 0.45, 0.8};
  const double hue = std::fmod(0.13 + kGolden * label, 1.0);
  return from_hsv(hue, kSaturations[label % kSaturations.size()], kValues[label % kValues.size()]);
}

Picture side_by_side(std::span<const Picture> pictures) {
  std::uint32_t width = 0;
  std::uint32_t height = 0;
  for (const Picture& picture : pictures) {
    width += picture.width + (width > 0 ? kSeparatorPx : 0);
    height = std::max(height, picture.height);
  }
  Picture out(width, height);
  std::uint32_t left = 0;
  for (const Picture& picture : pictures) {
    for (std::uint32_t y = 0; left > 0 && y < height; ++y) {
      for (std::uint32_t x = left; x < left + kSeparatorPx; ++x)
        out.set(std::size_t{y} * width + x, kSeparatorColour);
    }
    if (left > 0) left += kSeparatorPx;
    for (std::uint32_t y = 0; y < picture.height; ++y) {
      std::copy_n(picture.rgb.data() + std::size_t{y} * picture.width * 3,
                  std::size_t{picture.width} * 3,
                  out.rgb.data() + (std::size_t{y} * width + left) * 3);
    }
    left += picture.width;
  }
  return out;
}

}  // namespace planecast
