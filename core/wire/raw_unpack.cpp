#include "core/wire/raw_unpack.hpp"

#include <algorithm>

#include "core/wire/decode_io.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/range_decoder.hpp"
#include "core/wire/raw_tile.hpp"

namespace planecast {
namespace {

void clear_tile(const TileSpan& span, std::uint32_t width, std::span<Point3f> target) noexcept {
  for (std::uint32_t v = span.v0; v < span.v1; ++v)
    clear_points(target.subspan(std::size_t{v} * width + span.u0, span.u1 - span.u0));
}

}  // namespace

void clear_points(std::span<Point3f> points) noexcept {
  std::fill(points.begin(), points.end(), hole_point());
}

void RawFrameUnpacker::layout(Arena& arena, std::uint32_t max_width) noexcept {
  states_ = arena.take<RawState>(
      raw_states(std::min<std::uint32_t>((max_width + 7) / 8, kMaxTileBlocks)));
}

Status RawFrameUnpacker::unpack_slice(const StreamConfig& config, std::uint32_t key_hash,
                                      std::span<const std::uint8_t> packet,
                                      std::span<Point3f> target, TileContent& content) noexcept {
  content = {};
  PacketHeader header;
  if (const Status status = open_packet(packet, header); status != Status::kOk) return status;
  if (header.key) return Status::kFieldRange;
  if (header.key_hash != key_hash) return Status::kUnknownKey;
  const CameraModel& camera = config.camera;
  if (config.kind != FrameKind::kRawCloud || camera.pixels() == 0) return Status::kBadConfig;
  if (target.size() != camera.pixels()) return Status::kWrongSize;

  RangeDecoder coder(packet.subspan(kPacketHeaderBytes));
  DecodeIo io{coder};
  models_ = RawModels{};
  RawTile<DecodeIo> tile(io, camera, models_, states_);
  TileRect rect{0, 0, 1, 1};
  if (const Status status = tile.head(content.verbatim, rect); status != Status::kOk) return status;
  if (states_.size() < raw_states(rect.bw)) return Status::kTooLarge;
  content.rect = rect;
  const TileSpan span = tile_span(camera, rect);
  Status status = Status::kOk;
  if (content.verbatim) {
    status = tile.verbatim(span, target, content.points);
  } else {
    RawRays rays;
    status = tile.rays(rays);
    if (status == Status::kOk) status = tile.modelled(span, rays, target, content.points);
  }
  if (coder.truncated()) status = Status::kTruncated;
  if (status == Status::kOk && coder.trailing()) status = Status::kTrailingBytes;
  if (status != Status::kOk) clear_tile(span, camera.width, target);
  return status;
}

}  // namespace planecast
