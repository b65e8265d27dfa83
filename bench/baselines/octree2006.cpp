// Schnabel and Klein, "Octree-based point-cloud compression" (SPBG 2006), as read here: an octree
// goes out level by level. For each cell the number of its non-empty children is coded first, then
// which ones: children are ranked by their distance from a plane through the cells of the same
// level round about, which both ends know, and the nearer ones are likelier. Adaptive arithmetic
// coding throughout. Lossless at the leaves' size; points of one leaf are counted and come back at
// its centre. Left out: colour, and the paper's finer weighting of configurations.
#include <fmt/format.h>

#include <Eigen/Eigenvalues>
#include <array>
#include <numeric>

#include "bench/baselines/point_baselines.hpp"
#include "bench/baselines/point_cube.hpp"
#include "core/search/kdtree_search.hpp"
#include "core/wire/range_decoder.hpp"
#include "core/wire/range_encoder.hpp"

namespace planecast::baselines {
namespace {

constexpr std::size_t kNeighbours = 14;  // cells that make the local plane
constexpr int kCountBits = 24;           // of the points in one leaf

// All adaptive probabilities, and the decisions in terms of a coder's bit(model, value) -> value.
struct Models {
  BitModel children[8][8];    // number of children, a binary tree, by the rank of the parent's
  BitModel child[9][8][9];    // by number of children, rank, children found so far
  BitModel more[kCountBits];  // points in a leaf
  BitModel digit[kCountBits];

  template <class Coder>
  int code_count(Coder& coder, int before, int count) {
    int node = 1;
    for (int i = 2; i >= 0; --i)
      node = node * 2 + coder.bit(children[before][node & 7], ((count - 1) >> i & 1) != 0);
    return node - 8 + 1;
  }

  template <class Coder>
  std::uint8_t code_mask(Coder& coder, const std::array<int, 8>& order, int count,
                         std::uint8_t mask) {
    std::uint8_t out = 0;
    int found = 0;
    for (int rank = 0; rank < 8; ++rank) {
      if (found == count) break;
      bool set = 8 - rank == count - found;  // all that are left
      if (!set) set = coder.bit(child[count][rank][found], (mask >> order[rank] & 1) != 0);
      if (!set) continue;
      out = static_cast<std::uint8_t>(out | 1 << order[rank]);
      ++found;
    }
    return out;
  }

