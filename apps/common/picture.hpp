// Pictures of a frame for people: depth in colours, labels in colours, several side by side.
// Writing them to a file is core/io's write_rgb_png().
#pragma once

#include <cstdint>
#include <span>
#include <vector>

namespace planecast {

struct Rgb {
  std::uint8_t r = 0, g = 0, b = 0;
  friend bool operator==(const Rgb&, const Rgb&) = default;
};

/// 8-bit RGB, row-major, rgb.size() == width * height * 3.
struct Picture {
  std::uint32_t width = 0, height = 0;  ///< [px]
  std::vector<std::uint8_t> rgb;

  Picture() = default;
  Picture(std::uint32_t w, std::uint32_t h, Rgb fill = {});
  /// x < width, y < height.
  Rgb at(std::uint32_t x, std::uint32_t y) const;
  void set(std::size_t pixel, Rgb colour);
};

/// Turbo colour of t in [0, 1]: blue over green and yellow to red; outside it is the nearest end.
Rgb turbo(double t);

/// The depths drawn blue and red [m]. Give the same scale to pictures that are to be compared.
struct ColourScale {
  double near_m = 0, far_m = 0;
};

/// The scale that shows the middle 96 % of the readings (finite and above 0); 0 to 1 m for none.
ColourScale scale_of(std::span<const float> z_m);

/// Depth [m], row-major; black where there is no reading (0, negative or not finite). Nearness is
/// coloured by 1/z, so that near things are told apart as well as far ones.
/// z_m.size() == width * height.
Picture depth_picture(std::span<const float> z_m, std::uint32_t width, std::uint32_t height,
                      ColourScale scale);

/// The same for a depth image in units of metres_per_unit; 0 is no reading.
std::vector<float> metres(std::span<const std::uint16_t> depth, double metres_per_unit);

/// A colour for a label that differs well from those of the labels near it.
Rgb label_colour(std::uint32_t label);

/// Labels, row-major; `none` is drawn dark grey. labels.size() == width * height.
template <class Label>
Picture label_picture(std::span<const Label> labels, std::uint32_t width, std::uint32_t height,
                      Label none) {
  constexpr Rgb kNone{40, 40, 40};
  Picture out(width, height);
  for (std::size_t i = 0; i < labels.size(); ++i)
    out.set(i, labels[i] == none ? kNone : label_colour(static_cast<std::uint32_t>(labels[i])));
  return out;
}

/// The pictures from left to right with a thin white line between; shorter ones end in black.
Picture side_by_side(std::span<const Picture> pictures);

}  // namespace planecast
