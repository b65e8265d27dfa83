// Packer and unpacker of one stream on the caller's thread, images that try them, and packets
// whose check is right again after a test has spoilt them.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>
#include <utility>
#include <vector>

#include "core/base/bytes.hpp"
#include "core/base/crc32c.hpp"
#include "core/fit/surface_fitter.hpp"
#include "core/pipeline/stream_tables.hpp"
#include "core/segment/region_growing.hpp"
#include "core/wire/frame_pack.hpp"
#include "core/wire/frame_unpack.hpp"
#include "tests/core/model/random_config.hpp"

namespace planecast::test {

using Bytes = std::vector<std::uint8_t>;
using Image = std::vector<std::uint16_t>;

/// Makes the check of a packet fit its bytes again.
inline void reseal(Bytes& packet) {
  const std::span<const std::uint8_t> all(packet);
  store_le<std::uint32_t>(packet.data() + 20, crc32c(all.subspan(24), crc32c(all.first(20))));
}

/// Whether a decoder may give this status for bytes from outside.
inline bool is_wire_status(Status status) {
  return status == Status::kOk ||
         (status >= Status::kTruncated && status <= Status::kTrailingBytes);
}

/// Where the packer's surfaces come from.
enum class SurfaceMode { kNone, kFitted, kRandom };

struct WireBench {
  static constexpr std::uint32_t kHash = 0x600df00dU;

  StreamConfig config;
  Arena arena;
  StreamTables tables;
  FramePacker packer;
  FrameUnpacker unpacker;
  Segmenter segmenter;
  SurfaceFitter fitter;
  std::vector<BlockLabel> labels;
  std::vector<Surface> surfaces;
  std::uint32_t surface_count = 0;
  std::uint8_t shift = 0;
  FrameReport report;
  PackDeadline deadline;              ///< of pack(); none unless a test sets one
  std::vector<TileContent> contents;  ///< of the slices decoded last

  explicit WireBench(const StreamConfig& stream) : config(stream) {
    config.kind = FrameKind::kDepth;
    const CameraModel& c = config.camera;
    arena = std::move(*Arena::map((std::size_t{10} << 20U) + std::size_t{c.pixels()} * 80));
    tables.layout(arena, {c.width, c.height});
    packer.layout(arena, c.width, c.height);
    unpacker.layout(arena, c.width);
    segmenter.layout(arena, c.width, c.height);
    fitter.layout(arena, c.width, c.height);
    EXPECT_FALSE(arena.failed());
    EXPECT_EQ(tables.build(config, kHash), Status::kOk);
    labels.resize(std::size_t{blocks_wide(c)} * blocks_high(c));
    surfaces.resize(kMaxSurfaces);
  }

  bool surfaces_kind() const { return config.tolerance == ToleranceKind::kSurfaces; }

  void find_surfaces(const Image& depth, SurfaceMode mode, Pcg32& random) {
    surface_count = 0;
    shift = 0;
    std::fill(labels.begin(), labels.end(), BlockLabel{});
    if (mode == SurfaceMode::kFitted) {
      RegionMap regions;
      ASSERT_EQ(segmenter.process(config, tables.rays(), depth, regions), Status::kOk);
      const FitTables fit{&config, &tables.rays(), &tables.levels(), &tables.bounds()};
      FitReport found;
      ASSERT_EQ(fitter.fit(fit, depth, regions, labels, surfaces, found), Status::kOk);
      surface_count = found.surfaces;
      shift = found.shift;
    }
    if (mode == SurfaceMode::kRandom) random_surfaces(depth, random);
  }

  // Surfaces through random readings, others anywhere, on random blocks: nothing that fits, all
  // that the syntax can say.
  void random_surfaces(const Image& depth, Pcg32& random) {
    surface_count = 1 + random.below(random.below(4) == 0 ? kMaxSurfaces : 6);
    shift = static_cast<std::uint8_t>(random.below(12));
    const auto coefficient = [&](double value) {
      const double most = kMaxSurfaceCoefficient >> shift << shift;
      const auto rounded = static_cast<std::int32_t>(std::clamp(value, -most, most));
      return rounded / (1 << shift) * (1 << shift);
    };
    for (std::uint32_t i = 0; i < surface_count; ++i) {
      const std::uint16_t at = depth[random.below(static_cast<std::uint32_t>(depth.size()))];
      const double c =
          random.below(8) == 0 ? between(random, -2e9, 2e9) : 0x1p31 / std::max<int>(1, at);
      const double tilt = random.below(8) == 0 ? 50 : 0.2;
      surfaces[i] = {coefficient(c * between(random, -tilt, tilt)),
                     coefficient(c * between(random, -tilt, tilt)), coefficient(c)};
      if (random.below(2) == 0) continue;
      for (std::int32_t Surface::*bend : {&Surface::d, &Surface::e, &Surface::f}) {
        surfaces[i].*bend = coefficient(c * between(random, -tilt, tilt));
      }
    }
    for (BlockLabel& label : labels) {
      label.first = static_cast<std::uint8_t>(random.below(surface_count + 1));
      const bool second = surfaces_kind() && label.first != 0 && random.below(2) != 0;
      label.second = static_cast<std::uint8_t>(second ? random.below(surface_count + 1) : 0);
    }
  }

