#include "core/pipeline/stages.hpp"

#include <algorithm>

#include "core/fit/on_surface.hpp"
#include "core/pipeline/stage_stats.hpp"

namespace planecast {
namespace {

// In blocks short enough to count in 16 bits, eight at a time.
std::uint32_t readings(std::span<const std::uint16_t> depth) noexcept {
  constexpr std::size_t kBlock = 4096;
  std::uint32_t sum = 0;
  for (std::size_t begin = 0; begin < depth.size(); begin += kBlock) {
    std::uint16_t here = 0;
    for (const std::uint16_t d : depth.subspan(begin, std::min(kBlock, depth.size() - begin)))
      here = static_cast<std::uint16_t>(here + (d != 0 ? 1 : 0));
    sum += here;
  }
  return sum;
}

// Plans a stage's effort at its start; learns at its end, and adds to what the frame has spent.
class TimedWork {
 public:
  TimedWork(FrameBudget* budget, TimedStage stage, FrameSlot& slot) noexcept
      : budget_(budget != nullptr && budget->limited() ? budget : nullptr),
        stage_(stage),
        slot_(slot) {
    if (budget_ == nullptr) return;
    begin_ns_ = budget_->now();
    slot_.effort = effort_ = budget_->plan(stage_, slot_.effort, slot_.spent_ns);
  }
  TimedWork(const TimedWork&) = delete;
  TimedWork& operator=(const TimedWork&) = delete;
  ~TimedWork() {
    if (budget_ == nullptr) return;
    const std::int64_t took = budget_->now() - begin_ns_;
    slot_.spent_ns += took;
    budget_->learn(stage_, effort_, took);
  }

 private:
  FrameBudget* budget_;
  TimedStage stage_;
  FrameSlot& slot_;
  FrameEffort effort_ = FrameEffort::kFull;  ///< planned
  std::int64_t begin_ns_ = 0;
};

// The filter's time has no effort to choose, but counts.
class FilterWork {
 public:
  FilterWork(FrameBudget* budget, FrameSlot& slot) noexcept
      : budget_(budget != nullptr && budget->limited() ? budget : nullptr), slot_(slot) {
    if (budget_ != nullptr) begin_ns_ = budget_->now();
  }
  FilterWork(const FilterWork&) = delete;
  FilterWork& operator=(const FilterWork&) = delete;
  ~FilterWork() {
    if (budget_ != nullptr) slot_.spent_ns += budget_->now() - begin_ns_;
  }

