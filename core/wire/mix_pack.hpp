// Codes one tile of a depth frame under `--effort best`: several predictions and models mixed for
// each decision (docs/wire-format.md, "Mixed tile"). Encoder half.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/wire/mix_tile.hpp"
#include "core/wire/tile_content.hpp"
#include "core/wire/tile_fill.hpp"

namespace planecast {

/// Working memory of one packer, taken from the arena at start; used by one thread.
class MixPacker {
 public:
  void layout(Arena& arena, std::uint32_t max_width) noexcept { scratch_.layout(arena, max_width); }

  /// Codes `rect` of the frame into `out`. kTooLarge when `out` is too small, or when counts as
  /// they are take no more (report.verbatim says so); otherwise kOk. No allocation.
  Status pack(const CodingTables& tables, const FrameModel& frame, const TileRect& rect,
              std::span<std::uint8_t> out, TileReport& report, const TileFill& fill = {}) noexcept;

 private:
  MixScratch scratch_;
};

}  // namespace planecast
