#include "core/wire/raw_pack.hpp"

#include <algorithm>

#include "core/wire/encode_io.hpp"
#include "core/wire/raw_tile.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kPointBytes = 12;
constexpr std::uint32_t kHeadBytes = 8;  // verbatim flag and rectangle, and the coder's end
constexpr std::uint32_t kRaysBits = 10 * 48 + 8;

std::uint32_t ceil_blocks(std::uint32_t pixels) noexcept {
  return (pixels + 7) / 8;
}

}  // namespace

struct RawFramePacker::Job {
  const CameraModel& camera;
  std::span<const Point3f> points;
  std::size_t slice_bytes;
  std::span<std::uint8_t> out;
  std::span<SlicePlace> places;
  FrameReport& report;
};

std::size_t raw_frame_capacity(std::uint32_t width, std::uint32_t height) noexcept {
  const std::size_t blocks = std::size_t{ceil_blocks(width)} * ceil_blocks(height);
  return blocks * (64 * kPointBytes + kHeadBytes + kPacketHeaderBytes) + kMinRawSliceBytes;
}

void RawFramePacker::layout(Arena& arena, std::uint32_t max_width,
                            std::uint32_t max_height) noexcept {
  states_ = arena.take<RawState>(
      raw_states(std::min<std::uint32_t>(ceil_blocks(max_width), kMaxTileBlocks)));
  sums_ = arena.take<std::uint32_t>((std::size_t{ceil_blocks(max_width)} + 1) *
                                    (ceil_blocks(max_height) + 1));
  fitter_.layout(arena);
}

Status RawFramePacker::pack(const StreamConfig& config, std::span<const Point3f> points,
                            const FrameIdentity& identity, std::size_t slice_bytes,
                            std::span<std::uint8_t> out, std::span<SlicePlace> places,
                            FrameReport& report) noexcept {
  report = {};
  if (config.kind != FrameKind::kRawCloud || slice_bytes < kMinRawSliceBytes)
    return Status::kBadConfig;
  const CameraModel& camera = config.camera;
  const std::uint32_t wide = blocks_wide(camera), high = blocks_high(camera);
  if (wide == 0 || high == 0) return Status::kBadConfig;
  if (points.size() != std::size_t{camera.width} * camera.height) return Status::kWrongSize;
  if (sums_.size() < (std::size_t{wide} + 1) * (high + 1) ||
      states_.size() < raw_states(std::min(wide, kMaxTileBlocks))) {
    return Status::kFrameTooLarge;
  }
  Job job{camera, points, slice_bytes, out, places, report};
  count_readings(job);
  rays_ = fitter_.fit(points, camera.width, camera.height);
  if (const Status status = pack_rect(job, {0, 0, wide, high}); status != Status::kOk)
    return status;
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
  return Status::kOk;
}

void RawFramePacker::count_readings(const Job& job) noexcept {
  const std::uint32_t wide = blocks_wide(job.camera), high = blocks_high(job.camera);
  std::fill_n(sums_.begin(), std::size_t{wide + 1} * (high + 1), 0U);
  for (std::uint32_t v = 0; v < job.camera.height; ++v) {
    std::uint32_t* row = &sums_[std::size_t{v / 8 + 1} * (wide + 1) + 1];
    const Point3f* points = &job.points[std::size_t{v} * job.camera.width];
    for (std::uint32_t u = 0; u < job.camera.width; ++u)
      row[u / 8] += is_reading(points[u]) ? 1 : 0;
  }
  for (std::uint32_t by = 1; by <= high; ++by) {
    std::uint32_t* row = &sums_[std::size_t{by} * (wide + 1)];
    std::uint32_t sum = 0;
    for (std::uint32_t bx = 1; bx <= wide; ++bx) {
      sum += row[bx];
      row[bx] = *(row + bx - (wide + 1)) + sum;
    }
  }
}

std::uint32_t RawFramePacker::readings(const Job& job, const TileRect& r) const noexcept {
  const std::size_t stride = std::size_t{blocks_wide(job.camera)} + 1;
  const auto at = [&](std::uint32_t bx, std::uint32_t by) { return sums_[by * stride + bx]; };
  return at(r.bx + r.bw, r.by + r.bh) - at(r.bx, r.by + r.bh) - at(r.bx + r.bw, r.by) +
         at(r.bx, r.by);
}

