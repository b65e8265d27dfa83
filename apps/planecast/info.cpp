// planecast info: every packet of a .plc file, readably.
#include <fmt/core.h>

#include <cstdio>
#include <memory>
#include <string>

#include "apps/planecast/commands.hpp"
#include "apps/planecast/describe.hpp"
#include "apps/planecast/plc_file.hpp"
#include "core/base/arena.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/pipeline/stream_tables.hpp"
#include "core/wire/frame_unpack.hpp"
#include "core/wire/key_packet.hpp"
#include "core/wire/point_unpack.hpp"
#include "core/wire/raw_unpack.hpp"

namespace planecast {
namespace {

// Looks into slices one by one: the tables of their key packet and room for one frame.
class SliceViewer {
 public:
  static Result<SliceViewer> create(const FrameLimits& limits) {
    SliceViewer viewer;
    Arena measure = Arena::measuring();
    viewer.layout(measure, limits);
    auto arena = Arena::map(measure.bytes_needed());
    if (!arena.ok()) return arena.error();
    viewer.arena_ = std::move(*arena);
    viewer.layout(viewer.arena_, limits);
    auto lists = Decoder::create({limits});
    if (!lists.ok()) return lists.error();
    viewer.lists_ = std::move(*lists);
    return viewer;
  }

  Status set_key(std::span<const std::uint8_t> key, const StreamConfig& config,
                 std::uint32_t hash) {
    if (config.kind == FrameKind::kPoints) {
      if (const Status status = lists_->set_key(key); status != Status::kOk) return status;
    }
    if (tables_.ready() && tables_.key_hash() == hash) return Status::kOk;
    return tables_.build(config, hash);
  }

  Status look(std::span<const std::uint8_t> slice, ListContent& content) {
    PointSliceKind kind = PointSliceKind::kVerbatim;
    Status status = lists_->begin();
    if (status == Status::kOk) status = lists_->add(slice);
    if (status == Status::kOk) status = point_slice_kind(slice, kind);
    if (status != Status::kOk) return status;
    constexpr const char* kNames[] = {"points as plain numbers", "points", "patches"};
    content = {kNames[static_cast<std::size_t>(kind)], lists_->counts().points,
               lists_->counts().surfaces};
    return status;
  }

  Status look(std::span<const std::uint8_t> slice, TileContent& content) {
    const StreamConfig& config = tables_.config();
    const std::size_t pixels = config.camera.pixels();
    if (config.kind == FrameKind::kRawCloud) {
      return raw_unpacker_.unpack_slice(config, tables_.key_hash(), slice, points_.first(pixels),
                                        content);
    }
    return unpacker_.unpack_slice(tables_.coding(), tables_.key_hash(), slice,
                                  {depth_.first(pixels), {}}, content);
  }

 private:
  // Lists are looked at by a decoder of their own.
  void layout(Arena& arena, const FrameLimits& limits) {
    tables_.layout(arena, limits, CodecHalf::kDecoder);
    unpacker_.layout(arena, limits.max_width);
    raw_unpacker_.layout(arena, limits.max_width);
    depth_ = arena.take<std::uint16_t>(limits.pixels());
    points_ = arena.take<Point3f>(limits.pixels());
  }

