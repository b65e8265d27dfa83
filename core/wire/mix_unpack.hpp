// Decodes one tile of `--effort best`: the mirror of mix_pack.hpp, for bytes from anywhere. Decoder
// half: every field is bounded before it is believed, nothing is allocated.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/wire/mix_tile.hpp"
#include "core/wire/range_decoder.hpp"
#include "core/wire/tile_content.hpp"

namespace planecast {

/// Working memory of one unpacker, taken from the arena at start; used by one thread.
class MixUnpacker {
 public:
  void layout(Arena& arena, std::uint32_t max_width) noexcept { scratch_.layout(arena, max_width); }

  /// Decodes the rows of blocks of a tile whose head `coder` has read into `content` ; `fallback`
  /// is the level of its first reading. Time is bounded by the tile's pixels. kBadSymbol: an
  /// impossible level or label; kTruncated.
  Status unpack(const CodingTables& tables, RangeDecoder& coder, std::int32_t fallback,
                const TileTarget& target, TileContent& content) noexcept;

  /// The models as the tile decoded last left them; what training the starts reads.
  const MixModels& models() const noexcept { return scratch_.models[0]; }

 private:
  MixScratch scratch_;
};

}  // namespace planecast
