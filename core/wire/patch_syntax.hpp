// How the patches of a slice are written, field by field (docs/wire-format.md, section "Patches"):
// one text for both ends. Io is an encoder's or a decoder's, as in raw_tile.hpp.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <span>

#include "core/base/status.hpp"
#include "core/model/patch.hpp"
#include "core/wire/bit_model.hpp"

namespace planecast {

/// What the body of a slice of a point stream holds: its first raw(2).
inline constexpr std::uint32_t kPatchSliceBody = 2;
inline constexpr std::uint32_t kMaxPatchesInSlice = 4096;

/// State of a slice: fresh in each.
struct PatchModels {
  enum Number : std::uint8_t { kWide, kHigh, kCellU, kCellV, kPoints, kConstant, kSlope, kCurve };
  static constexpr std::size_t kNumbers = 8;

  BitModel plane;
  std::array<std::array<BitModel, 4>, 3> axis;
  std::array<BitModel, 16> pitch;
  std::array<std::array<BitModel, 32>, kNumbers> length;
  std::array<BitModel, 256> cell;
  Patch last;  ///< the patch before, whose place the next is told from
};

/// Codes patches one after the other. When reading, fields are checked before they are believed;
/// when writing, patches are valid by check_patch(). One thread.
template <class Io>
class PatchCode {
 public:
  PatchCode(Io& io, PatchModels& models) noexcept : io_(io), m_(models) {}

  /// The slice's own fields, behind its raw(2). kFieldRange never: every value has a meaning.
  void head(std::uint32_t& patches, std::uint8_t& height_log2) noexcept {
    patches = io_.raw(patches - 1, 12) + 1;
    height_log2 = static_cast<std::uint8_t>(io_.raw(height_log2, 4));
    m_.last.height_log2 = height_log2;
  }

  /// Everything of a patch but its cells. kFieldRange.
  Status fields(Patch& p) noexcept {
    p.height_log2 = m_.last.height_log2;
    if (io_.bit(m_.plane, p.degree == 1))
      p.degree = 1;
    else
      p.degree = io_.raw(p.degree == 2 ? 1 : 0, 1) != 0 ? 2 : 0;
    p.axis = static_cast<std::uint8_t>(tree(m_.axis[m_.last.axis], p.axis, 2));
    if (p.axis > 2) return Status::kFieldRange;
    p.pitch_log2 = static_cast<std::uint8_t>(tree(m_.pitch, p.pitch_log2, 4));
    p.wide = number(PatchModels::kWide, p.wide - 1) + 1;
    p.high = number(PatchModels::kHigh, p.high - 1) + 1;
    const bool same = p.axis == m_.last.axis && p.pitch_log2 == m_.last.pitch_log2;
    p.cell_u = from(PatchModels::kCellU, p.cell_u, same ? m_.last.cell_u : 0);
    p.cell_v = from(PatchModels::kCellV, p.cell_v, same ? m_.last.cell_v : 0);
    p.points = number(PatchModels::kPoints, p.points - 1) + 1;
    for (std::size_t i = 0; i < kPatchCoefficients[p.degree]; ++i) {
      const auto kind =
          i == 0 ? PatchModels::kConstant : (i < 3 ? PatchModels::kSlope : PatchModels::kCurve);
      p.coefficients[i] = from(kind, p.coefficients[i], 0);
    }
    m_.last = p;
    return Io::kReads ? check_patch(p) : Status::kOk;
  }

  /// wide * high cells, row by row, 0 or 1. False when reading found none inside.
  bool cells(const Patch& p, std::span<std::uint8_t> cells) noexcept {
    // Never written; no constant, so that its zeros take none of a board's flash.
    static constinit std::array<std::uint8_t, kMaxPatchSide> empty{};
    const std::uint8_t* up2 = empty.data();
    const std::uint8_t* up = empty.data();
    unsigned any = 0;
    for (std::uint32_t j = 0; j < p.high; ++j) {
      std::uint8_t* row = &cells[std::size_t{j} * p.wide];
      // Windows of the rows above, the newest cell lowest: up holds i-2 .. i+2, up2 i-1 .. i+1.
      unsigned near = up[0], far = up2[0], left = 0;
      near = (near << 1U) | (p.wide > 1 ? up[1] : 0U);
      for (std::uint32_t i = 0; i < p.wide; ++i) {
        near = ((near << 1U) | (i + 2 < p.wide ? up[i + 2] : 0U)) & 0x1fU;
        far = ((far << 1U) | (i + 1 < p.wide ? up2[i + 1] : 0U)) & 0x7U;
        const unsigned context = ((near >> 1U) & 7U) << 5U | (near & 1U) << 4U |
                                 ((far >> 1U) & 1U) << 3U | (near >> 4U) << 2U | (left & 3U);
        const unsigned inside = io_.bit(m_.cell[context], row[i] != 0) ? 1 : 0;
        row[i] = static_cast<std::uint8_t>(inside);
        left = (left << 1U) | inside;
        any |= inside;
      }
      up2 = up;
      up = row;
    }
    return any != 0;
  }

 private:
  template <std::size_t N>
  std::uint32_t tree(std::array<BitModel, N>& models, std::uint32_t value, int bits) noexcept {
    std::uint32_t node = 1;
    for (int i = bits - 1; i >= 0; --i)
      node = (node << 1U) | (io_.bit(models[node], ((value >> i) & 1U) != 0) ? 1U : 0U);
    return node - (1U << bits);
  }

  /// A number below 2^31: its length by a model, what is below its highest bit as it is.
  std::uint32_t number(PatchModels::Number kind, std::uint32_t value) noexcept {
    const std::uint32_t length = tree(m_.length[kind], std::bit_width(value), 5);
    if (length < 2) return length;
    int rest = static_cast<int>(length) - 1;
    std::uint32_t read = 1;
    for (; rest > 0;) {
      const int part = rest > 16 ? 16 : rest;
      rest -= part;
      read = (read << part) | io_.raw((value >> rest) & ((1U << part) - 1U), part);
    }
    return read;
  }

  /// A value within +-2^30, told as its distance from `expected`, itself within that range.
  std::int32_t from(PatchModels::Number kind, std::int32_t value, std::int32_t expected) noexcept {
    const std::int64_t distance = std::int64_t{value} - expected;
    const auto size = static_cast<std::uint32_t>(distance < 0 ? -distance : distance);
    const std::uint32_t read = number(kind, size);
    if (read == 0) return expected;
    const bool below = io_.raw(distance < 0 ? 1 : 0, 1) != 0;
    const std::int64_t result = std::int64_t{expected} + (below ? -std::int64_t{read} : read);
    // A stream that says more is refused by check_patch(), which must see that it does.
    const std::int64_t limit = std::int64_t{kMaxPatchCoordinate} + 1;
    return static_cast<std::int32_t>(result > limit ? limit : (result < -limit ? -limit : result));
  }

  Io& io_;
  PatchModels& m_;
};

}  // namespace planecast
