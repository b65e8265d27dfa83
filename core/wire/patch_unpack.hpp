// Reads the patches of a slice one by one: the mirror of patch_pack.hpp, for bytes from anywhere.
// Decoder half: every field is bounded before it is believed, nothing is allocated.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/model/patch.hpp"
#include "core/wire/patch_syntax.hpp"
#include "core/wire/range_decoder.hpp"

namespace planecast {

/// One thread; memory (kMaxPatchCells bytes and the models) from the arena at start.
class PatchUnpacker {
 public:
  void layout(Arena& arena) noexcept;

  /// Begins the body of a sealed slice, packet header and raw(2) included (`body` is what follows
  /// the packet header and must outlive the reading). kFieldRange: not a body of patches.
  Status begin(std::span<const std::uint8_t> body) noexcept;

  /// Patches of the slice not yet read.
  std::uint32_t left() const noexcept { return left_; }

  /// Reads the next patch and its cells (this object's memory until the next call; wide * high, row
  /// by row, 1 inside). Call while left() > 0. kFieldRange: a patch that check_patch() refuses or
  /// without a cell inside; kTruncated; kTrailingBytes, with the last patch. After a failure
  /// nothing is left. Time is bounded by kMaxPatchCells, whatever the bytes.
  Status next(Patch& patch, std::span<const std::uint8_t>& cells) noexcept;

 private:
  std::span<std::uint8_t> cells_;
  PatchModels models_;
  RangeDecoder coder_{{}};
  std::uint32_t left_ = 0;
};

}  // namespace planecast
