// A piece of a surface of an unorganised cloud as it travels: a polynomial of low degree over two
// of the three coordinates, the cells of a grid that its points lie in, and how many they are
// (docs/wire-format.md, "Patches"). Shared by both halves: integers only.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/model/stream_config.hpp"

namespace planecast {

inline constexpr unsigned kMaxPatchDegree = 2;
inline constexpr std::size_t kMaxPatchCoefficients = 6;
/// Coefficients of a surface of degree 0, 1, 2.
inline constexpr std::array<std::uint8_t, kMaxPatchDegree + 1> kPatchCoefficients = {1, 3, 6};

inline constexpr unsigned kMaxPitchLog2 = 15;
inline constexpr std::uint32_t kMaxPatchSide = 4096;          ///< [cells]
inline constexpr std::uint32_t kMaxPatchCells = 1U << 16U;    ///< of one patch that travels
inline constexpr std::uint32_t kMaxPatchExtent = 1U << 21U;   ///< [steps] either side
inline constexpr std::int32_t kMaxPatchCoordinate = 1 << 30;  ///< [steps] either way
inline constexpr std::int32_t kMaxPatchCoefficient = (1 << 30) - 1;
inline constexpr unsigned kMaxHeightLog2 = 15;

/// Cells of the finest pitch that an encoder takes, alpha, are 2^8 steps wide.
inline constexpr unsigned kAlphaPitchLog2 = 8;

/// PointStream::patch_unit_nm that makes cells of 2^kAlphaPitchLog2 steps alpha wide, as nearly as
/// whole nanometres go.
inline std::uint32_t patch_unit_nm(double alpha_m) noexcept {
  const double unit = alpha_m * 1e9 / (1U << kAlphaPitchLog2) + 0.5;
  return unit >= 1 ? (unit < kMaxPatchUnitNm ? static_cast<std::uint32_t>(unit) : kMaxPatchUnitNm)
                   : 1;
}

/// One patch. (u, v) are the coordinates other than `axis`, in rising order (y, z; x, z; x, y).
struct Patch {
  std::uint8_t degree = 1;       ///< 0..kMaxPatchDegree
  std::uint8_t axis = 2;         ///< the dropped coordinate, which the surface gives: 0 x, 1 y, 2 z
  std::uint8_t pitch_log2 = 8;   ///< a cell is 2^this steps wide
  std::uint8_t height_log2 = 3;  ///< the surface's constant counts 2^this steps
  std::int32_t cell_u = 0;       ///< first cell of the grid; a cell i covers i 2^pitch_log2 ...
  std::int32_t cell_v = 0;
  std::uint32_t wide = 0;                                          ///< [cells] along u
  std::uint32_t high = 0;                                          ///< [cells] along v
  std::uint32_t points = 0;                                        ///< that come back, 1 or more
  std::array<std::int32_t, kMaxPatchCoefficients> coefficients{};  ///< 1, u, v, uu, uv, vv

  friend bool operator==(const Patch&, const Patch&) = default;
};

/// kOk, or kFieldRange when a field is outside what the format allows.
Status check_patch(const Patch& patch) noexcept;

/// Evaluates a patch's surface; made once per patch. Any patch that check_patch() accepts.
class PatchSurface {
 public:
  explicit PatchSurface(const Patch& patch) noexcept;

  /// Height above the plane of (u, v), all in steps, for u and v in the patch's grid.
  std::int64_t height(std::int64_t u, std::int64_t v) const noexcept {
    const std::int64_t du = u - centre_u_, dv = v - centre_v_;
    std::int64_t h = constant_;
    h += (c_[1] * du + c_[2] * dv) >> slope_shift_;
    if (degree_ < 2) return h;
    const std::int64_t a = du >> cut_, b = dv >> cut_;
    return h + ((c_[3] * a * a + c_[4] * a * b + c_[5] * b * b) >> curve_shift_);
  }

  /// Where du = dv = 0, in steps, and the shifts: what an encoder rounds its coefficients by.
  std::int64_t centre_u() const noexcept { return centre_u_; }
  std::int64_t centre_v() const noexcept { return centre_v_; }
  unsigned slope_shift() const noexcept { return slope_shift_; }
  unsigned curve_shift() const noexcept { return curve_shift_; }
  unsigned cut() const noexcept { return cut_; }

 private:
  std::array<std::int64_t, kMaxPatchCoefficients> c_{};
  std::int64_t constant_ = 0, centre_u_ = 0, centre_v_ = 0;
  unsigned slope_shift_ = 0, curve_shift_ = 0, cut_ = 0;
  std::uint8_t degree_ = 1;
};

/// The point (u, v, height) [steps] of a patch that drops `axis`, in metres.
inline Point3f patch_point(std::uint8_t axis, std::int64_t u, std::int64_t v, std::int64_t height,
                           double unit_m) noexcept {
  const auto a = static_cast<float>(static_cast<double>(u) * unit_m);
  const auto b = static_cast<float>(static_cast<double>(v) * unit_m);
  const auto w = static_cast<float>(static_cast<double>(height) * unit_m);
  return axis == 0 ? Point3f{w, a, b} : (axis == 1 ? Point3f{a, w, b} : Point3f{a, b, w});
}

/// Metres in a step of a stream's patches.
inline double patch_unit_m(const PointStream& stream) noexcept {
  return static_cast<double>(stream.patch_unit_nm) * 1e-9;
}

}  // namespace planecast
