// Decodes one tile into a depth image: the mirror of tile_pack.hpp, for bytes from anywhere.
// Decoder half: every field is bounded before it is believed, nothing is allocated.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/wire/mix_unpack.hpp"
#include "core/wire/range_decoder.hpp"
#include "core/wire/residual_models.hpp"
#include "core/wire/tile_content.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// Working memory of one unpacker, taken from the arena at start; used by one thread.
class TileUnpacker {
 public:
  void layout(Arena& arena, std::uint32_t max_width) noexcept;

  /// Decodes `in` into `target`. Time is bounded by the tile's pixels. kFieldRange: a rectangle
  /// outside the image or a value no encoder writes; kBadSymbol: an impossible level or label;
  /// kTruncated; kTrailingBytes. On failure the tile's rectangle of `target` is cleared when it
  /// was known.
  Status unpack(const CodingTables& tables, std::span<const std::uint8_t> in,
                const TileTarget& target, TileContent& content) noexcept;

  /// The place that `in` says it has, before it is decoded: kFieldRange outside the image;
  /// kTruncated. O(1).
  static Status peek(const CameraModel& camera, std::span<const std::uint8_t> in,
                     TileRect& rect) noexcept;

  /// The models as the tile decoded last left them; what training the starts reads.
  const TileModels& models() const noexcept { return models_; }
  const ResidualModels& residuals() const noexcept { return residuals_; }
  const MixModels& mix_models() const noexcept { return mix_.models(); }

 private:
  /// A pixel's correction in steps and where it leads: level 0 for one that is none, `raw` its
  /// count when that is off the levels.
  struct Corrected {
    std::int32_t correction = 0, level = 0;
    std::uint16_t raw = 0;
  };
  struct Job;
  struct Segment;

  static Status read_place(const CameraModel& camera, RangeDecoder& coder, bool& modelled,
                           TileRect& rect) noexcept;
  Status read_head(Job& job, RangeDecoder& coder) noexcept;
  static void clear_labels(const Job& job) noexcept;
  Status read_runs(Job& job, RangeDecoder& coder) noexcept;
  Status read_verbatim(Job& job, RangeDecoder& coder) noexcept;
  Status read_block(Job& job, RangeDecoder& coder, BlockState& block,
                    const BlockNeighbours& n) noexcept;
  Status read_block_row(Job& job, RangeDecoder& coder, std::uint32_t row) noexcept;
  Status read_row(Job& job, RangeDecoder& coder, std::uint32_t tile_v) noexcept;
  template <bool kEveryCount>
  Status read_lossless_row(Job& job, RangeDecoder& shared, std::uint32_t tile_v) noexcept;
  std::int32_t read_jump(const LevelTable& levels, RangeDecoder& coder, std::int32_t from,
                         std::int32_t sign, std::uint16_t& depth) noexcept;
  std::int32_t read_far(const LevelTable& levels, RangeDecoder& coder, std::int32_t prediction,
                        std::uint16_t& depth) noexcept;
  bool read_mask(RangeDecoder& coder, MaskWalk& mask) noexcept;
  bool read_segment(Job& job, RangeDecoder& shared, TileRows rows, const Segment& segment) noexcept;
  void read_flat(Job& job, RangeDecoder& shared, TileRows rows, const Segment& segment) noexcept;
  bool read_choice(RangeDecoder& coder, const Neighbourhood& around, const BlockState& block,
                   std::uint8_t& choice) noexcept;
  Corrected read_correction(const LevelTable& levels, RangeDecoder& coder, Neighbourhood around,
                            const PixelPrediction& p, int activity) noexcept;

  std::span<PixelRow> rows_;
  std::span<BlockState> blocks_;
  std::span<BlockPlane> planes_;
  std::span<BlockSurface> surfaces_;
  TileModels models_;
  ResidualModels residuals_;  ///< of lossless tiles
  MixUnpacker mix_;           ///< of `--effort best`
};

}  // namespace planecast
