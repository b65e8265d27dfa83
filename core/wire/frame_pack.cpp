#include "core/wire/frame_pack.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

#include "core/wire/frame_pack_cost.hpp"
#include "core/wire/frame_pack_job.hpp"

namespace planecast {
namespace {

constexpr double kFill = 7.2;  // bits planned for each byte of a slice whose tile must fit whole
// Against a deadline a tile that is coded by runs, or at an unknown pace, is no more than this
// share of a frame, and a tile may take this much longer than those before it.
constexpr std::uint32_t kDeadlineTiles = 32;
constexpr double kSlowTile = 1.5;
constexpr std::size_t kMostBlockBytes = 64 * 2 + 8 + kPacketHeaderBytes;  // a slice of its own

std::uint32_t ceil_blocks(std::uint32_t pixels) noexcept {
  return (pixels + 7) / 8;
}

}  // namespace

std::size_t frame_capacity(std::uint32_t width, std::uint32_t height) noexcept {
  const std::size_t blocks = std::size_t{ceil_blocks(width)} * ceil_blocks(height);
  return blocks * kMostBlockBytes + kMaxFrameParts * kMinSliceBytes;
}

std::size_t slice_capacity(std::uint32_t width, std::uint32_t height) noexcept {
  return std::min<std::size_t>(std::size_t{ceil_blocks(width)} * ceil_blocks(height), 65535);
}

void FramePacker::layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height,
                         std::uint32_t workers) noexcept {
  for (std::uint32_t i = 0; i < workers; ++i) tiles_[i].layout(arena, max_width);
  cost_sums_ =
      arena.take<Costs>((std::size_t{ceil_blocks(max_width)} + 1) * (ceil_blocks(max_height) + 1));
}

Status FramePacker::pack(const CodingTables& tables, const FrameModel& frame,
                         const FrameIdentity& identity, std::size_t slice_bytes,
                         std::span<std::uint8_t> out, std::span<SlicePlace> places,
                         FrameReport& report, const PackDeadline& deadline,
                         const WorkTeam& team) noexcept {
  if (slice_bytes < kMinSliceBytes) return Status::kBadConfig;
  std::array<Part, kMaxFrameParts> parts;
  Job job{tables, frame, slice_bytes, out, places, report, team};
  job.packer = this;
  job.parts = &parts;
  const CameraModel& camera = tables.config->camera;
  job.blocks = blocks_wide(camera) * blocks_high(camera);
  job.one_slice = slice_bytes >= frame_capacity(camera.width, camera.height) &&
                  std::max(camera.width, camera.height) <= kMaxTileSide &&
                  deadline.clock == nullptr;
  job.deadline = deadline;
  if (!job.one_slice) estimate_costs(tables, frame);
  Status status = pack_whole(job);
  if (status == Status::kOk && !calibrated_ && report.slices > 1 && deadline.clock == nullptr) {
    // The first frame was cut by guess; now that its cost is known, cut it again.
    calibrated_ = true;
    calibrate(job, 1);
    status = pack_whole(job);
  }
  if (status != Status::kOk) return status;
  for (std::uint32_t i = 0; i < report.slices; ++i) {
    PacketHeader header{false,
                        identity.stream,
                        identity.frame & kFrameNumberMask,
                        identity.stamp_offset,
                        static_cast<std::uint16_t>(i),
                        static_cast<std::uint16_t>(report.slices),
                        identity.key_hash};
    seal_packet(header, out.subspan(places[i].offset, places[i].bytes));
  }
  calibrate(job, 4);
  return Status::kOk;
}

// The parts are the same whoever packs them, and so are their slices: bytes do not depend on
// threads.
Status FramePacker::pack_whole(Job& job) noexcept {
  job.report = {};
  job.report.surfaces = static_cast<std::uint32_t>(job.frame.surfaces.size());
  job.part_count = 0;
  plan_parts(job);
  const CameraModel& camera = job.tables.config->camera;
  const bool roomy = job.out.size() >= frame_capacity(camera.width, camera.height) &&
                     job.places.size() >= job.blocks;
  if (job.team.shared() && job.part_count > 1 && roomy) {
    pack_shared(job);
  } else {
    pack_alone(job);
  }
  return join(job);
}

