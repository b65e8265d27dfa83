#include "core/model/patch.hpp"

#include <algorithm>
#include <cstdlib>

namespace planecast {
namespace {

constexpr unsigned kCurveBits = 15;  // of a coordinate squared: three products stay below 2^63

bool cells_fit(std::int32_t first, std::uint32_t count, unsigned pitch_log2) noexcept {
  const std::int64_t limit = kMaxPatchCoordinate >> pitch_log2;
  return first >= -limit && std::int64_t{first} + count <= limit;
}

}  // namespace

Status check_patch(const Patch& p) noexcept {
  const bool shape = p.degree <= kMaxPatchDegree && p.axis <= 2 && p.pitch_log2 <= kMaxPitchLog2 &&
                     p.height_log2 <= kMaxHeightLog2;
  if (!shape) return Status::kFieldRange;
  const bool grid = p.wide >= 1 && p.high >= 1 && p.wide <= kMaxPatchSide &&
                    p.high <= kMaxPatchSide && p.wide * p.high <= kMaxPatchCells &&
                    (p.wide << p.pitch_log2) <= kMaxPatchExtent &&
                    (p.high << p.pitch_log2) <= kMaxPatchExtent;
  if (!grid || p.points == 0) return Status::kFieldRange;
  if (!cells_fit(p.cell_u, p.wide, p.pitch_log2) || !cells_fit(p.cell_v, p.high, p.pitch_log2))
    return Status::kFieldRange;
  if (std::abs(std::int64_t{p.coefficients[0]}) > kMaxPatchCoordinate >> p.height_log2)
    return Status::kFieldRange;
  for (const std::int32_t c : p.coefficients) {
    if (c < -kMaxPatchCoefficient || c > kMaxPatchCoefficient) return Status::kFieldRange;
  }
  return Status::kOk;
}

// The shifts make an error of half a unit in a slope or a curvature at most a quarter of a height
// step at the grid's border, so neither costs bits that the constant cannot use.
PatchSurface::PatchSurface(const Patch& p) noexcept : degree_(p.degree) {
  const std::int64_t width = std::int64_t{p.wide} << p.pitch_log2;
  const std::int64_t height = std::int64_t{p.high} << p.pitch_log2;
  centre_u_ = std::int64_t{p.cell_u} * (std::int64_t{1} << p.pitch_log2) + (width >> 1);
  centre_v_ = std::int64_t{p.cell_v} * (std::int64_t{1} << p.pitch_log2) + (height >> 1);
  const auto reach = static_cast<unsigned>(
      std::bit_width(static_cast<std::uint64_t>(std::max(width, height) >> 1)));
  const auto shift = [&](unsigned bits) {
    return bits + 1 > p.height_log2 ? bits + 1 - p.height_log2 : 0;
  };
  slope_shift_ = shift(reach);
  cut_ = reach > kCurveBits ? reach - kCurveBits : 0;
  curve_shift_ = shift(2 * (reach - cut_));
  for (std::size_t i = 0; i < kPatchCoefficients[p.degree]; ++i) c_[i] = p.coefficients[i];
  constant_ = c_[0] * (std::int64_t{1} << p.height_log2);
}

}  // namespace planecast
