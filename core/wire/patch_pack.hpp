// Rounds the surfaces of an unorganised cloud to integers and packs them into slices that decode
// alone (docs/wire-format.md, "Patches"). Encoder half.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/model/patch_draft.hpp"
#include "core/wire/frame_pack.hpp"
#include "core/wire/patch_syntax.hpp"
#include "core/wire/range_encoder.hpp"

namespace planecast {

/// How surfaces become patches.
struct PatchPackOptions {
  std::uint8_t height_log2 = 3;  ///< surfaces are rounded to 2^this steps
};

/// Packs the patches of one stream. One thread; memory from the arena at start (about 0.3 MB).
class PatchPacker {
 public:
  void layout(Arena& arena) noexcept;

  /// Appends slices of at most `slice_bytes` (kMinSliceBytes or more) that hold `drafts`, whose
  /// cells are in `cells`, to `out` behind report.bytes, and their places to `places` behind
  /// report.slices; adds to the report. Each slice keeps room for its header, which the caller
  /// seals once it knows how many slices the frame has. Patches too large for a slice are cut, each
  /// part with its own boundary and count: together they hold as many points as before.
  /// kBadConfig: slice_bytes; kFieldRange: a draft outside the format's range; kTooLarge: `out` or
  /// `places` is too small. O(cells), no allocation.
  Status pack(std::span<const PatchDraft> drafts, std::span<const DraftCell> cells,
              const PatchPackOptions& options, std::size_t slice_bytes, std::span<std::uint8_t> out,
              std::span<SlicePlace> places, FrameReport& report) noexcept;

 private:
  struct Job;
  struct Part;
  struct Rect {
    std::uint32_t draft = 0, i0 = 0, j0 = 0, i1 = 0, j1 = 0;
  };

  Part make_part(const Job& job, const Rect& rect) noexcept;
  bool split(const Job& job, const Rect& rect) noexcept;
  Status add(Job& job, const Rect& rect) noexcept;
  void code_part(Job& job, const Part& part, RangeEncoder& coder) noexcept;
  Status close(Job& job) noexcept;

  std::span<std::uint8_t> cells_;  ///< of the part at hand
  std::span<std::uint8_t> trial_;  ///< bytes of the slice being filled
  std::span<Rect> slice_;          ///< parts of the slice being filled
  std::span<Rect> waiting_;        ///< parts not yet tried, the next one last
  std::uint32_t in_slice_ = 0, waits_ = 0;
};

/// Rounds `draft`, cut to cells [i0, i1) x [j0, j1) of its grid, to integers; points is left 0.
Patch round_patch(const PatchDraft& draft, std::uint32_t i0, std::uint32_t j0, std::uint32_t i1,
                  std::uint32_t j1, std::uint8_t height_log2) noexcept;

}  // namespace planecast
