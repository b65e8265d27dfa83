// Elseberg, Borrmann, Nuechter, "One billion points in the cloud" (ISPRS J. 76, 2013), as read here
// from the description of 3DTK's structure: a node is 8 bytes, one pointer of 48 bits to its
// children and two masks (which are there, which of them are leaves); a leaf is its number of
// points and, for each, three 16-bit offsets within its cell. A cell of at most 10 points is a
// leaf. The paper's "without loss of precision" holds to 1/65536 of a leaf. No entropy coding: it
// is memory laid out to be searched. The seed paper's "two bytes a point" are two bytes a
// coordinate.
#include <fmt/format.h>

#include "bench/baselines/point_baselines.hpp"
#include "bench/baselines/point_cube.hpp"

namespace planecast::baselines {
namespace {

constexpr std::size_t kLeafPoints = 10;
constexpr std::size_t kNodeBytes = 8;
constexpr int kDeepest = 40;  // equal points never part

struct Cell {
  double x, y, z, size;
  Cell child(int c) const {
    const double half = size / 2;
    return {x + ((c & 4) != 0 ? half : 0), y + ((c & 2) != 0 ? half : 0),
            z + ((c & 1) != 0 ? half : 0), half};
  }
};

std::uint16_t offset_in(double value, double least, double size) {
  const double at = size > 0 ? (value - least) / size * 65536 : 0;
  return static_cast<std::uint16_t>(std::clamp(std::floor(at), 0.0, 65535.0));
}

// Writes the subtree of `points` at out[at], where its node's 8 bytes have been reserved.
void write_node(Bytes& out, std::size_t at, const Cell& cell, const PointList& points, int depth) {
  PointList parts[8];
  for (const Point3f& p : points) {
    const double half = cell.size / 2;
    parts[(p.x >= cell.x + half) * 4 + (p.y >= cell.y + half) * 2 + (p.z >= cell.z + half)]
        .push_back(p);
  }
  std::uint64_t there = 0, leaves = 0, inner = 0;
  for (int c = 0; c < 8; ++c) {
    if (parts[c].empty()) continue;
    there |= 1ull << c;
    if (parts[c].size() <= kLeafPoints || depth >= kDeepest) {
      leaves |= 1ull << c;
    } else {
      ++inner;
    }
  }
  std::size_t next = out.size();  // the children: inner nodes first, then the leaves
  const std::uint64_t node = (next - at) << 16 | leaves << 8 | there;
  std::memcpy(out.data() + at, &node, sizeof(node));
  out.resize(next + inner * kNodeBytes);
  for (int c = 0; c < 8; ++c) {
    if ((leaves >> c & 1) == 0) continue;
    const Cell leaf = cell.child(c);
    put(out, static_cast<std::uint32_t>(parts[c].size()));
    for (const Point3f& p : parts[c]) {
      put(out, offset_in(p.x, leaf.x, leaf.size));
      put(out, offset_in(p.y, leaf.y, leaf.size));
      put(out, offset_in(p.z, leaf.z, leaf.size));
    }
  }
  for (int c = 0; c < 8; ++c) {
    if (parts[c].empty() || (leaves >> c & 1) != 0) continue;
    write_node(out, next, cell.child(c), parts[c], depth + 1);
    next += kNodeBytes;
  }
}

void read_node(const Bytes& in, std::size_t at, const Cell& cell, PointList& out, int depth) {
  const auto field = [&in](std::size_t where) {
    if (where > in.size()) fail("octree 2013", "a pointer leads outside");
    return ByteReader(std::span(in).subspan(where));
  };
  const auto node = field(at).take<std::uint64_t>();
  const auto there = static_cast<std::uint32_t>(node & 0xff);
  const auto leaves = static_cast<std::uint32_t>(node >> 8 & 0xff);
  if (depth > kDeepest) fail("octree 2013", "deeper than any tree");
  std::size_t next = at + (node >> 16);
  ByteReader leaf_reader =
      field(next + kNodeBytes * static_cast<std::size_t>(std::popcount(there & ~leaves)));
  for (int c = 0; c < 8; ++c) {
    if ((leaves >> c & 1) == 0) continue;
    const Cell leaf = cell.child(c);
    const double step = leaf.size / 65536;
    for (auto count = leaf_reader.take<std::uint32_t>(); count > 0; --count) {
      const double x = leaf.x + (leaf_reader.take<std::uint16_t>() + 0.5) * step;
      const double y = leaf.y + (leaf_reader.take<std::uint16_t>() + 0.5) * step;
      const double z = leaf.z + (leaf_reader.take<std::uint16_t>() + 0.5) * step;
      out.push_back({static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)});
    }
  }
  for (int c = 0; c < 8; ++c) {
    if ((there >> c & 1) == 0 || (leaves >> c & 1) != 0) continue;
    read_node(in, next, cell.child(c), out, depth + 1);
    next += kNodeBytes;
  }
}

class Octree2013 : public PointBaseline {
 public:
  Octree2013() : PointBaseline("octree 2013", fmt::format("leaves of {} points", kLeafPoints)) {}

  Bytes encode(const PointList& points) const override {
    const PointCube cube = cube_round(points);
    Bytes out;
    put(out, cube);
    if (points.empty()) return out;
    const std::size_t root = out.size();
    out.resize(root + kNodeBytes);
    write_node(out, root, {cube.x, cube.y, cube.z, cube.side}, points, 0);
    return out;
  }

  PointList decode(const Bytes& bytes) const override {
    const auto cube = ByteReader(bytes).take<PointCube>();
    PointList out;
    if (bytes.size() > sizeof(cube))
      read_node(bytes, sizeof(cube), {cube.x, cube.y, cube.z, cube.side}, out, 0);
    return out;
  }
};

}  // namespace

std::unique_ptr<PointBaseline> octree2013() {
  return std::make_unique<Octree2013>();
}

}  // namespace planecast::baselines
