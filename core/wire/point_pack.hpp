// Packs unorganised points to a bound (docs/wire-format.md, "Point tile"). Encoder half.
//
// The contract, all in grid steps:
// - As many points come out of a frame's slices as went in; their order is not kept.
// - Every point that went in has one that comes out within coding.tolerance, and every point that
//   comes out has one that went in within it (Euclidean). Whoever made the grid takes its rounding
//   and that of the float output off the tolerance beforehand.
// - Tolerance 0: the points that come out are those that went in, each as often as it went in.
// - Slices decode alone and in any order; a lost slice loses its own points and no others.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/model/grid_point.hpp"
#include "core/wire/frame_pack.hpp"
#include "core/wire/point_axes_pack.hpp"
#include "core/wire/point_levels.hpp"
#include "core/wire/point_models.hpp"
#include "core/wire/z_order.hpp"

namespace planecast {

/// Smallest slice limit of point streams.
inline constexpr std::size_t kMinPointSliceBytes = 256;

/// Bytes that the point slices of a frame can never exceed, whatever its content.
std::size_t point_frame_capacity(std::uint32_t max_points) noexcept;
/// Slices that a frame of points can never exceed at `slice_bytes` a slice; at most 65535.
std::size_t point_slice_capacity(std::uint32_t max_points, std::size_t slice_bytes) noexcept;

/// Writes header and check of every slice of a finished frame: places[i] becomes slice i of
/// places.size(). For frames whose slices come from more than one packer.
void seal_slices(const FrameIdentity& identity, std::span<const SlicePlace> places,
                 std::span<std::uint8_t> packed) noexcept;

/// Packs the points of one stream's frames. One thread; memory from the arena at start, known
/// from max_points.
class PointFramePacker {
 public:
  void layout(Arena& arena, std::uint32_t max_points) noexcept;

  /// Packs `points` as slices of at most `slice_bytes` each, headers included (kMinPointSliceBytes
  /// or more; kFileSliceBytes for files). Goes on after what `report` counts: its slices and bytes
  /// are already in `places` and `packed` (none: report is {}), and all are sealed in the end as
  /// one frame. A frame without any point is one slice of none. kBadConfig: tolerance or
  /// slice_bytes out of range; kFrameTooLarge: more points than the layout or the coding allows;
  /// kTooLarge: `packed` (point_frame_capacity) or `places` (point_slice_capacity) is too small, or
  /// more than 65535 slices. O(n log n) at worst, no allocation.
  Status pack(const PointCoding& coding, std::span<const GridPoint> points,
              const FrameIdentity& identity, std::size_t slice_bytes,
              std::span<std::uint8_t> packed, std::span<SlicePlace> places,
              FrameReport& report) noexcept;

 private:
  struct Job;

  Status sort_points(Job& job) noexcept;
  Status pack_slices(Job& job) noexcept;
  Status pack_some(Job& job, std::uint32_t first, std::uint32_t& count) noexcept;
  bool code_tree(const Job& job, std::span<const ZKey> cells, std::span<std::uint8_t> room,
                 std::size_t& bytes) noexcept;
  Status close_slice(Job& job, std::span<const ZKey> cells, std::size_t bytes) noexcept;

  CellChooser chooser_;
  FrameCells cells_;
  std::span<ZKey> keys_;  ///< cells in Z-order, each with the number of its points
  std::span<ZKey> spare_;
  std::uint32_t cell_count_ = 0;
  std::uint32_t cell_bits_q4_ = 4 * 16;  ///< measured bits of a cell, for the next slice's length
  PointLevels levels_;
  std::span<PointModels> models_;  ///< one
  PointMixers mixers_;
};

}  // namespace planecast
