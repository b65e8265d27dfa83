#include "core/wire/frame_pack.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <cstdlib>

namespace planecast {
namespace {

constexpr double kTileHeadBits = 120;
constexpr double kFill = 7.2;             // bits planned for each byte of a slice
constexpr std::uint32_t kBlockCost = 24;  // all costs in 1/16 bit
constexpr std::uint32_t kReadingCost = 3;
constexpr std::uint32_t kCorrectionCost = 40;
constexpr std::uint32_t kDoublingCost = 20;  // of a correction of twice the steps
constexpr std::uint32_t kMixedCost = 5;
// Against a deadline no tile is more than this share of a frame, and a tile may take this much
// longer than those before it.
constexpr std::uint32_t kDeadlineTiles = 32;
constexpr double kSlowTile = 1.5;
constexpr std::size_t kStoredHead = 16;  // bytes

std::uint32_t ceil_blocks(std::uint32_t pixels) noexcept {
  return (pixels + 7) / 8;
}

// Estimated cost of a block in 1/16 bit, before any scale: readings whose neighbours do not predict
// them within the bound, and the hole mask where a block is mixed.
std::uint32_t block_cost(const CodingTables& tables, const FrameModel& frame, std::uint32_t bx,
                         std::uint32_t by) noexcept {
  const CameraModel& camera = tables.config->camera;
  const std::uint32_t u1 = std::min<std::uint32_t>(bx * 8 + 8, camera.width);
  const std::uint32_t v1 = std::min<std::uint32_t>(by * 8 + 8, camera.height);
  const std::uint8_t* half_widths = tables.bounds->half_widths(tables.bounds->ray_class(bx, by));
  const auto level_of = [&](std::uint16_t depth) { return int{tables.levels->nearest(depth)}; };
  std::uint32_t readings = 0, corrections = 0, pixels = 0;
  // Every fourth row tells enough.
  for (std::uint32_t v = by * 8 + (by * 8 + 1 < v1 ? 1 : 0); v < v1; v += 4) {
    const std::uint16_t* row = &frame.depth[std::size_t{v} * camera.width];
    const std::uint16_t* above = v > 0 ? row - camera.width : row;
    int left = bx > 0 ? level_of(row[bx * 8 - 1]) : 0;
    for (std::uint32_t u = bx * 8; u < u1; ++u) {
      ++pixels;
      const int level = level_of(row[u]), up = level_of(above[u]);
      const int expected = left != 0 && up != 0 ? (left + up) / 2 : left + up;
      left = level;
      if (level == 0) continue;
      ++readings;
      const auto error = static_cast<std::uint32_t>(std::abs(level - expected));
      const std::uint32_t half = half_widths[level];
      if (error <= half) continue;
      corrections +=
          kCorrectionCost +
          kDoublingCost * static_cast<std::uint32_t>(std::bit_width(error) - std::bit_width(half));
    }
  }
  if (readings == 0) return 2;
  return kBlockCost + 4 * (readings * kReadingCost + corrections +
                           (readings < pixels ? pixels * kMixedCost : 0));
}

// Sums over tiles that least squares needs: costs off surfaces (a) and on (b), bits (y).
struct Moments {
  double aa = 0, ab = 0, bb = 0, ay = 0, by = 0;
  void add(double a, double b, double y) noexcept {
    aa += a * a;
    ab += a * b;
    bb += b * b;
    ay += a * y;
    by += b * y;
  }
};

}  // namespace

struct FramePacker::Job {
  const CodingTables& tables;
  const FrameModel& frame;
  const FrameIdentity& identity;
  std::size_t slice_bytes;
  std::span<std::uint8_t> out;
  std::span<SlicePlace> places;
  FrameReport& report;
  bool one_slice = false;  ///< any frame fits: nothing to estimate
  Moments moments = {};
  PackDeadline deadline = {};
  std::int64_t begin_ns = 0;
  std::uint32_t blocks = 0, blocks_done = 0;
};

std::size_t frame_capacity(std::uint32_t width, std::uint32_t height) noexcept {
  const std::size_t blocks = std::size_t{ceil_blocks(width)} * ceil_blocks(height);
  return blocks * (64 * 2 + 8 + kPacketHeaderBytes) + kMinSliceBytes;
}

std::size_t slice_capacity(std::uint32_t width, std::uint32_t height) noexcept {
  return std::min<std::size_t>(std::size_t{ceil_blocks(width)} * ceil_blocks(height), 65535);
}

void FramePacker::layout(Arena& arena, std::uint32_t max_width, std::uint32_t max_height) noexcept {
  tiles_.layout(arena, max_width);
  cost_sums_ =
      arena.take<Costs>((std::size_t{ceil_blocks(max_width)} + 1) * (ceil_blocks(max_height) + 1));
}

Status FramePacker::pack(const CodingTables& tables, const FrameModel& frame,
                         const FrameIdentity& identity, std::size_t slice_bytes,
                         std::span<std::uint8_t> out, std::span<SlicePlace> places,
                         FrameReport& report, const PackDeadline& deadline) noexcept {
  if (slice_bytes < kMinSliceBytes) return Status::kBadConfig;
  Job job{tables, frame, identity, slice_bytes, out, places, report};
  const CameraModel& camera = tables.config->camera;
  job.one_slice = slice_bytes >= frame_capacity(camera.width, camera.height) &&
                  std::max(camera.width, camera.height) <= kMaxTileSide &&
                  deadline.clock == nullptr;
  job.deadline = deadline;
  if (deadline.clock != nullptr) job.begin_ns = deadline.clock();
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

Status FramePacker::pack_whole(Job& job) noexcept {
  job.report = {};
  job.report.surfaces = static_cast<std::uint32_t>(job.frame.surfaces.size());
  job.moments = {};
  job.blocks_done = 0;
  const CameraModel& camera = job.tables.config->camera;
  job.blocks = blocks_wide(camera) * blocks_high(camera);
  return pack_rect(job, {0, 0, blocks_wide(camera), blocks_high(camera)});
}

// Moves both scales towards those that fit this frame's tiles best, by one in `share`.
void FramePacker::calibrate(const Job& job, double share) noexcept {
  const Moments& m = job.moments;
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

// Whether what is left could not be stored in time any more after coding this tile at the pace so
// far; the first tiles, without a pace, are small.
bool FramePacker::too_late(const Job& job, const TileRect& rect) noexcept {
  if (job.deadline.clock == nullptr) return false;
  const double tile = rect.bw * rect.bh, done = job.blocks_done;
  const auto gone = static_cast<double>(job.deadline.clock() - job.begin_ns);
  const auto left = static_cast<double>(job.deadline.end_ns - job.begin_ns) - gone;
  const double coding = done > 0 ? kSlowTile * gone * tile / done : 0;
  const double storing =
      static_cast<double>(job.deadline.stored_ns) * (job.blocks - done - tile) / job.blocks;
  return coding + storing > left;
}

Status FramePacker::pack_rect(Job& job, const TileRect& rect) noexcept {
  const bool fits_syntax = rect.bw <= kMaxTileBlocks && rect.bh <= kMaxTileBlocks;
  const std::size_t body = job.slice_bytes - kPacketHeaderBytes;
  const bool small = job.deadline.clock == nullptr ||
                     rect.bw * rect.bh * kDeadlineTiles <= std::max(job.blocks, kDeadlineTiles);
  const bool stored = small && too_late(job, rect);
  const bool likely =
      job.one_slice || (small && (stored ? (rect.bw * rect.bh * 128 + kStoredHead <= body)
                                         : estimate(job, rect) <= budget_bits(job)));
  const bool single = rect.bw == 1 && rect.bh == 1;
  if (!fits_syntax || (!likely && !single)) return pack_halves(job, rect);

  if (job.report.slices >= job.places.size()) return Status::kTooLarge;
  const std::size_t offset = job.report.bytes;
  if (job.out.size() < offset + kPacketHeaderBytes) return Status::kTooLarge;
  const std::size_t room = std::min(body, job.out.size() - offset - kPacketHeaderBytes);
  TileReport tile;
  const std::span<std::uint8_t> into = job.out.subspan(offset + kPacketHeaderBytes, room);
  const Status status = stored ? tiles_.store(job.tables, job.frame, rect, into, tile)
                               : tiles_.pack(job.tables, job.frame, rect, into, tile);
  if (status == Status::kTooLarge && !single) return pack_halves(job, rect);
  if (status != Status::kOk) return status;
  const auto bytes = static_cast<std::uint32_t>(kPacketHeaderBytes + tile.bytes);
  job.places[job.report.slices++] = {static_cast<std::uint32_t>(offset), bytes};
  job.report.bytes += bytes;
  job.report.points += tile.points;
  job.report.corrections += tile.corrections;
  job.report.stored_tiles += stored ? 1 : 0;
  job.blocks_done += rect.bw * rect.bh;
  if (job.one_slice || stored) return Status::kOk;
  const auto [off, on] = costs(job, rect);
  job.moments.add(off, on, static_cast<double>(tile.bytes) * 8 - kTileHeadBits);
  return Status::kOk;
}

// Splits across the longer side, so that full slices come out: of n slices, n / 2 go first.
Status FramePacker::pack_halves(Job& job, const TileRect& rect) noexcept {
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
  const Status status = pack_rect(job, first);
  return status == Status::kOk ? pack_rect(job, second) : status;
}

}  // namespace planecast