void FramePacker::pack_shared(Job& job) noexcept {
  std::size_t offset = 0, place = 0;
  for (std::uint32_t i = 0; i < job.part_count; ++i) {
    Part& part = (*job.parts)[i];
    const std::size_t blocks = std::size_t{part.rect.bw} * part.rect.bh;
    const std::size_t bytes = blocks * kMostBlockBytes + kMinSliceBytes;
    part.out = job.out.subspan(offset, bytes);
    part.places = job.places.subspan(place, blocks);
    offset += bytes;
    place += blocks;
  }
  job.team.run(
      job.part_count,
      [](void* self, std::uint32_t i, std::uint32_t worker) noexcept {
        auto& whole = *static_cast<Job*>(self);
        Part& part = (*whole.parts)[i];
        part.tiles = &whole.packer->tiles_[worker];
        part.status = whole.packer->pack_part(part);
      },
      &job);
}

void FramePacker::pack_alone(Job& job) noexcept {
  std::size_t offset = 0, place = 0;
  for (std::uint32_t i = 0; i < job.part_count; ++i) {
    Part& part = (*job.parts)[i];
    part.tiles = tiles_.data();
    part.out = job.out.subspan(offset);
    part.places = job.places.subspan(place);
    part.status = pack_part(part);
    if (part.status != Status::kOk) return;
    offset += part.report.bytes;
    place += part.report.slices;
  }
}

// Slices of all parts in a row: their bytes stay where they are, their places move together.
Status FramePacker::join(Job& job) const noexcept {
  FrameReport& all = job.report;
  for (std::uint32_t i = 0; i < job.part_count; ++i) {
    const Part& part = (*job.parts)[i];
    if (part.status != Status::kOk) return part.status;
    const auto begin = static_cast<std::uint32_t>(part.out.data() - job.out.data());
    // 65535 slices, not one a block, are the most of a frame.
    if (all.slices + part.report.slices > 65535) return Status::kTooLarge;
    for (std::uint32_t s = 0; s < part.report.slices; ++s)
      job.places[all.slices++] = {begin + part.places[s].offset, part.places[s].bytes};
    all.bytes += part.report.bytes;
    all.points += part.report.points;
    all.corrections += part.report.corrections;
    all.run_tiles += part.report.run_tiles;
    if (job.deadline.clock != nullptr) all.pace = part.report.pace;  // the only part
  }
  return Status::kOk;
}

// Moves both scales towards those that fit this frame's tiles best, by one in `share`.
void FramePacker::calibrate(const Job& job, double share) noexcept {
  PackMoments m;
  for (std::uint32_t i = 0; i < job.part_count; ++i) m.add((*job.parts)[i].moments);
  const double ridge = 1e-3 * (m.aa + m.bb) + 1;  // keeps a kind that hardly occurs near the mean
  const double mean = (m.ay + m.by) / (m.aa + 2 * m.ab + m.bb + 1);
  const double aa = m.aa + ridge, bb = m.bb + ridge;
  const double ay = m.ay + ridge * mean, by = m.by + ridge * mean;
  const double det = aa * bb - m.ab * m.ab;
  const auto move = [&](double& scale, double found) {
    scale += (std::clamp(found, 0.1, 8.0) - scale) / share;
  };
  if (m.aa + m.bb == 0 || !(det > 0)) return;
  move(scales_[0], (ay * bb - by * m.ab) / det);
  move(scales_[1], (by * aa - ay * m.ab) / det);
}

