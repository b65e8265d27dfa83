// The four stages as thin adaptors: slot fields in, algorithm, slot fields out. Each owns its
// scratch and runs on one thread at a time.
#pragma once

#include <cstdint>

#include "core/base/arena.hpp"
#include "core/filter/outlier_filter.hpp"
#include "core/fit/surface_fitter.hpp"
#include "core/pipeline/frame_slot.hpp"
#include "core/pipeline/list_stages.hpp"
#include "core/pipeline/stage_options.hpp"
#include "core/segment/region_growing.hpp"
#include "core/wire/frame_pack.hpp"
#include "core/wire/raw_pack.hpp"

namespace planecast {

/// A stamp as packets carry it: [ns] since the stream's epoch, modulo 2^48. Any two stamps.
constexpr std::uint64_t stamp_offset(std::int64_t stamp_ns, std::int64_t epoch_ns) noexcept {
  return (static_cast<std::uint64_t>(stamp_ns) - static_cast<std::uint64_t>(epoch_ns)) &
         0xffffffffffffU;
}

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
  /// What the last frame's fit was, for those who look into it.
  const SurfaceFitter& fitter() const noexcept { return fitter_; }

 private:
  const StreamTables* tables_ = nullptr;
  StageOptions options_;
  SurfaceFitter fitter_;
};

/// Slices of the frame, sealed.
class PackStage {
 public:
  static constexpr const char* kName = "pack";
  /// `workers`: threads of the options' team.
  void layout(Arena& arena, const FrameLimits& limits, FrameKind kind,
              std::uint32_t workers = 1) noexcept;
  void bind(const StreamTables& tables, const StageOptions& options) noexcept;
  Status process(FrameSlot& slot) noexcept;

 private:
  void learn_pace(const FrameSlot& slot) noexcept;
  PackDeadline deadline_of(const FrameSlot& slot) const noexcept;
  Status pack(const FrameIdentity& identity, FrameSlot& slot) noexcept;

  const StreamTables* tables_ = nullptr;
  StageOptions options_;
  FramePacker packer_;
  RawFramePacker raw_packer_;
  ListPack list_packer_;
};

}  // namespace planecast
