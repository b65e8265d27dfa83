// Decodes one tile into a depth image: the mirror of tile_pack.hpp, for bytes from anywhere.
// Decoder half: every field is bounded before it is believed, nothing is allocated.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/wire/range_decoder.hpp"
#include "core/wire/residual_models.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// What one tile held.
struct TileContent {
  TileRect rect;
  std::uint32_t points = 0;                     ///< readings decoded
  std::uint32_t corrections = 0;                ///< of them with a correction that is not zero
  std::uint32_t surfaces = 0;                   ///< surfaces the tile carries
  std::array<Surface, kMaxSurfaces> surface{};  ///< the first `surfaces` are in use
  bool verbatim = false;
};

/// Where a decoded tile goes: width * height of the stream's camera each, row-major. `labels` may
/// be empty; otherwise it receives 1 + the tile's surface number for pixels of labelled blocks.
struct TileTarget {
  std::span<std::uint16_t> depth;
  std::span<std::uint8_t> labels;
};

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

 private:
  struct Job;
  struct Segment;

  static Status read_place(const CameraModel& camera, RangeDecoder& coder, bool& verbatim,
                           TileRect& rect) noexcept;
  Status read_head(Job& job, RangeDecoder& coder) noexcept;
  Status read_verbatim(Job& job, RangeDecoder& coder) noexcept;
  Status read_block(Job& job, RangeDecoder& coder, BlockState& block,
                    const BlockNeighbours& n) noexcept;
  Status read_block_row(Job& job, RangeDecoder& coder, std::uint32_t row) noexcept;
  Status read_row(Job& job, RangeDecoder& coder, std::uint32_t tile_v) noexcept;
  Status read_lossless_row(Job& job, RangeDecoder& shared, std::uint32_t tile_v) noexcept;
  std::int32_t read_far(const LevelTable& levels, RangeDecoder& coder, std::int32_t prediction,
                        std::uint16_t& depth) noexcept;
  bool read_segment(Job& job, RangeDecoder& shared, TileRows rows, const Segment& segment) noexcept;
  void read_flat(Job& job, RangeDecoder& coder, TileRows rows, const Segment& segment,
                 const BlockSurface& plane) noexcept;
  bool read_choice(RangeDecoder& coder, const Neighbourhood& around, const BlockState& block,
                   std::uint8_t& choice) noexcept;
  std::int32_t read_correction(const LevelTable& levels, RangeDecoder& coder,
                               const PixelPrediction& p, BitModel& sign_model, BitModel* unary,
                               std::int32_t& correction, std::uint16_t& depth) noexcept;

  std::span<PixelRow> rows_;
  std::span<BlockState> blocks_;
  std::span<BlockPlane> planes_;
  std::span<BlockSurface> surfaces_;
  TileModels models_;
  ResidualModels residuals_;  ///< of lossless tiles
};

}  // namespace planecast
