// Cuts a frame into slices that decode alone and codes each (docs/wire-format.md, "Frame").
// Encoder half.
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/base/work_team.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/tile_pack.hpp"

namespace planecast {

/// Smallest slice limit: one block stored verbatim, with its header, fits.
inline constexpr std::size_t kMinSliceBytes = 256;
/// Slice limit of the file form: as few slices as the format allows.
inline constexpr std::size_t kFileSliceBytes = std::size_t{1} << 24U;

/// Parts that a frame is cut into before any is packed: enough that two workers end together.
inline constexpr std::uint32_t kMaxFrameParts = 8;

/// Identity of a frame on the wire.
struct FrameIdentity {
  std::uint8_t stream = 0;
  std::uint32_t frame = 0;
  std::uint64_t stamp_offset = 0;
  std::uint32_t key_hash = 0;
};

/// One packed slice within the frame's buffer.
struct SlicePlace {
  std::uint32_t offset = 0;
  std::uint32_t bytes = 0;
};

/// When a frame must be packed. Tiles that begin so late that coding the rest by runs would just
/// end in time are coded by runs as well: nothing is lost but bytes.
struct PackDeadline {
  std::int64_t (*clock)() noexcept = nullptr;  ///< none = no limit; [ns]
  std::int64_t end_ns = 0;
  std::int64_t modelled_ns = 0;  ///< what frames like this one took with models; 0 = not known
  std::int64_t runs_ns = 0;      ///< what a whole frame takes by runs
};

/// What packing took, tile by tile [ns]: to plan the next frame by.
struct PackPace {
  std::int64_t modelled_ns = 0, runs_ns = 0;
  std::uint32_t modelled_blocks = 0, run_blocks = 0;
};

/// What packing a frame gave.
struct FrameReport {
  std::uint32_t slices = 0;
  std::size_t bytes = 0;  ///< all slices, headers included
  std::uint32_t points = 0;
  std::uint32_t corrections = 0;  ///< points with a correction that is not zero
  std::uint32_t surfaces = 0;
  std::uint32_t run_tiles = 0;  ///< coded by runs, for want of time
  PackPace pace;                ///< with a deadline only
};

/// Bytes that a frame can never exceed, whatever its content.
std::size_t frame_capacity(std::uint32_t width, std::uint32_t height) noexcept;
/// Slices that a frame can never exceed: one a block, at most 65535.
std::size_t slice_capacity(std::uint32_t width, std::uint32_t height) noexcept;

/// Packs frames of one stream; keeps a running estimate of how its bytes fall, so that tiles fit
/// their slices at the first try. One thread; memory from the arena at start.
class FramePacker {
 public:
  /// `workers`: how many threads a team given to pack() has, 1 to kMaxTeamWorkers.
  void layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height,
              std::uint32_t workers = 1) noexcept;

  /// Packs `frame` into `out` as slices of at most `slice_bytes` (kMinSliceBytes or more), each
  /// sealed. `places` receives them in order; they fill `out` without gaps unless a team shared the
  /// work, and are the same either way. With a deadline the caller works alone, and so where `out`
  /// is below frame_capacity() or `places` below a slice a block. kTooLarge: `out` or `places` is
  /// too small. No allocation.
  Status pack(const CodingTables& tables, const FrameModel& frame, const FrameIdentity& identity,
              std::size_t slice_bytes, std::span<std::uint8_t> out, std::span<SlicePlace> places,
              FrameReport& report, const PackDeadline& deadline = {},
              const WorkTeam& team = {}) noexcept;

 private:
  struct Job;
  struct Part;
  /// Estimated costs in 1/16 bit: of blocks on no surface, and of blocks on one.
  struct Costs {
    std::uint32_t of[2] = {};
  };

  void estimate_costs(const CodingTables& tables, const FrameModel& frame) noexcept;
  std::array<double, 2> costs(const Job& job, const TileRect& rect) const noexcept;
  double estimate(const Job& job, const TileRect& rect) const noexcept;
  Status pack_whole(Job& job) noexcept;
  void plan_parts(Job& job) const noexcept;
  Status pack_part(Part& part) noexcept;
  Status pack_column(Part& part, TileRect rest) noexcept;
  Status pack_slice(Part& part, const TileRect& rect, bool by_runs, const TileFill& fill,
                    TileReport& tile) noexcept;
  void pack_shared(Job& job) noexcept;
  void pack_alone(Job& job) noexcept;
  Status join(Job& job) const noexcept;
  void calibrate(const Job& job, double share) noexcept;
  static double budget_bits(const Job& job) noexcept;
  static bool too_late(const Part& part, const TileRect& rect) noexcept;
  static std::uint32_t smallest_tile(const Job& job) noexcept;
  static bool small_enough(const Job& job, const TileRect& rect, bool late) noexcept;
  bool likely_fits(const Job& job, const TileRect& rect, bool by_runs) const noexcept;
  std::array<TileRect, 2> halves(const Job& job, const TileRect& rect) const noexcept;
  Status pack_rect(Part& part, const TileRect& rect) noexcept;
  Status pack_tile(Part& part, const TileRect& rect, bool by_runs, const TileFill& fill,
                   TileReport& tile) noexcept;
  Status pack_halves(Part& part, const TileRect& rect) noexcept;

  std::array<TilePacker, kMaxTeamWorkers> tiles_;
  std::span<Costs> cost_sums_;  ///< summed-area table of block costs, one more each way
  double run_scale_ = 4;        ///< of tiles coded by runs: their bits over those of the others
  double scales_[2] = {1, 1};   ///< measured bits over estimated bits, off surfaces and on
  bool calibrated_ = false;     ///< scales_ come from a frame
};

}  // namespace planecast