  // Exp-Golomb of the points of a leaf, at least 1.
  template <class Coder>
  std::uint32_t code_points(Coder& coder, std::uint32_t count) {
    int bits = 0;
    while (bits + 1 < kCountBits && coder.bit(more[bits], (count >> (bits + 1)) != 0)) ++bits;
    std::uint32_t out = 1;
    for (int i = bits - 1; i >= 0; --i) out = out * 2 + coder.bit(digit[i], (count >> i & 1) != 0);
    return out;
  }
};

struct Writer {
  explicit Writer(Bytes& room) : encoder(room) {}
  bool bit(BitModel& model, bool value) {
    encoder.bit(model, value);
    return value;
  }
  RangeEncoder encoder;
};

struct Reader {
  explicit Reader(std::span<const std::uint8_t> bytes) : decoder(bytes) {}
  bool bit(BitModel& model, bool) { return decoder.bit(model); }
  RangeDecoder decoder;
};

// Children of a cell, the likeliest first: nearest to the plane through the cells round about.
std::array<int, 8> ranked_children(const KdTreeSearch& cells, const std::vector<Point3f>& centres,
                                   const Point3f& centre, double size) {
  std::array<Neighbour, kNeighbours> near;
  const std::size_t found = cells.knn(centre, near);
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  std::array<Eigen::Vector3d, kNeighbours> at;
  for (std::size_t i = 0; i < found; ++i) {
    const Point3f& p = centres[near[i].index];
    at[i] = {p.x, p.y, p.z};
    mean += at[i];
  }
  mean /= static_cast<double>(std::max<std::size_t>(found, 1));
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < found; ++i) covariance += (at[i] - mean) * (at[i] - mean).transpose();
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> solver;
  solver.computeDirect(covariance);
  const Eigen::Vector3d normal = solver.eigenvectors().col(0);
  std::array<double, 8> distance{};
  for (int c = 0; c < 8; ++c) {
    const Eigen::Vector3d child(centre.x + ((c & 4) != 0 ? size : -size) / 4,
                                centre.y + ((c & 2) != 0 ? size : -size) / 4,
                                centre.z + ((c & 1) != 0 ? size : -size) / 4);
    distance[c] = std::abs(normal.dot(child - mean));
  }
  std::array<int, 8> order{0, 1, 2, 3, 4, 5, 6, 7};
  std::stable_sort(order.begin(), order.end(),
                   [&](int a, int b) { return distance[a] < distance[b]; });
  return order;
}

// Walks the tree of `cube` level by level through `coder`. Encoding: `codes` are the sorted leaf
// codes, one a point; decoding: empty. Returns leaf codes, one a point.
template <class Coder>
std::vector<std::uint64_t> walk(Coder& coder, const PointCube& cube,
                                const std::vector<std::uint64_t>& codes) {
  Models models;
  std::vector<std::uint64_t> level{0};
  int before = 3;
  const auto levels = static_cast<int>(cube.levels);
  for (int depth = 0; depth < levels; ++depth) {
    std::vector<Point3f> centres;
    for (const std::uint64_t code : level) centres.push_back(cell_centre(cube, code, depth));
    const KdTreeSearch cells(centres);
    std::vector<std::uint64_t> next;
    const int shift = 3 * (levels - depth - 1);
    auto at = codes.begin();
    for (std::size_t i = 0; i < level.size(); ++i) {
      std::uint8_t mask = 0;
      for (; at != codes.end() && *at >> (shift + 3) == level[i]; ++at)
        mask = static_cast<std::uint8_t>(mask | 1 << (*at >> shift & 7));
      const int count = models.code_count(coder, before, std::popcount(mask));
      before = count - 1;
      const auto order = ranked_children(cells, centres, centres[i], std::ldexp(cube.side, -depth));
      mask = models.code_mask(coder, order, count, mask);
      for (std::uint64_t c = 0; c < 8; ++c) {
        if ((mask >> c & 1) != 0) next.push_back(level[i] * 8 + c);
      }
    }
    level = std::move(next);
  }
  std::vector<std::uint64_t> out;
  auto at = codes.begin();
  for (const std::uint64_t code : level) {
    std::uint32_t count = 0;
    for (; at != codes.end() && *at == code; ++at) ++count;
    count = models.code_points(coder, count);
    out.insert(out.end(), count, code);
  }
  return out;
}

class Octree2006 : public PointBaseline {
 public:
  explicit Octree2006(double cell_m)
      : PointBaseline("octree 2006", fmt::format("cells {:.3g} mm", cell_m * 1e3)),
        cell_m_(cell_m) {}

  Bytes encode(const PointList& points) const override {
    PointCube cube = cube_round(points);
    while (cube.cell() > cell_m_ && cube.levels < kMostLevels) ++cube.levels;
    // Leaves of exactly the size asked for; the cube grows to hold them.
    cube.side = std::ldexp(cell_m_, static_cast<int>(cube.levels));
    const auto levels = static_cast<int>(cube.levels);
    std::vector<std::uint64_t> codes;
    for (const Point3f& p : points) {
      codes.push_back(morton(cube.index(p.x, cube.x), cube.index(p.y, cube.y),
                             cube.index(p.z, cube.z), levels));
    }
    std::sort(codes.begin(), codes.end());
    Bytes out;
    put(out, cube);
    put_varint(out, points.size());
    if (points.empty()) return out;
    Bytes room(points.size() * 12 + 4096);
    Writer writer(room);
    (void)walk(writer, cube, codes);
    room.resize(writer.encoder.finish());
    if (writer.encoder.overflow()) fail(name(), "larger than the points");
    out.insert(out.end(), room.begin(), room.end());
    return out;
  }

  PointList decode(const Bytes& bytes) const override {
    ByteReader reader(bytes);
    const auto cube = reader.take<PointCube>();
    const std::uint64_t count = reader.take_varint();
    PointList out;
    if (count == 0) return out;
    if (cube.levels > kMostLevels) fail(name(), "too many levels");
    Reader coder(reader.rest());
    const auto levels = static_cast<int>(cube.levels);
    for (const std::uint64_t code : walk(coder, cube, {}))
      out.push_back(cell_centre(cube, code, levels));
    if (out.size() != count) fail(name(), "a wrong number of points came out");
    return out;
  }

 private:
  double cell_m_;
};

}  // namespace

std::unique_ptr<PointBaseline> octree2006(double cell_m) {
  return std::make_unique<Octree2006>(cell_m);
}

}  // namespace planecast::baselines
