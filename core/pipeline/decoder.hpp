// The decoder of one stream: key packets and slices in, a depth image and a cloud out. One thread,
// or a team where one is given; fixed memory; no segmentation is linked by it.
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/work_team.hpp"
#include "core/pipeline/stream_tables.hpp"
#include "core/regen/patch_fill.hpp"
#include "core/wire/frame_unpack.hpp"
#include "core/wire/patch_unpack.hpp"
#include "core/wire/point_unpack.hpp"
#include "core/wire/raw_unpack.hpp"

namespace planecast {

struct DecoderConfig {
  FrameLimits limits{1280, 1024};  ///< larger streams are refused with kFrameTooLarge, and lists
                                   ///< unless max_points says how many points they may have
  WorkTeam team{};  ///< shares add_all() and finish() of depth frames; to outlive the decoder
};

/// The slices of a frame where they lie: at(frame, i) for i below count, empty where one is lost.
struct SliceList {
  const void* frame = nullptr;
  std::uint32_t count = 0;
  std::span<const std::uint8_t> (*at)(const void* frame, std::uint32_t i) noexcept = nullptr;
};

/// What happened to the current frame's slices.
struct DecodedCounts {
  std::uint32_t slices = 0;       ///< decoded
  std::uint32_t refused = 0;      ///< not decodable, by any cause
  std::uint32_t unknown_key = 0;  ///< of them for want of their key packet
  std::uint32_t points = 0;
  std::uint32_t corrections = 0;
  std::uint32_t surfaces = 0;  ///< different ones; slices repeat those they share. Lists: patches
};

/// Usage per frame: begin(), add() for each slice or add_all(), finish(); then depth(), cloud().
class Decoder {
 public:
  /// Exact bytes that create() maps for this configuration.
  static std::size_t memory_bytes(const DecoderConfig& config) noexcept;

  /// Takes all memory: maps it, or uses `memory` (the caller's, 64-byte aligned, memory_bytes()
  /// long, to outlive the decoder). kOutOfArena, kBadConfig.
  static Result<std::unique_ptr<Decoder>> create(const DecoderConfig& config,
                                                 std::span<std::byte> memory = {});

  /// Takes a sealed key packet; a known one costs nothing. Statuses of open_packet, read_key_body,
  /// StreamTables::build.
  Status set_key(std::span<const std::uint8_t> packet) noexcept;

  /// Starts a frame: clears the image. kUnknownKey before the first key packet.
  Status begin() noexcept;
  /// Decodes one slice, in any order. Its failure is counted and returned; others go on.
  Status add(std::span<const std::uint8_t> slice) noexcept;
  /// The same as add() for each slice that is there, in order; returns the first failure. Shared
  /// out among DecoderConfig::team, unless two slices claim the same pixels.
  Status add_all(const SliceList& slices) noexcept;
  /// Regenerates the cloud. kUnknownKey before the first key packet.
  Status finish() noexcept;

  bool ready() const noexcept { return tables_.ready(); }
  const StreamConfig& config() const noexcept { return tables_.config(); }
  const StreamTables& tables() const noexcept { return tables_; }
  const DecodedCounts& counts() const noexcept { return counts_; }
  std::size_t memory_in_use() const noexcept { return arena_.bytes_used(); }
  /// Depth counts, row-major; empty for clouds and lists. Valid until the next begin().
  std::span<const std::uint16_t> depth() const noexcept;
  /// 1 + surface number within the frame, 0 off surfaces; empty for clouds and lists. Surfaces
  /// are numbered in the order in which the slices were added.
  std::span<const std::uint8_t> labels() const noexcept;
  /// Points in the order of pixels, NaN = no reading; of a list those that came, in the order in
  /// which their slices were added. Valid until the next begin().
  std::span<const Point3f> cloud() const noexcept;

 private:
  /// Most slices that are shared out: what a team can count.
  static constexpr std::uint32_t kMaxShared = 255;
  struct Outcome {
    TileContent content;
    Status status = Status::kOk;
  };
  struct Sharing;

  Status layout(Arena& arena, const DecoderConfig& config) noexcept;
  bool can_share(const SliceList& slices) noexcept;
  void add_shared(const SliceList& slices) noexcept;
  Status count(Status status, const TileContent& content) noexcept;
  void number_surfaces(const TileContent& tile) noexcept;
  FrameKind kind() const noexcept { return config().kind; }
  bool depth_stream() const noexcept { return ready() && kind() == FrameKind::kDepth; }
  Status unpack(std::span<const std::uint8_t> slice, TileContent& content) noexcept;
  Status unpack_list(std::span<const std::uint8_t> slice, TileContent& content) noexcept;
  Status unpack_points(std::span<const std::uint8_t> slice, std::uint32_t& used) noexcept;
  Status unpack_patches(std::span<const std::uint8_t> slice, const PacketHeader& header,
                        std::uint32_t& used, std::uint32_t& patches) noexcept;

  Arena arena_;
  StreamTables tables_;
  std::array<FrameUnpacker, kMaxTeamWorkers> unpackers_;
  WorkTeam team_;
  std::span<Outcome> outcomes_;    ///< of the slices shared out
  std::span<std::uint8_t> taken_;  ///< blocks that a slice claims
  RawFrameUnpacker raw_unpacker_;
  PointFrameUnpacker point_unpacker_;
  PatchUnpacker patch_unpacker_;
  PatchFiller patch_filler_;
  std::span<std::uint16_t> depth_;
  std::span<std::uint8_t> labels_;
  std::span<Point3f> cloud_;
  std::span<GridPoint> grid_;  ///< lists
  std::uint32_t listed_ = 0;   ///< points of the current list
  DecodedCounts counts_;
  std::array<Surface, 255> surfaces_{};  ///< of the current frame; counts_.surfaces are in use
};

}  // namespace planecast