  Status try_pack(const Image& depth, std::size_t slice_bytes, std::vector<Bytes>& packets) {
    Bytes out(frame_capacity(config.camera.width, config.camera.height));
    std::vector<SlicePlace> places(slice_capacity(config.camera.width, config.camera.height));
    const FrameModel model{depth, labels, std::span(surfaces).first(surface_count), shift};
    packets.clear();
    const Status status = packer.pack(tables.coding(), model, {config.stream, 5, 17, kHash},
                                      slice_bytes, out, places, report, deadline);
    if (status != Status::kOk) return status;
    for (std::uint32_t i = 0; i < report.slices; ++i) {
      const auto* begin = out.data() + places[i].offset;
      packets.emplace_back(begin, begin + places[i].bytes);
    }
    return status;
  }

  std::vector<Bytes> pack(const Image& depth, std::size_t slice_bytes) {
    std::vector<Bytes> packets;
    EXPECT_EQ(try_pack(depth, slice_bytes, packets), Status::kOk);
    return packets;
  }

  Status unpack(const Bytes& packet, Image& depth, Image* labels_out = nullptr) {
    std::vector<std::uint8_t> found(labels_out != nullptr ? depth.size() : 0);
    TileContent content;
    const Status status =
        unpacker.unpack_slice(tables.coding(), kHash, packet, {depth, found}, content);
    if (labels_out != nullptr) labels_out->assign(found.begin(), found.end());
    contents.push_back(content);
    return status;
  }

  Image unpack_all(const std::vector<Bytes>& packets) {
    Image depth(config.camera.pixels());
    contents.clear();
    for (const Bytes& packet : packets) EXPECT_EQ(unpack(packet, depth), Status::kOk);
    return depth;
  }
};

/// A deadline that is past already: every tile is coded by runs.
inline PackDeadline past_deadline() {
  return {[]() noexcept { return std::int64_t{0}; }, -1, 1, 1};
}

/// Kinds of images, from what sensors give to what none does.
inline constexpr std::uint64_t kImageKinds = 9;

inline Image random_image(Pcg32& random, const CameraModel& camera, std::uint64_t kind) {
  Image out(camera.pixels());
  const double slope_u = between(random, -4, 4), slope_v = between(random, -4, 4);
  const double base = between(random, 500, 30000), noise = between(random, 0, 30);
  for (std::uint32_t v = 0, i = 0; v < camera.height; ++v) {
    for (std::uint32_t u = 0; u < camera.width; ++u, ++i) {
      double z = base + slope_u * u + slope_v * v + noise * (random.uniform() - 0.5);
      switch (kind % kImageKinds) {
        case 0:
          break;  // a sloping plane with noise
        case 1:
          z = random.next() & 0xffffU;
          break;  // no structure at all
        case 2:
          z = 0;
          break;  // nothing seen
        case 3:
          z = ((u / 5) ^ (v / 3)) & 1U ? z : z * 0.5;
          break;  // edges everywhere
        case 4:
          z = random.below(2) != 0 ? 65535 : 1;
          break;  // the ends of the range
        case 5:
          z = (u + v) % 7 == 0 || (u / 9 + v / 4) % 3 == 0 ? 0 : z;
          break;  // many holes
        case 6:
          z = random.below(60) == 0 ? z : 0;
          break;  // lone readings
        case 7:
          z = random.below(400) == 0 ? 65535 : base;
          break;  // spikes on a flat wall
        case 8:
          z = 2e7 / (20 + 0.7 * u + 0.2 * v);
          break;  // a steep plane
        default:
          break;
      }
      out[i] = static_cast<std::uint16_t>(std::clamp(z, 0.0, 65535.0));
    }
  }
  return out;
}

}  // namespace planecast::test