std::uint64_t RawFramePacker::estimate_bits(const Job& job, const TileRect& rect) const noexcept {
  return kRaysBits + rect.bw * rect.bh + (readings(job, rect) * reading_bits_q4_ >> 4U);
}

Status RawFramePacker::pack_rect(Job& job, const TileRect& rect) noexcept {
  const bool single = rect.bw == 1 && rect.bh == 1;
  const bool fits_syntax = rect.bw <= kMaxTileBlocks && rect.bh <= kMaxTileBlocks;
  const std::size_t body = job.slice_bytes - kPacketHeaderBytes;
  const bool likely = estimate_bits(job, rect) <= std::uint64_t{body} * 8 * 15 / 16;
  if (!fits_syntax || (!likely && !single)) return pack_halves(job, rect);

  if (job.report.slices >= job.places.size() || job.report.slices >= 65535)
    return Status::kTooLarge;
  const std::size_t offset = job.report.bytes + kPacketHeaderBytes;
  if (job.out.size() < offset) return Status::kTooLarge;
  std::size_t bytes = 0;
  const Status status =
      pack_tile(job, rect, job.out.subspan(offset, std::min(body, job.out.size() - offset)), bytes);
  if (status == Status::kTooLarge && !single) return pack_halves(job, rect);
  if (status != Status::kOk) return status;
  const std::uint32_t count = readings(job, rect);
  if (count >= 64 && bytes * 8 > kRaysBits) {
    const std::uint64_t measured = (bytes * 8 - kRaysBits) * 16 / count;
    reading_bits_q4_ = std::clamp<std::uint64_t>((reading_bits_q4_ * 7 + measured) / 8, 16, 2048);
  }
  const auto total = static_cast<std::uint32_t>(kPacketHeaderBytes + bytes);
  job.places[job.report.slices++] = {static_cast<std::uint32_t>(job.report.bytes), total};
  job.report.bytes += total;
  job.report.points += count;
  return Status::kOk;
}

// Splits across the longer side, where the readings halve; the cut stays in the middle half.
Status RawFramePacker::pack_halves(Job& job, const TileRect& rect) noexcept {
  const bool wide = rect.bw >= rect.bh;
  const std::uint32_t side = wide ? rect.bw : rect.bh;
  const std::uint32_t half = readings(job, rect) / 2;
  std::uint32_t cut = std::max(1U, side / 4);
  for (; cut < side - side / 4 && cut < side - 1; ++cut) {
    TileRect part = rect;
    (wide ? part.bw : part.bh) = cut;
    if (readings(job, part) >= half) break;
  }
  TileRect first = rect, second = rect;
  (wide ? first.bw : first.bh) = cut;
  (wide ? second.bx : second.by) += cut;
  (wide ? second.bw : second.bh) = side - cut;
  const Status status = pack_rect(job, first);
  return status == Status::kOk ? pack_rect(job, second) : status;
}

Status RawFramePacker::pack_tile(Job& job, const TileRect& rect, std::span<std::uint8_t> out,
                                 std::size_t& bytes) noexcept {
  const TileSpan span = tile_span(job.camera, rect);
  // Points as they are set the upper limit of what a tile may cost.
  const std::size_t limit =
      std::size_t{span.u1 - span.u0} * (span.v1 - span.v0) * kPointBytes + kHeadBytes;
  for (const bool verbatim : {false, true}) {
    RangeEncoder coder(out.first(std::min(out.size(), limit)));
    EncodeIo io{coder};
    models_ = RawModels{};
    RawTile<EncodeIo> tile(io, job.camera, models_, states_);
    bool flag = verbatim;
    TileRect place = rect;
    std::uint32_t count = 0;
    Status status = tile.head(flag, place);
    if (status == Status::kOk && verbatim) status = tile.verbatim(span, job.points, count);
    if (status == Status::kOk && !verbatim) {
      status = tile.rays(rays_);
      if (status == Status::kOk) status = tile.modelled(span, rays_, job.points, count);
    }
    if (status != Status::kOk) return status;
    bytes = coder.finish();
    if (!coder.overflow()) return Status::kOk;
    // Where not even the models fit, the points as they are fit only small tiles.
    if (out.size() < limit && !verbatim) return Status::kTooLarge;
  }
  return Status::kTooLarge;
}

}  // namespace planecast