void FramePacker::estimate_costs(const CodingTables& tables, const FrameModel& frame) noexcept {
  const std::uint32_t wide = blocks_wide(tables.config->camera);
  const std::uint32_t high = blocks_high(tables.config->camera);
  std::fill_n(cost_sums_.begin(), wide + 1, Costs{});
  for (std::uint32_t by = 0; by < high; ++by) {
    Costs row;
    const Costs* above = &cost_sums_[std::size_t{by} * (wide + 1)];
    Costs* sums = &cost_sums_[std::size_t{by + 1} * (wide + 1)];
    sums[0] = {};
    for (std::uint32_t bx = 0; bx < wide; ++bx) {
      const bool labelled = frame.blocks[std::size_t{by} * wide + bx].first != 0;
      row.of[labelled ? 1 : 0] += block_cost(tables, frame, bx, by);
      for (int kind = 0; kind < 2; ++kind)
        sums[bx + 1].of[kind] = above[bx + 1].of[kind] + row.of[kind];
    }
  }
}

// Costs of a rectangle, in bits before scaling.
std::array<double, 2> FramePacker::costs(const Job& job, const TileRect& r) const noexcept {
  const std::size_t stride = std::size_t{blocks_wide(job.tables.config->camera)} + 1;
  const auto at = [&](std::uint32_t bx, std::uint32_t by, int kind) {
    return cost_sums_[by * stride + bx].of[kind];
  };
  std::array<double, 2> out{};
  for (int k = 0; k < 2; ++k) {
    out[static_cast<std::size_t>(k)] = (at(r.bx + r.bw, r.by + r.bh, k) - at(r.bx, r.by + r.bh, k) -
                                        at(r.bx + r.bw, r.by, k) + at(r.bx, r.by, k)) /
                                       16.0;
  }
  return out;
}

double FramePacker::estimate(const Job& job, const TileRect& r) const noexcept {
  const auto [off, on] = costs(job, r);
  return off * scales_[0] + on * scales_[1];
}

// What a slice is planned to hold; estimates err by some percent.
double FramePacker::budget_bits(const Job& job) noexcept {
  return static_cast<double>(job.slice_bytes - kPacketHeaderBytes) * kFill - kTileHeadBits;
}

// Whether what is left could not be coded by runs in time any more after coding this tile with
// models, at the pace so far or that of frames before, whichever is slower.
bool FramePacker::too_late(const Part& part, const TileRect& rect) noexcept {
  const Job& job = *part.job;
  const PackDeadline& deadline = job.deadline;
  if (deadline.clock == nullptr) return false;
  const PackPace& pace = part.report.pace;
  const double tile = rect.bw * rect.bh, blocks = job.blocks;
  const double left = blocks - tile - pace.modelled_blocks - pace.run_blocks;
  double modelled = static_cast<double>(deadline.modelled_ns) / blocks;
  if (pace.modelled_blocks > 0)
    modelled = std::max(modelled, static_cast<double>(pace.modelled_ns) / pace.modelled_blocks);
  if (modelled == 0 && rect.bw * rect.bh > smallest_tile(job)) return true;
  const double needed =
      kSlowTile * modelled * tile + static_cast<double>(deadline.runs_ns) * left / blocks;
  return needed > static_cast<double>(deadline.end_ns - deadline.clock());
}

// In blocks: what lateness does not make smaller.
std::uint32_t FramePacker::smallest_tile(const Job& job) noexcept {
  return std::max(job.blocks / kDeadlineTiles, 1U);
}

// Whether a tile may be so large, by the syntax and against a deadline.
bool FramePacker::small_enough(const Job& job, const TileRect& rect, bool late) noexcept {
  return rect.bw <= kMaxTileBlocks && rect.bh <= kMaxTileBlocks &&
         (!late || rect.bw * rect.bh <= smallest_tile(job));
}

bool FramePacker::likely_fits(const Job& job, const TileRect& rect, bool by_runs) const noexcept {
  return job.one_slice || estimate(job, rect) * (by_runs ? run_scale_ : 1) <= budget_bits(job);
}

Status FramePacker::pack_rect(Part& part, const TileRect& rect) noexcept {
  const Job& job = *part.job;
  const bool single = rect.bw == 1 && rect.bh == 1;
  const bool late = too_late(part, rect);
  if (!single && !(small_enough(job, rect, late) && likely_fits(job, rect, late)))
    return pack_halves(part, rect);

  TileReport tile;
  const Status status = pack_slice(part, rect, late, {}, tile);
  return status == Status::kTooLarge && !single ? pack_halves(part, rect) : status;
}