 private:
  FrameBudget* budget_;
  FrameSlot& slot_;
  std::int64_t begin_ns_ = 0;
};

}  // namespace

void FilterStage::layout(Arena& arena, const FrameLimits& limits, FrameKind kind) noexcept {
  if (kind == FrameKind::kDepth) filter_.layout(arena, limits.max_width, limits.max_height);
}

void FilterStage::bind(const StreamTables& tables, const StageOptions& options) noexcept {
  tables_ = &tables;
  options_ = options;
}

Status FilterStage::process(FrameSlot& slot) noexcept {
  slot.counts = {};
  const FrameKind kind = tables_->config().kind;
  if (kind == FrameKind::kPoints) return filter_list(tables_->config(), options_, slot);
  const FilterWork work(options_.budget, slot);
  if (kind != FrameKind::kDepth) return Status::kOk;
  slot.counts.input = readings(slot.depth);
  if (options_.range_min > 0 || options_.range_max < 65535) {
    slot.counts.out_of_range = apply_range_gate(slot.depth, options_.range_min, options_.range_max);
  }
  if (!options_.drop_outliers) return Status::kOk;  // flags that nobody reads cost a millisecond
  OutlierCounts outliers;
  const CameraModel& camera = tables_->config().camera;
  const Status status =
      filter_.process(slot.depth, camera.width, camera.height, {}, slot.outliers, outliers);
  if (status != Status::kOk) return status;
  slot.counts.outliers = outliers.outliers;
  slot.counts.outliers_dropped = drop_flagged(slot.depth, slot.outliers);
  return Status::kOk;
}

void SegmentStage::layout(Arena& arena, const FrameLimits& limits, FrameKind kind) noexcept {
  if (kind == FrameKind::kDepth) segmenter_.layout(arena, limits.max_width, limits.max_height);
}

void SegmentStage::bind(const StreamTables& tables, const StageOptions& options) noexcept {
  tables_ = &tables;
  options_ = options;
}

Status SegmentStage::process(FrameSlot& slot) noexcept {
  slot.regions = {};
  if (tables_->config().kind == FrameKind::kPoints)
    return segment_list(tables_->config(), options_, slot);
  if (tables_->config().kind != FrameKind::kDepth || !options_.surfaces) return Status::kOk;
  const TimedWork work(options_.budget, TimedStage::kSegment, slot);
  if (slot.effort >= FrameEffort::kNeighbours) return Status::kOk;
  RegionMap found;
  GrowingOptions options;
  options.curved = options_.curved && slot.effort == FrameEffort::kFull;
  const Status status =
      segmenter_.process(tables_->config(), tables_->rays(), slot.depth, found, options);
  if (status != Status::kOk) return status;
  // The segmenter goes on to the next frame while this one is fitted: the slot keeps its own copy.
  std::copy(found.cells.begin(), found.cells.end(), slot.cells.begin());
  std::copy(found.labels.begin(), found.labels.end(), slot.cell_labels.begin());
  slot.regions = found;
  slot.regions.cells = slot.cells.first(found.cells.size());
  slot.regions.labels = slot.cell_labels.first(found.labels.size());
  return Status::kOk;
}

void FitStage::layout(Arena& arena, const FrameLimits& limits, FrameKind kind) noexcept {
  if (kind == FrameKind::kDepth) fitter_.layout(arena, limits.max_width, limits.max_height);
}

void FitStage::bind(const StreamTables& tables, const StageOptions& options) noexcept {
  tables_ = &tables;
  options_ = options;
}

Status FitStage::process(FrameSlot& slot) noexcept {
  const StreamConfig& config = tables_->config();
  slot.surface_count = 0;
  slot.shift = 0;
  if (config.kind == FrameKind::kPoints) return fit_list(config, options_, slot);
  if (config.kind != FrameKind::kDepth) return Status::kOk;
  std::fill(slot.blocks.begin(), slot.blocks.end(), BlockLabel{});
  if (!options_.surfaces) return Status::kOk;
  const TimedWork work(options_.budget, TimedStage::kFit, slot);
  if (slot.effort >= FrameEffort::kNeighbours) return Status::kOk;
  const FitTables tables{&config, &tables_->rays(), &tables_->levels(), &tables_->bounds()};
  FitReport report;
  ConsensusOptions consensus;
  if (slot.effort != FrameEffort::kFull) consensus.trials = 0;
  Status status =
      fitter_.fit(tables, slot.depth, slot.regions, slot.blocks, slot.surfaces, report, consensus);
  if (status != Status::kOk) return status;
  slot.surface_count = report.surfaces;
  slot.shift = report.shift;
  if (config.tolerance != ToleranceKind::kSurfaces) return Status::kOk;
  SurfaceCounts counts;
  status = drop_off_surface(tables, slot.depth, slot.surfaces.first(slot.surface_count),
                            slot.blocks, config.drop_off_surface, counts);
  slot.counts.on_surface = counts.on;
  slot.counts.off_surface = counts.off;
  if (config.drop_off_surface) slot.counts.off_surface_dropped = counts.off;
  return status;
}

void PackStage::layout(Arena& arena, const FrameLimits& limits, FrameKind kind,
                       std::uint32_t workers) noexcept {
  switch (kind) {
    case FrameKind::kDepth:
      return packer_.layout(arena, limits.max_width, limits.max_height, workers);
    case FrameKind::kRawCloud:
      return raw_packer_.layout(arena, limits.max_width, limits.max_height);
    case FrameKind::kPoints:
      return list_packer_.layout(arena, limits);
  }
}

void PackStage::bind(const StreamTables& tables, const StageOptions& options) noexcept {
  tables_ = &tables;
  options_ = options;
}

PackDeadline PackStage::deadline_of(const FrameSlot& slot) const noexcept {
  PackDeadline deadline;
  if (options_.budget == nullptr || !options_.budget->limited()) return deadline;
  deadline.clock = options_.budget->now_function();
  deadline.end_ns = deadline.clock() + options_.budget->budget_ns() - slot.spent_ns;
  deadline.modelled_ns = options_.budget->measured(TimedStage::kPack, slot.effort);
  deadline.runs_ns = options_.budget->expected(TimedStage::kPack, FrameEffort::kRuns);
  return deadline;
}

Status PackStage::pack(const FrameIdentity& identity, FrameSlot& slot) noexcept {
  switch (tables_->config().kind) {
    case FrameKind::kDepth:
      return packer_.pack(tables_->coding(), slot.model(), identity, options_.slice_bytes,
                          slot.packed, slot.places, slot.report, deadline_of(slot), options_.team);
    case FrameKind::kRawCloud:
      return raw_packer_.pack(tables_->config(), slot.points, identity, options_.slice_bytes,
                              slot.packed, slot.places, slot.report);
    case FrameKind::kPoints:
      break;
  }
  return list_packer_.process(*tables_, options_, identity, slot);
}

// What the whole frame would have taken with models alone, and by runs alone.
void PackStage::learn_pace(const FrameSlot& slot) noexcept {
  const PackPace& pace = slot.report.pace;
  const CameraModel& camera = tables_->config().camera;
  const std::int64_t blocks = std::int64_t{blocks_wide(camera)} * blocks_high(camera);
  if (pace.modelled_blocks > 0) {
    options_.budget->learn(TimedStage::kPack, slot.effort,
                           pace.modelled_ns * blocks / pace.modelled_blocks);
  }
  if (pace.run_blocks > 0) {
    options_.budget->learn(TimedStage::kPack, FrameEffort::kRuns,
                           pace.runs_ns * blocks / pace.run_blocks);
  }
}

Status PackStage::process(FrameSlot& slot) noexcept {
  const StreamConfig& config = tables_->config();
  const FrameIdentity identity{config.stream, static_cast<std::uint32_t>(slot.number),
                               stamp_offset(slot.stamp_ns, config.epoch_ns), tables_->key_hash()};
  slot.report = {};
  const Status status = pack(identity, slot);
  if (options_.budget != nullptr && status == Status::kOk) learn_pace(slot);
  if (slot.report.run_tiles > 0) slot.effort = FrameEffort::kRuns;
  if (status != Status::kOk) slot.report = {};  // slices of half a frame are none
  if (config.kind == FrameKind::kRawCloud) slot.counts.input = slot.report.points;
  slot.counts.kept = slot.report.points;
  slot.packed_ns = steady_now_ns();
  return status;
}

}  // namespace planecast
