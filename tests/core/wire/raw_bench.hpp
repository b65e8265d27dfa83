// Packer and unpacker of one raw-cloud stream, and clouds of every kind of float.
#pragma once

#include <gtest/gtest.h>

#include <bit>
#include <cmath>

#include "core/wire/raw_pack.hpp"
#include "core/wire/raw_unpack.hpp"
#include "tests/core/wire/wire_bench.hpp"

namespace planecast::test {

using Cloud = std::vector<Point3f>;

struct RawBench {
  static constexpr std::uint32_t kHash = 0xfeedf00dU;

  StreamConfig config;
  Arena arena;
  RawFramePacker packer;
  RawFrameUnpacker unpacker;
  FrameReport report;
  std::vector<TileContent> contents;

  RawBench(std::uint32_t width, std::uint32_t height) {
    config.kind = FrameKind::kRawCloud;
    config.camera.width = static_cast<std::uint16_t>(width);
    config.camera.height = static_cast<std::uint16_t>(height);
    arena = std::move(*Arena::map((std::size_t{2} << 20U) + std::size_t{width} * height));
    packer.layout(arena, width, height);
    unpacker.layout(arena, width);
    EXPECT_FALSE(arena.failed());
  }

  std::vector<Bytes> pack(const Cloud& cloud, std::size_t slice_bytes) {
    Bytes out(raw_frame_capacity(config.camera.width, config.camera.height));
    std::vector<SlicePlace> places(slice_capacity(config.camera.width, config.camera.height));
    EXPECT_EQ(packer.pack(config, cloud, {3, 9, 11, kHash}, slice_bytes, out, places, report),
              Status::kOk);
    std::vector<Bytes> packets;
    for (std::uint32_t i = 0; i < report.slices; ++i) {
      const auto* begin = out.data() + places[i].offset;
      packets.emplace_back(begin, begin + places[i].bytes);
    }
    return packets;
  }

  Status unpack(const Bytes& packet, std::span<Point3f> cloud) {
    TileContent content;
    const Status status = unpacker.unpack_slice(config, kHash, packet, cloud, content);
    contents.push_back(content);
    return status;
  }

  Cloud unpack_all(const std::vector<Bytes>& packets) {
    Cloud cloud(config.camera.pixels());
    clear_points(cloud);
    contents.clear();
    for (const Bytes& packet : packets) EXPECT_EQ(unpack(packet, cloud), Status::kOk);
    return cloud;
  }
};

inline float float_of(std::uint32_t bits) {
  return std::bit_cast<float>(bits);
}

inline bool same_bits(const Point3f& a, const Point3f& b) {
  return std::bit_cast<std::uint32_t>(a.x) == std::bit_cast<std::uint32_t>(b.x) &&
         std::bit_cast<std::uint32_t>(a.y) == std::bit_cast<std::uint32_t>(b.y) &&
         std::bit_cast<std::uint32_t>(a.z) == std::bit_cast<std::uint32_t>(b.z);
}

inline bool finite_point(const Point3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

/// Kinds of clouds, from what sensors give to what none does.
inline constexpr std::uint64_t kCloudKinds = 8;

inline Cloud random_cloud(Pcg32& random, std::uint32_t width, std::uint32_t height,
                          std::uint64_t kind) {
  Cloud out(std::size_t{width} * height);
  const double focal = std::max(width, height), tilt = between(random, -0.4, 0.4);
  for (std::size_t i = 0; i < out.size(); ++i) {
    const double x = (static_cast<double>(i % width) - 0.5 * width) / focal;
    const double y = (static_cast<double>(i / width) - 0.5 * height) / focal;
    double z = 2.0 / (1 + tilt * x) + 0.004 * (random.uniform() - 0.5);
    Point3f p{static_cast<float>(x * z), static_cast<float>(y * z), static_cast<float>(z)};
    switch (kind % kCloudKinds) {
      case 0:
        break;  // a camera's points of any depth
      case 1:   // on inverse depth steps, turned: the largest coordinate is x
        z = 400.0 / (150 + random.below(40));
        p = {static_cast<float>(z), static_cast<float>(-x * z), static_cast<float>(-y * z)};
        break;
      case 2:  // any bits at all
        p = {float_of(random.next()), float_of(random.next()), float_of(random.next())};
        break;
      case 3:  // denormals and zeros of both signs
        p = {float_of(random.next() & 0x807fffffU), float_of(random.below(2) << 31U),
             float_of(random.below(3) == 0 ? random.next() & 0x80000003U : 0)};
        break;
      case 4:  // the ends of the range
        p = {random.below(2) != 0 ? 3.4028235e38F : -3.4028235e38F, p.y, 1e-38F};
        break;
      case 5:  // holes of every sort
        if (random.below(3) == 0) p.z = float_of(0x7fc00000U | (random.next() & 0x3fffffU));
        if (random.below(9) == 0) p.x = float_of(0x7f800000U | random.below(2) << 31U);
        if (random.below(9) == 0) p.y = float_of(0xff800001U);
        break;
      case 6:
        p = {NAN, NAN, NAN};
        break;  // nothing seen
      case 7:   // even depth steps and lone outliers
        z = 0.001 * (1500 + random.below(50));
        p = {static_cast<float>(x * z), static_cast<float>(y * z), static_cast<float>(z)};
        if (random.below(50) == 0) p = {float_of(random.next()), -0.0F, 0.0F};
        break;
      default:
        break;
    }
    out[i] = p;
  }
  return out;
}

}  // namespace planecast::test
