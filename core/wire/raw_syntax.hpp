// The parts of a raw tile that both halves share: points by one model of rays and depth steps,
// residuals of float bits (docs/wire-format.md, "Raw tile"). Double + - * / only, no contraction:
// the same predictions on every machine.
#pragma once

#include <algorithm>
#include <bit>
#include <cstdint>
#include <limits>
#include <span>

#include "core/cloud/sensor_frame.hpp"
#include "core/wire/bit_model.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// How the depths along the rays of a raw cloud are spaced.
enum class DepthSteps : std::uint8_t {
  kNone = 0,
  kEven = 1,     ///< depth = origin + step * n
  kInverse = 2,  ///< 1 / depth = origin + step * n
};

/// The rays of a raw cloud. At pixel (u, v), with x = u - width / 2 and y = v - height / 2:
/// point[primary] = depth * (1 + slope[0] x + slope[1] y), and the other two in rising order are
/// point[primary] * (ratio[i][0] x + ratio[i][1] y + ratio[i][2]) / (1 + slope[0] x + slope[1] y).
struct RawRays {
  bool present = false;
  std::uint8_t primary = 2;  ///< coordinate coded first: 0 x, 1 y, 2 z
  DepthSteps steps = DepthSteps::kNone;
  double slope[2] = {};
  double ratio[2][3] = {};
  double origin = 0;
  double step = 0;

  double scale(double x, double y) const noexcept { return 1.0 + slope[0] * x + slope[1] * y; }
  /// The primary coordinate of step n.
  double value(std::int64_t n, double ray_scale) const noexcept {
    const double s = origin + step * static_cast<double>(n);
    return steps == DepthSteps::kInverse ? ray_scale / s : ray_scale * s;
  }
};

/// The coordinates beside the primary one, in rising order.
inline constexpr std::uint8_t kOtherCoordinates[3][2] = {{1, 2}, {0, 2}, {0, 1}};

/// Doubles travel with the upper 48 of their 64 bits; rounds to those (finite values only).
inline double round_to_48(double value) noexcept {
  const std::uint64_t bits = std::bit_cast<std::uint64_t>(value) + 0x8000U;
  return std::bit_cast<double>(bits & ~std::uint64_t{0xffff});
}

/// Largest |n| of a depth step.
inline constexpr std::int64_t kMaxStepNumber = std::int64_t{1} << 28U;

/// Float bits in the order of the values: -0 right below +0.
inline std::uint32_t ordered_bits(float value) noexcept {
  const auto bits = std::bit_cast<std::uint32_t>(value);
  return (bits & 0x80000000U) != 0 ? ~bits : bits | 0x80000000U;
}
inline float from_ordered_bits(std::uint32_t bits) noexcept {
  return std::bit_cast<float>((bits & 0x80000000U) != 0 ? bits & 0x7fffffffU : ~bits);
}

/// A prediction as ordered bits; what is no number or out of a float's range ends at its border.
inline std::uint32_t ordered_prediction(double value) noexcept {
  constexpr double kMost = std::numeric_limits<float>::max();
  if (!(value > -kMost)) return ordered_bits(std::numeric_limits<float>::lowest());
  if (!(value < kMost)) return ordered_bits(std::numeric_limits<float>::max());
  return ordered_bits(static_cast<float>(value));
}

/// A point is a reading when all three coordinates are finite; otherwise it is a hole.
inline bool is_reading(const Point3f& p) noexcept {
  const auto finite = [](float f) {
    return (std::bit_cast<std::uint32_t>(f) & 0x7f800000U) != 0x7f800000U;
  };
  return finite(p.x) && finite(p.y) && finite(p.z);
}

/// What holes come back as.
inline Point3f hole_point() noexcept {
  const float nan = std::bit_cast<float>(std::uint32_t{0x7fc00000});
  return {nan, nan, nan};
}

/// Kinds of residuals: the primary coordinate, the two others, and numbers of depth steps.
inline constexpr int kRawKinds = 4;
inline constexpr int kStepKind = 3;
inline constexpr int kSizeContexts = 12;

/// Probability models of a raw tile; every tile starts from even ones.
struct RawModels {
  BitModel mask[64];
  BitModel size[kRawKinds][kSizeContexts][64];  ///< bit length of a residual, as a tree
  BitModel sign[kRawKinds][9];
  BitModel top[kRawKinds][33][4];  ///< the two bits below the leading one
};

/// What later points need of a coded one.
struct RawState {
  float at[3] = {};
  std::int32_t step = 0;
  double miss[2] = {};       ///< of the two other coordinates' ratios from their rays
  std::int8_t size[4] = {};  ///< signed bit lengths of the residuals
  bool valid = false;
};

/// States of one row of a raw tile of `bw` blocks, with a border of two on both sides so that
/// neighbours outside the tile read as holes; a tile needs two rows.
inline constexpr std::uint32_t kRowBorder = 2;
inline std::size_t row_states(std::uint32_t bw) noexcept {
  return std::size_t{bw} * 8 + 2 * kRowBorder;
}
inline std::size_t raw_states(std::uint32_t bw) noexcept {
  return 2 * row_states(bw);
}

}  // namespace planecast
