#include "bench/baselines/triangle_planes.hpp"

#include <algorithm>
#include <unordered_map>

#include "bench/baselines/byte_io.hpp"
#include "bench/baselines/delaunay.hpp"
#include "core/base/random.hpp"

namespace planecast::baselines {
namespace {

struct Vertex {
  float u, v;
};

std::uint64_t cell_of(const Eigen::Vector2d& p, double pitch) {
  const auto cell = [pitch](double x) {
    return static_cast<std::uint64_t>(static_cast<std::int64_t>(std::floor(x / pitch)) + (1 << 30));
  };
  return cell(p.x()) << 32 | cell(p.y());
}

std::vector<Vertex> choose_vertices(const std::vector<Eigen::Vector2d>& members, double pitch) {
  std::unordered_map<std::uint64_t, std::uint32_t> farthest;
  for (std::uint32_t i = 0; i < members.size(); ++i) {
    const auto [at, fresh] = farthest.try_emplace(cell_of(members[i], pitch), i);
    if (!fresh && members[i].squaredNorm() > members[at->second].squaredNorm()) at->second = i;
  }
  std::vector<std::uint32_t> chosen;
  for (const auto& [cell, i] : farthest) chosen.push_back(i);
  std::sort(chosen.begin(), chosen.end());
  std::vector<Vertex> out;
  for (const std::uint32_t i : chosen)
    out.push_back({static_cast<float>(members[i].x()), static_cast<float>(members[i].y())});
  return out;
}

// Vertices as the integers that both ends triangulate.
class Grid {
 public:
  explicit Grid(const std::vector<Vertex>& vertices) {
    double most = 1e-30;
    for (const Vertex& v : vertices)
      most = std::max({most, std::abs(double{v.u}), std::abs(double{v.v})});
    scale_ = static_cast<double>(kMostCoordinate) / most;
  }
  Point2i of(double u, double v) const {
    const auto limit = static_cast<double>(kMostCoordinate);
    return {std::llround(std::clamp(u * scale_, -limit, limit)),
            std::llround(std::clamp(v * scale_, -limit, limit))};
  }
  std::vector<Point2i> of(const std::vector<Vertex>& vertices) const {
    std::vector<Point2i> out;
    for (const Vertex& v : vertices) out.push_back(of(double{v.u}, double{v.v}));
    return out;
  }

 private:
  double scale_ = 1;
};

struct Axes {
  float value[9];  // origin, u, v
};

void put_patch(Bytes& out, const PlanePatch& patch, const std::vector<Eigen::Vector2d>& members,
               double pitch) {
  const std::vector<Vertex> vertices = choose_vertices(members, pitch);
  const Grid grid(vertices);
  Delaunay mesh(grid.of(vertices));
  std::vector<std::uint64_t> counts(std::max<std::size_t>(mesh.triangles().size(), 1), 0);
  for (const auto& p : members)
    ++counts[static_cast<std::size_t>(std::max(mesh.find(grid.of(p.x(), p.y())), 0))];
  Axes axes;
  for (int i = 0; i < 3; ++i) {
    axes.value[i] = static_cast<float>(patch.origin[i]);
    axes.value[3 + i] = static_cast<float>(patch.u[i]);
    axes.value[6 + i] = static_cast<float>(patch.v[i]);
  }
  put(out, axes);
  put_varint(out, vertices.size());
  for (const Vertex& v : vertices) put(out, v);
  for (const std::uint64_t count : counts) put_varint(out, count);
}

void take_patch(ByteReader& reader, Pcg32& random, PointList& out) {
  const auto axes = reader.take<Axes>();
  std::vector<Vertex> vertices(std::min<std::uint64_t>(reader.take_varint(), 1u << 24));
  for (Vertex& v : vertices) v = reader.take<Vertex>();
  if (vertices.empty()) fail("triangles", "a patch without vertices");
  auto triangles = Delaunay(Grid(vertices).of(vertices)).triangles();
  if (triangles.empty()) {  // all on a line: its ends stand for the points between
    triangles.push_back({0, 0, static_cast<std::uint32_t>(vertices.size() - 1)});
  }
  for (const auto& t : triangles) {
    for (std::uint64_t left = reader.take_varint(); left > 0; --left) {
      double a = random.uniform(), b = random.uniform();
      if (a + b > 1) {  // the other half of the parallelogram, folded back
        a = 1 - a;
        b = 1 - b;
      }
      const Vertex &p = vertices[t[0]], &q = vertices[t[1]], &r = vertices[t[2]];
      const double u = p.u + a * (q.u - p.u) + b * (r.u - p.u);
      const double v = p.v + a * (q.v - p.v) + b * (r.v - p.v);
      const float* o = axes.value;
      out.push_back({static_cast<float>(o[0] + u * o[3] + v * o[6]),
                     static_cast<float>(o[1] + u * o[4] + v * o[7]),
                     static_cast<float>(o[2] + u * o[5] + v * o[8])});
    }
  }
}

}  // namespace

std::size_t vertices_at(const std::vector<Eigen::Vector2d>& members, double pitch) {
  std::vector<std::uint64_t> cells;
  for (const auto& p : members) cells.push_back(cell_of(p, pitch));
  std::sort(cells.begin(), cells.end());
  return static_cast<std::size_t>(std::unique(cells.begin(), cells.end()) - cells.begin());
}

Bytes encode_triangles(const PointList& points, const VertexPitch& pitch) {
  const PlanePatches found = find_patches(points);
  Bytes out;
  put_varint(out, found.patches.size());
  for (const PlanePatch& patch : found.patches) {
    std::vector<Eigen::Vector2d> members;
    for (const std::uint32_t i : patch.members) {
      const Eigen::Vector3d d =
          Eigen::Vector3d(points[i].x, points[i].y, points[i].z) - patch.origin;
      members.emplace_back(d.dot(patch.u), d.dot(patch.v));
    }
    put_patch(out, patch, members, pitch(members));
  }
  put_varint(out, found.rest.size());
  for (const std::uint32_t i : found.rest) put(out, points[i]);
  return out;
}

PointList decode_triangles(const Bytes& bytes) {
  ByteReader reader(bytes);
  Pcg32 random(1);
  PointList out;
  for (std::uint64_t left = reader.take_varint(); left > 0; --left) take_patch(reader, random, out);
  for (std::uint64_t left = reader.take_varint(); left > 0; --left)
    out.push_back(reader.take<Point3f>());
  return out;
}

}  // namespace planecast::baselines