  Arena arena_;
  StreamTables tables_;
  FrameUnpacker unpacker_;
  RawFrameUnpacker raw_unpacker_;
  std::span<std::uint16_t> depth_;
  std::span<Point3f> points_;
  std::unique_ptr<Decoder> lists_;
};

PacketHeader header_of(std::span<const std::uint8_t> packet) {
  PacketHeader header;
  (void)open_packet(packet, header);  // read_plc() has checked every packet
  return header;
}

Json key_json(const PlcFile& file, std::span<const std::uint8_t> packet,
              const StreamConfig& config) {
  const PacketHeader header = header_of(packet);
  Json out = {{"byte", packet.data() - file.bytes.data()},
              {"bytes", packet.size()},
              {"hash", hex32(header.key_hash)},
              {"frame", header.frame}};
  out.update(describe(config));
  return out;
}

Json slice_json(const PlcFile& file, SliceViewer& viewer, std::span<const std::uint8_t> slice,
                const StreamConfig& config, bool& damaged) {
  const PacketHeader header = header_of(slice);
  const bool list = config.kind == FrameKind::kPoints;
  TileContent content;
  ListContent list_content;
  const Status status = list ? viewer.look(slice, list_content) : viewer.look(slice, content);
  const auto byte = slice.data() - file.bytes.data();
  if (status != Status::kOk) {
    damaged = true;
    return {{"byte", byte},
            {"slice", header.slice},
            {"bytes", slice.size()},
            {"not_decodable", std::string(to_string(status))}};
  }
  Json out = {{"byte", byte}};
  out.update(list ? describe(header, list_content, slice.size())
                  : describe(header, content, config.camera, slice.size()));
  return out;
}

Result<Json> frame_json(const PlcFile& file, SliceViewer& viewer, const PlcFrame& frame,
                        bool& damaged) {
  const auto config = config_of(file, frame.key);
  if (!config.ok()) return config.error();
  const Status status = viewer.set_key(frame.key, *config, header_of(frame.key).key_hash);
  if (status != Status::kOk) {
    return Error{status, fmt::format("{}: frame {}: key packet not usable ({})", file.path,
                                     frame.frame, to_string(status))};
  }
  std::size_t bytes = 0;
  for (const auto& slice : frame.slices) bytes += slice.size();
  Json out = {{"frame", frame.frame},
              {"stream", frame.stream},
              {"stamp_ns", static_cast<std::int64_t>(static_cast<std::uint64_t>(config->epoch_ns) +
                                                     frame.stamp_offset)},
              {"slices_present", frame.slices.size()},
              {"slice_count", frame.slice_count},
              {"bytes", bytes},
              {"slices", Json::array()}};
  for (const auto& slice : frame.slices)
    out["slices"].push_back(slice_json(file, viewer, slice, *config, damaged));
  return out;
}

Json file_json(const PlcFile& file) {
  const PlcContents& c = file.contents;
  return {{"file", file.path},
          {"version", fmt::format("{}.{}", file.bytes[4], file.bytes[5])},
          {"bytes", file.bytes.size()},
          {"frame_count", c.frames.size()},
          {"key_packet_count", c.keys.size()},
          {"complete", c.complete},
          {"cut_bytes", c.cut_bytes},
          {"damaged_packets", c.damaged_packets},
          {"orphan_slices", c.orphan_slices}};
}

Result<Json> keys_json(const PlcFile& file) {
  Json out = Json::array();
  for (const auto& key : file.contents.keys) {
    const auto config = config_of(file, key);
    if (!config.ok()) return config.error();
    out.push_back(key_json(file, key, *config));
  }
  return out;
}

Result<Done> print(const PlcFile& file, bool as_json, bool& damaged) {
  const auto limits = limits_of(file);
  if (!limits.ok()) return limits.error();
  auto viewer = SliceViewer::create(*limits);
  if (!viewer.ok()) return viewer.error();
  const auto keys = keys_json(file);
  if (!keys.ok()) return keys.error();
  Json all = file_json(file);
  if (!as_json) fmt::print("{}\n", readable(all));
  all["key_packets"] = *keys;
  all["frames"] = Json::array();
  for (std::size_t i = 0; !as_json && i < keys->size(); ++i)
    fmt::print("\nkey packet {}\n{}\n", i, readable((*keys)[i], 2));
  for (const PlcFrame& frame : file.contents.frames) {
    const auto described = frame_json(file, *viewer, frame, damaged);
    if (!described.ok()) return described.error();
    if (as_json) {
      all["frames"].push_back(*described);
    } else {
      fmt::print("\n{}\n", readable(*described));
    }
  }
  if (as_json) fmt::print("{}\n", all.dump(2));
  return Done{};
}

}  // namespace

ExitCode run_info(const CommandArguments& arguments, const CodecOptions& /*options*/) {
  const auto file = open_plc(arguments.inputs);
  if (!file.ok()) return complain(file.error());
  tell(file->missing());
  bool damaged = file->damaged();
  if (const auto done = print(*file, arguments.json, damaged); !done.ok())
    return complain(done.error());
  return damaged ? ExitCode::kBadInput : ExitCode::kDone;
}

}  // namespace planecast
