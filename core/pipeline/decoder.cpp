#include "core/pipeline/decoder.hpp"

#include <algorithm>
#include <limits>

#include "core/regen/point_regen.hpp"
#include "core/wire/key_packet.hpp"

namespace planecast {

namespace {

std::size_t slice_blocks(const FrameLimits& limits) noexcept {
  return std::size_t{(limits.max_width + 7U) / 8} * ((limits.max_height + 7U) / 8);
}

}  // namespace

Status Decoder::layout(Arena& arena, const DecoderConfig& config) noexcept {
  tables_.layout(arena, config.limits, CodecHalf::kDecoder);
  team_ = config.team;
  for (std::uint32_t i = 0; i < (team_.shared() ? kMaxTeamWorkers : 1); ++i)
    unpackers_[i].layout(arena, config.limits.max_width);
  if (team_.shared()) {
    outcomes_ = arena.take<Outcome>(kMaxShared);
    taken_ = arena.take<std::uint8_t>(slice_blocks(config.limits));
  }
  raw_unpacker_.layout(arena, config.limits.max_width);
  depth_ = arena.take<std::uint16_t>(config.limits.pixels());
  labels_ = arena.take<std::uint8_t>(config.limits.pixels());
  cloud_ = arena.take<Point3f>(std::max(config.limits.pixels(), config.limits.max_points));
  point_unpacker_.layout(arena, config.limits.max_points);
  grid_ = arena.take<GridPoint>(config.limits.max_points);
  patch_unpacker_.layout(arena);
  patch_filler_.layout(arena);
  return arena.failed() ? Status::kOutOfArena : Status::kOk;
}

std::size_t Decoder::memory_bytes(const DecoderConfig& config) noexcept {
  Arena arena = Arena::measuring();
  Decoder decoder;
  (void)decoder.layout(arena, config);
  return arena.bytes_needed();
}

Result<std::unique_ptr<Decoder>> Decoder::create(const DecoderConfig& config,
                                                 std::span<std::byte> memory) {
  const std::size_t bytes = memory_bytes(config);
  if (!memory.empty() && memory.size() < bytes) {
    return Error{Status::kOutOfArena,
                 "the decoder needs " + std::to_string(bytes) + " bytes of memory"};
  }
  auto arena = memory.empty() ? Arena::map(bytes) : Arena::over(memory);
  if (!arena.ok()) return arena.error();
  auto decoder = std::make_unique<Decoder>();
  decoder->arena_ = std::move(*arena);
  if (const Status status = decoder->layout(decoder->arena_, config); status != Status::kOk) {
    return Error{status, "the decoder's memory could not be laid out"};
  }
  decoder->arena_.seal();
  return decoder;
}

Status Decoder::set_key(std::span<const std::uint8_t> packet) noexcept {
  PacketHeader header;
  if (const Status status = open_packet(packet, header); status != Status::kOk) return status;
  if (!header.key) return Status::kFieldRange;
  const auto body = packet.subspan(kPacketHeaderBytes);
  if (key_hash(body) != header.key_hash) return Status::kBadCheck;
  if (tables_.ready() && tables_.key_hash() == header.key_hash) return Status::kOk;
  StreamConfig config;
  if (const Status status = read_key_body(body, config); status != Status::kOk) return status;
  return tables_.build(config, header.key_hash);
}

Status Decoder::begin() noexcept {
  counts_ = {};
  listed_ = 0;
  if (!tables_.ready()) return Status::kUnknownKey;
  const std::size_t pixels = config().camera.pixels();
  switch (kind()) {
    case FrameKind::kDepth:
      std::fill_n(depth_.begin(), pixels, std::uint16_t{0});
      std::fill_n(labels_.begin(), pixels, std::uint8_t{0});
      break;
    case FrameKind::kRawCloud:
      clear_points(cloud_.first(pixels));
      break;
    case FrameKind::kPoints:
      break;
  }
  return Status::kOk;
}

Status Decoder::unpack_points(std::span<const std::uint8_t> slice, std::uint32_t& used) noexcept {
  const PointCoding coding = point_coding(config());
  const std::uint32_t first = used;
  const Status status = point_unpacker_.unpack_slice(coding, tables_.key_hash(), slice,
                                                     grid_.first(coding.max_points), used);
  if (status != Status::kOk) return status;
  return regenerate_points(config().points, grid_.subspan(first, used - first),
                           cloud_.subspan(first, used - first));
}

Status Decoder::unpack_patches(std::span<const std::uint8_t> slice, const PacketHeader& header,
                               std::uint32_t& used, std::uint32_t& patches) noexcept {
  const PointStream& stream = config().points;
  Status status = patch_unpacker_.begin(slice.subspan(kPacketHeaderBytes));
  Pcg32 generator = patch_generator(stream, header.frame, header.slice);
  while (status == Status::kOk && patch_unpacker_.left() > 0) {
    Patch patch;
    std::span<const std::uint8_t> cells;
    status = patch_unpacker_.next(patch, cells);
    if (status != Status::kOk) return status;
    if (patch.points > stream.max_points - used) return Status::kTooLarge;
    status =
        patch_filler_.fill(patch, cells, stream, generator, cloud_.subspan(used, patch.points));
    used += patch.points;
    ++patches;
  }
  return status;
}

// A slice that fails leaves no point: `listed_` moves on only with a whole one.
Status Decoder::unpack_list(std::span<const std::uint8_t> slice, TileContent& content) noexcept {
  PacketHeader header;
  if (const Status status = open_packet(slice, header); status != Status::kOk) return status;
  if (header.key) return Status::kFieldRange;
  if (header.key_hash != tables_.key_hash()) return Status::kUnknownKey;
  PointSliceKind what = PointSliceKind::kVerbatim;
  if (const Status status = point_slice_kind(slice, what); status != Status::kOk) return status;
  std::uint32_t used = listed_, patches = 0;
  const Status status = what == PointSliceKind::kPatches
                            ? unpack_patches(slice, header, used, patches)
                            : unpack_points(slice, used);
  if (status != Status::kOk) return status;
  content.points = used - listed_;
  counts_.surfaces += patches;
  listed_ = used;
  return Status::kOk;
}

Status Decoder::unpack(std::span<const std::uint8_t> slice, TileContent& content) noexcept {
  const std::size_t pixels = config().camera.pixels();
  switch (kind()) {
    case FrameKind::kDepth:
      return unpackers_[0].unpack_slice(tables_.coding(), tables_.key_hash(), slice,
                                        {depth_.first(pixels), labels_.first(pixels)}, content);
    case FrameKind::kRawCloud:
      return raw_unpacker_.unpack_slice(config(), tables_.key_hash(), slice, cloud_.first(pixels),
                                        content);
    case FrameKind::kPoints:
      break;
  }
  return unpack_list(slice, content);
}

Status Decoder::add(std::span<const std::uint8_t> slice) noexcept {
  TileContent content;
  return count(tables_.ready() ? unpack(slice, content) : Status::kUnknownKey, content);
}

Status Decoder::count(Status status, const TileContent& content) noexcept {
  if (status == Status::kOk) {
    ++counts_.slices;
    counts_.points += content.points;
    counts_.corrections += content.corrections;
    if (content.surfaces > 0) number_surfaces(content);
  } else {
    ++counts_.refused;
    if (status == Status::kUnknownKey) ++counts_.unknown_key;
  }
  return status;
}

// Slices may be decoded side by side when no two claim the same block, which only a hostile
// sender's do; one that does not say its place is left to add() as well.
bool Decoder::can_share(const SliceList& slices) noexcept {
  if (!team_.shared() || !depth_stream() || slices.count < 2 || slices.count > kMaxShared)
    return false;
  const CameraModel& camera = config().camera;
  const std::size_t wide = (camera.width + 7U) / 8;
  std::fill(taken_.begin(), taken_.end(), std::uint8_t{0});
  for (std::uint32_t i = 0; i < slices.count; ++i) {
    const auto slice = slices.at(slices.frame, i);
    if (slice.empty()) continue;
    TileRect rect;
    if (FrameUnpacker::peek(tables_.coding(), tables_.key_hash(), slice, rect) != Status::kOk)
      return false;
    for (std::uint32_t by = rect.by; by < rect.by + rect.bh; ++by) {
      const auto row = taken_.subspan(by * wide + rect.bx, rect.bw);
      if (std::find(row.begin(), row.end(), 1) != row.end()) return false;
      std::fill(row.begin(), row.end(), std::uint8_t{1});
    }
  }
  return true;
}

struct Decoder::Sharing {
  Decoder& decoder;
  const SliceList& slices;
};

void Decoder::add_shared(const SliceList& slices) noexcept {
  Sharing sharing{*this, slices};
  team_.run(
      slices.count,
      [](void* job, std::uint32_t i, std::uint32_t worker) noexcept {
        const auto& all = *static_cast<const Sharing*>(job);
        Decoder& self = all.decoder;
        const auto slice = all.slices.at(all.slices.frame, i);
        if (slice.empty()) return;
        const std::size_t pixels = self.config().camera.pixels();
        self.outcomes_[i].status = self.unpackers_[worker].unpack_slice(
            self.tables_.coding(), self.tables_.key_hash(), slice,
            {self.depth_.first(pixels), self.labels_.first(pixels)}, self.outcomes_[i].content);
      },
      &sharing);
}

Status Decoder::add_all(const SliceList& slices) noexcept {
  const bool shared = can_share(slices);
  if (shared) add_shared(slices);
  Status first = Status::kOk;
  for (std::uint32_t i = 0; i < slices.count; ++i) {
    const auto slice = slices.at(slices.frame, i);
    if (slice.empty()) continue;
    // Counted in order, so that surfaces have the same numbers whoever decoded them.
    const Status status = shared ? count(outcomes_[i].status, outcomes_[i].content) : add(slice);
    if (first == Status::kOk) first = status;
  }
  return first;
}

// A surface that crosses several tiles travels in each with the same coefficients: that is how it
// is known again. Beyond 255, which no encoder sends, surfaces share the last number.
void Decoder::number_surfaces(const TileContent& tile) noexcept {
  std::array<std::uint8_t, kMaxSurfaces + 1> number{};
  bool moved = false;
  for (std::uint32_t i = 0; i < tile.surfaces; ++i) {
    std::uint32_t n = 0;
    while (n < counts_.surfaces && surfaces_[n] != tile.surface[i]) ++n;
    if (n == counts_.surfaces && n < surfaces_.size())
      surfaces_[counts_.surfaces++] = tile.surface[i];
    number[i + 1] = static_cast<std::uint8_t>(std::min<std::size_t>(n + 1, surfaces_.size()));
    moved |= number[i + 1] != i + 1;
  }
  if (!moved) return;  // as in a frame of one slice
  const CameraModel& camera = config().camera;
  const TileSpan span = tile_span(camera, tile.rect);
  for (std::uint32_t v = span.v0; v < span.v1; ++v) {
    const auto row = labels_.subspan(std::size_t{v} * camera.width + span.u0, span.u1 - span.u0);
    for (std::uint8_t& label : row) label = number[label];
  }
}

Status Decoder::finish() noexcept {
  if (!tables_.ready()) return Status::kUnknownKey;
  if (kind() != FrameKind::kDepth) return Status::kOk;
  return regenerate(config(), tables_.rays(), tables_.scale(), depth(), cloud_, team_);
}

std::span<const std::uint16_t> Decoder::depth() const noexcept {
  return depth_.first(depth_stream() ? config().camera.pixels() : 0);
}
std::span<const std::uint8_t> Decoder::labels() const noexcept {
  return labels_.first(depth_stream() ? config().camera.pixels() : 0);
}
std::span<const Point3f> Decoder::cloud() const noexcept {
  if (!tables_.ready()) return cloud_.first(0);
  return cloud_.first(kind() == FrameKind::kPoints ? listed_ : config().camera.pixels());
}

}  // namespace planecast
