// Codes one tile of a depth frame: quantises its pixels in the decoder's own arithmetic, then
// entropy-codes the result (docs/wire-format.md, "Tile"). Encoder half.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/wire/flat_fit.hpp"
#include "core/wire/mix_pack.hpp"
#include "core/wire/pixel_decision.hpp"
#include "core/wire/range_encoder.hpp"
#include "core/wire/residual_models.hpp"
#include "core/wire/tile_content.hpp"
#include "core/wire/tile_fill.hpp"
#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// Working memory of one packer, taken from the arena at start; used by one thread.
class TilePacker {
 public:
  void layout(Arena& arena, std::uint32_t max_width) noexcept;

  /// Codes `rect` of the frame into `out`; where `fill` allows it, as many of its upper rows of
  /// blocks as fit (TileReport::rows). kTooLarge when `out` is too small for that (the caller
  /// splits the tile); otherwise kOk. No allocation.
  Status pack(const CodingTables& tables, const FrameModel& frame, const TileRect& rect,
              std::span<std::uint8_t> out, TileReport& report, const TileFill& fill = {}) noexcept;

  /// Codes `rect` by runs, in 40 to 50 % of the time of pack() (bench/budget_times). kTooLarge as
  /// pack().
  Status pack_runs(const CodingTables& tables, const FrameModel& frame, const TileRect& rect,
                   std::span<std::uint8_t> out, TileReport& report) noexcept;

 private:
  enum class PixelKind : std::uint8_t { kPredicted, kFirstSurface, kSecondSurface };
  enum class SegmentKind : std::uint8_t { kPlain, kOnSurface, kChoosing };
  /// What is to be coded of one pixel of a lossless tile, in one word: a store in parts would stall
  /// the load of the whole.
  struct Residual {
    std::uint64_t word = 0;
    Residual() = default;
    Residual(std::uint32_t shape, std::uint32_t errors, ResidualSymbol coded,
             std::uint8_t mask) noexcept
        : word(errors | shape << 16U | std::uint64_t{coded.symbol} << 32U |
               std::uint64_t{coded.extra} << 40U | std::uint64_t{mask} << 48U | kReading) {}
    /// A hole.
    explicit Residual(std::uint8_t mask) noexcept : word(std::uint64_t{mask} << 48U) {}

    std::uint32_t errors() const noexcept { return word & 0xffffU; }
    std::uint32_t shape() const noexcept { return (word >> 16U) & 0xffffU; }
    int symbol() const noexcept { return static_cast<int>((word >> 32U) & 0xffU); }
    std::uint32_t extra() const noexcept { return (word >> 40U) & 0xffU; }
    std::uint32_t mask() const noexcept { return (word >> 48U) & 0xffU; }
    bool reading() const noexcept { return (word & kReading) != 0; }

   private:
    static constexpr std::uint64_t kReading = std::uint64_t{1} << 56U;
  };
  /// Where a correction is too far for steps; in coding order.
  struct Jump {
    std::int32_t levels = 0;  ///< 0: the count itself follows
    std::uint16_t raw_depth = 0;
  };
  /// How a flat block's plane is coded.
  struct FlatChoice {
    FlatCode code;
    PlaneContexts contexts{PlaneHints{}};
  };
  struct Job;
  struct Segment;

  Status pack_plain(const CodingTables& tables, const FrameModel& frame, const TileRect& rect,
                    std::span<std::uint8_t> out, TileReport& report, const TileFill& fill) noexcept;
  void code_rows(Job& job, RangeEncoder& coder, FillGate& gate) noexcept;
  Status store(const CodingTables& tables, const FrameModel& frame, const TileRect& rect,
               std::span<std::uint8_t> out, TileReport& report) noexcept;
  void code_head(Job& job, RangeEncoder& coder, std::uint32_t label_rows) noexcept;
  void open_block_row(Job& job, std::uint32_t row) noexcept;
  void try_flat(Job& job, std::uint32_t row, std::uint32_t i) noexcept;
  BlockState* blocks_at(const Job& job, std::uint32_t v) noexcept;
  void quantise_bounded_row(Job& job, std::uint32_t v) noexcept;
  void quantise_holes(Job& job, TileRows rows, std::uint32_t x0, std::uint32_t x1,
                      const std::uint16_t* depths) noexcept;
  void quantise_bounded(Job& job, TileRows rows, const Segment& segment) noexcept;
  template <SegmentKind kKind>
  void quantise_segment(Job& job, TileRows rows, const Segment& segment) noexcept;
  PixelKind choose_surface(const Job& job, const Segment& segment, std::uint32_t x,
                           std::uint16_t depth, PixelRow& row) const noexcept;
  void code_block_row(Job& job, RangeEncoder& shared, std::uint32_t row) noexcept;
  void code_block(const Job& job, RangeEncoder& coder, const BlockState& block,
                  const BlockNeighbours& n, const FlatChoice& flat) noexcept;
  void drop_decisions(const Job& job, const BlockState* blocks, std::uint32_t rows) noexcept;
  void code_decisions(RangeEncoder& shared) noexcept;
  void quantise_lossless_row(Job& job, std::uint32_t v) noexcept;
  template <bool kEveryCount>
  void quantise_residuals(Job& job, TileRows rows, const Segment& segment,
                          Residual* residuals) noexcept;
  template <bool kEveryCount>
  void code_residuals(RangeEncoder& coder, const BlockState& block, const Residual* residuals,
                      std::uint32_t count) noexcept;
  void code_lossless_row(const Job& job, RangeEncoder& shared, const BlockState* blocks,
                         std::uint32_t rows) noexcept;
  void code_jump(RangeEncoder& coder, const Jump& jump) noexcept;

  std::span<PixelRow> rows_;            ///< three rows with borders
  std::span<PixelDecision> decisions_;  ///< of a block row's pixels, in coding order
  std::uint32_t decided_ = 0;           ///< of decisions_ in use
  std::span<std::uint32_t> ends_;       ///< in decisions_, of each block in each of eight rows
  std::span<Residual> found_;           ///< eight rows of a lossless tile
  std::span<Jump> jumps_;               ///< of a block row
  std::uint32_t jumps_in_ = 0, jumps_out_ = 0;
  std::span<BlockState> blocks_;      ///< two block rows
  std::span<BlockPlane> planes_;      ///< of flat blocks, beside blocks_
  std::span<FlatChoice> flats_;       ///< of a block row
  std::span<BlockSurface> surfaces_;  ///< one for each block of a block row
  TileModels models_;
  ResidualModels residuals_;  ///< of lossless tiles
  MixPacker mix_;             ///< of `--effort best`
};

}  // namespace planecast
