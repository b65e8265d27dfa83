// What the tests of the point codec share: clouds of every sort, a packer and an unpacker with
// their memory, and the contract checked by brute force.
#pragma once

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <limits>
#include <random>
#include <string>
#include <tuple>
#include <vector>

#include "core/base/arena.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/point_pack.hpp"
#include "core/wire/point_unpack.hpp"

namespace planecast::point_bench {

using Points = std::vector<GridPoint>;
using Packet = std::vector<std::uint8_t>;

/// Packs and unpacks frames of up to `max_points`.
class Codec {
 public:
  explicit Codec(std::uint32_t tolerance, std::uint32_t max_points)
      : coding{tolerance, max_points} {
    Arena measure = Arena::measuring();
    take(measure);
    auto block = Arena::map(measure.bytes_needed());
    arena_ = std::move(block.value());
    take(arena_);
    arena_.seal();
    packed_.resize(point_frame_capacity(max_points));
    places_.resize(point_slice_capacity(max_points, kMinPointSliceBytes));
  }

  Status pack(const Points& points, std::size_t slice_bytes) {
    report = {};
    return packer.pack(coding, points, identity, slice_bytes, packed_, places_, report);
  }

  std::vector<Packet> packets() const {
    std::vector<Packet> all;
    for (std::uint32_t i = 0; i < report.slices; ++i) {
      const auto* from = packed_.data() + places_[i].offset;
      all.emplace_back(from, from + places_[i].bytes);
    }
    return all;
  }

  /// Decodes packets in the order given; stops at the first that fails.
  Status unpack(const std::vector<Packet>& packets, Points& points) {
    points.assign(coding.max_points, {});
    std::uint32_t used = 0;
    for (const Packet& packet : packets) {
      const Status status = unpacker.unpack_slice(coding, identity.key_hash, packet, points, used);
      if (status != Status::kOk) return status;
    }
    points.resize(used);
    return Status::kOk;
  }

  PointCoding coding;
  FrameIdentity identity{3, 77, 123456, 0xabcd1234};
  FrameReport report;
  PointFramePacker packer;
  PointFrameUnpacker unpacker;

 private:
  void take(Arena& arena) {
    packer.layout(arena, coding.max_points);
    unpacker.layout(arena, coding.max_points);
  }

  Arena arena_;
  Packet packed_;
  std::vector<SlicePlace> places_;
};

inline Points sorted(Points points) {
  std::sort(points.begin(), points.end(), [](const GridPoint& a, const GridPoint& b) {
    return std::tie(a.x, a.y, a.z) < std::tie(b.x, b.y, b.z);
  });
  return points;
}

/// Greatest distance of a point of `from` to its nearest of `to`, squared, over all pairs; the
/// long double holds the squares of the largest differences well enough for a comparison.
inline long double farthest_squared(const Points& from, const Points& to) {
  long double worst = 0;
  for (const GridPoint& a : from) {
    long double least = std::numeric_limits<long double>::infinity();
    for (const GridPoint& b : to) {
      const long double dx = static_cast<long double>(a.x) - b.x;
      const long double dy = static_cast<long double>(a.y) - b.y;
      const long double dz = static_cast<long double>(a.z) - b.z;
      least = std::min(least, dx * dx + dy * dy + dz * dz);
      if (least == 0) break;
    }
    worst = std::max(worst, least);
  }
  return worst;
}

/// The contract of point_pack.hpp by brute force; empty when it holds, else what does not.
inline std::string broken_contract(const Points& in, const Points& out, std::uint32_t tolerance) {
  if (in.size() != out.size())
    return std::to_string(in.size()) + " in, " + std::to_string(out.size()) + " out";
  if (tolerance == 0) return sorted(in) == sorted(out) ? "" : "not the same points";
  const long double most = static_cast<long double>(tolerance) * tolerance;
  if (farthest_squared(in, out) > most) return "a point that went in is too far";
  if (farthest_squared(out, in) > most) return "a point that came out is too far";
  return "";
}

/// Clouds by name, `n` points each, coordinates within about +-`size`.
inline const std::vector<std::string>& cloud_names() {
  static const std::vector<std::string> kNames = {"volume", "plane", "noisy",  "sphere",
                                                  "line",   "equal", "sparse", "clustered",
                                                  "full",   "edge",  "field",  "voxels"};
  return kNames;
}

inline Points cloud(const std::string& name, std::size_t n, std::int32_t size, unsigned seed) {
  std::mt19937 random(seed);
  const auto within = [&](std::int64_t a) {
    return static_cast<std::int32_t>(std::uniform_int_distribution<std::int64_t>(-a, a)(random));
  };
  Points points;
  constexpr std::int64_t kAll = std::numeric_limits<std::int32_t>::max();
  const GridPoint centre{within(kAll / 2), within(kAll / 2), within(kAll / 2)};
  for (std::size_t i = 0; i < n; ++i) {
    GridPoint p{within(size), within(size), within(size)};
    if (name == "plane") p.z = static_cast<std::int32_t>((std::int64_t{p.x} * 3 + p.y * 2) / 7);
    if (name == "noisy") p.z = p.x / 2 - p.y / 3 + within(size / 50 + 1);
    if (name == "sphere") {
      const double length =
          std::max(1.0, std::sqrt(double(p.x) * p.x + double(p.y) * p.y + double(p.z) * p.z));
      const double scale = size / length;
      p = {static_cast<std::int32_t>(p.x * scale), static_cast<std::int32_t>(p.y * scale),
           static_cast<std::int32_t>(p.z * scale)};
    }
    if (name == "line") p = {p.x, p.x / 2, -p.x};
    if (name == "equal") p = {size, -size, 7};
    if (name == "sparse") p = {within(kAll / 4), within(kAll / 4), within(kAll / 4)};
    if (name == "clustered") {
      const auto k = static_cast<std::int32_t>(i % 5);
      p = {centre.x + k * size + within(3), centre.y + within(3), centre.z + within(3)};
    }
    if (name == "full") p = {within(kAll), within(kAll), within(kAll)};
    if (name == "field") {  // heights over a lattice whose pitch is no whole number of steps
      const auto at = [&](std::int32_t v) {
        return static_cast<std::int32_t>(std::int64_t{v / 200} * 3001 / 10);
      };
      p = {at(p.x), at(p.y), p.x / 9 - p.y / 7};
    }
    if (name == "voxels") p = {p.x / 100 * 100, p.y / 100 * 100 + 7, p.z / 100 * 100 - 3};
    if (name == "edge") {
      constexpr std::int32_t kEnds[2] = {std::numeric_limits<std::int32_t>::min(),
                                         std::numeric_limits<std::int32_t>::max()};
      const auto end = [&](std::int32_t v) {
        return v < 0 ? kEnds[0] - std::max(v, -9) : kEnds[1];
      };
      p = {end(p.x), end(p.y), end(p.z)};
    }
    points.push_back(p);
  }
  return points;
}

}  // namespace planecast::point_bench
