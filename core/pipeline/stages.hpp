// The four stages as thin adaptors: slot fields in, algorithm, slot fields out. Each owns its
// scratch and runs on one thread at a time.
#pragma once

#include <cstdint>

#include "core/base/arena.hpp"
#include "core/filter/outlier_filter.hpp"
#include "core/fit/surface_fitter.hpp"
#include "core/pipeline/frame_slot.hpp"
#include "core/segment/region_growing.hpp"
#include "core/wire/frame_pack.hpp"
#include "core/wire/raw_pack.hpp"

namespace planecast {

/// A stamp as packets carry it: [ns] since the stream's epoch, modulo 2^48. Any two stamps.
constexpr std::uint64_t stamp_offset(std::int64_t stamp_ns, std::int64_t epoch_ns) noexcept {
  return (static_cast<std::uint64_t>(stamp_ns) - static_cast<std::uint64_t>(epoch_ns)) &
         0xffffffffffffU;
}

/// What stages need to know beside the stream's tables.
struct StageOptions {
  std::size_t slice_bytes = 1190;  ///< most bytes of a slice, header included
  std::uint16_t range_min = 0;     ///< [counts] readings outside become holes
  std::uint16_t range_max = 65535;
  bool drop_outliers = false;
  bool surfaces = true;           ///< false: neighbour prediction only
  bool curved = true;             ///< surfaces of degree two where they pay
  FrameBudget* budget = nullptr;  ///< shared by the stages of one encoder; none = no limit
};

/// Range gate and statistical outlier filter.
class FilterStage {
 public:
  static constexpr const char* kName = "filter";
  void layout(Arena& arena, const FrameLimits& limits, FrameKind kind) noexcept;
  void bind(const StreamTables& tables, const StageOptions& options) noexcept;
  Status process(FrameSlot& slot) noexcept;

 private:
  const StreamTables* tables_ = nullptr;
  StageOptions options_;
  OutlierFilter filter_;
};

/// Cells and seeded region growing.
class SegmentStage {
 public:
  static constexpr const char* kName = "segment";
  void layout(Arena& arena, const FrameLimits& limits, FrameKind kind) noexcept;
  void bind(const StreamTables& tables, const StageOptions& options) noexcept;
  Status process(FrameSlot& slot) noexcept;

 private:
  const StreamTables* tables_ = nullptr;
  StageOptions options_;
  Segmenter segmenter_;
};

/// Least squares, consensus, quantised surfaces, block labels by cost; in the surfaces contract,
/// what lies on none is counted and, when asked, dropped.
class FitStage {
 public:
  static constexpr const char* kName = "fit";
  void layout(Arena& arena, const FrameLimits& limits, FrameKind kind) noexcept;
  void bind(const StreamTables& tables, const StageOptions& options) noexcept;
  Status process(FrameSlot& slot) noexcept;

 private:
  const StreamTables* tables_ = nullptr;
  StageOptions options_;
  SurfaceFitter fitter_;
};

/// Slices of the frame, sealed.
class PackStage {
 public:
  static constexpr const char* kName = "pack";
  void layout(Arena& arena, const FrameLimits& limits, FrameKind kind) noexcept;
  void bind(const StreamTables& tables, const StageOptions& options) noexcept;
  Status process(FrameSlot& slot) noexcept;

 private:
  const StreamTables* tables_ = nullptr;
  StageOptions options_;
  FramePacker packer_;
  RawFramePacker raw_packer_;
};

}  // namespace planecast