// One slice more: all of `rect`, or as much of it as `fill` allows.
Status FramePacker::pack_slice(Part& part, const TileRect& rect, bool by_runs, const TileFill& fill,
                               TileReport& tile) noexcept {
  const Job& job = *part.job;
  FrameReport& report = part.report;
  if (report.slices >= part.places.size()) return Status::kTooLarge;
  const auto offset = static_cast<std::uint32_t>(report.bytes);
  const Status status = pack_tile(part, rect, by_runs, fill, tile);
  if (status != Status::kOk) return status;
  const auto bytes = static_cast<std::uint32_t>(kPacketHeaderBytes + tile.bytes);
  part.places[report.slices++] = {offset, bytes};
  report.bytes += bytes;
  report.points += tile.points;
  report.corrections += tile.corrections;
  report.run_tiles += by_runs ? 1 : 0;
  if (job.one_slice) return Status::kOk;
  const double bits = static_cast<double>(tile.bytes) * 8 - kTileHeadBits;
  TileRect coded = rect;
  coded.bh = tile.rows;
  if (by_runs) {
    const double ratio = bits / std::max(estimate(job, coded), 1.0);
    run_scale_ += (std::clamp(ratio, 1.0, 64.0) - run_scale_) / 16;
    return Status::kOk;
  }
  const auto [off, on] = costs(job, coded);
  part.moments.add(off, on, bits);
  return Status::kOk;
}

// Codes a tile into the room that is left for its slice; measures how long, against a deadline.
Status FramePacker::pack_tile(Part& part, const TileRect& rect, bool by_runs, const TileFill& fill,
                              TileReport& tile) noexcept {
  const Job& job = *part.job;
  const std::size_t body = part.report.bytes + kPacketHeaderBytes;
  if (part.out.size() < body) return Status::kTooLarge;
  const auto into = part.out.subspan(
      body, std::min(job.slice_bytes - kPacketHeaderBytes, part.out.size() - body));
  const auto clock = job.deadline.clock;
  const std::int64_t begin = clock != nullptr ? clock() : 0;
  const Status status = by_runs ? part.tiles->pack_runs(job.tables, job.frame, rect, into, tile)
                                : part.tiles->pack(job.tables, job.frame, rect, into, tile, fill);
  if (clock == nullptr) return status;
  PackPace& pace = part.report.pace;
  (by_runs ? pace.runs_ns : pace.modelled_ns) += clock() - begin;
  if (status == Status::kOk)
    (by_runs ? pace.run_blocks : pace.modelled_blocks) += rect.bw * tile.rows;
  return status;
}

Status FramePacker::pack_halves(Part& part, const TileRect& rect) noexcept {
  const auto [first, second] = halves(*part.job, rect);
  const Status status = pack_rect(part, first);
  return status == Status::kOk ? pack_rect(part, second) : status;
}

// Splits across the longer side, so that full slices come out: of n slices, n / 2 go first.
std::array<TileRect, 2> FramePacker::halves(const Job& job, const TileRect& rect) const noexcept {
  TileRect first = rect, second = rect;
  const bool wide = rect.bw >= rect.bh;
  const std::uint32_t side = wide ? rect.bw : rect.bh;
  const double bits = estimate(job, rect);
  const double slices = std::max(2.0, std::ceil(bits / budget_bits(job)));
  const double wanted = bits * std::floor(slices / 2) / slices;
  // Near-square tiles predict best: the cut stays off the ends.
  const std::uint32_t margin = side / 5;
  std::uint32_t cut = std::max(1U, margin);
  for (; cut < side - margin && cut < side - 1; ++cut) {
    TileRect part = rect;
    (wide ? part.bw : part.bh) = cut;
    if (estimate(job, part) >= wanted) break;
  }
  (wide ? first.bw : first.bh) = cut;
  (wide ? second.bx : second.by) += cut;
  (wide ? second.bw : second.bh) = side - cut;
  return {first, second};
}

}  // namespace planecast
