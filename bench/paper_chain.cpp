// The paper's chain on point files, step by step: time a point, points that are left, bits, errors.
// usage: paper_chain [options] FILE...     (--help lists the options)
#include <CLI/CLI.hpp>
#include <bit>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/arena.hpp"
#include "core/io/point_file.hpp"
#include "core/metrics/distance.hpp"
#include "core/pipeline/point_surfaces.hpp"
#include "core/regen/patch_fill.hpp"
#include "core/wire/patch_pack.hpp"
#include "core/wire/patch_unpack.hpp"

namespace planecast {
namespace {

struct Settings {
  std::vector<std::string> files;
  double units = 1, alpha = 0.02;
  std::size_t slice_bytes = 1200;
  std::string dump;
  bool times_only = false;
  PointStream stream;
  PointSurfaceOptions surfaces;
  PatchPackOptions pack;
};

double cpu_seconds() {
  timespec t{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
  return static_cast<double>(t.tv_sec) + 1e-9 * static_cast<double>(t.tv_nsec);
}

/// Prints what a step took since the last.
class StepClock {
 public:
  explicit StepClock(std::size_t points) : points_(static_cast<double>(points)) {}
  void step(const char* name) {
    const double now = cpu_seconds();
    std::printf("  %-10s %7.3f us/point\n", name, (now - last_) / points_ * 1e6);
    total_ += now - last_;
    last_ = cpu_seconds();
  }
  double total_us() const { return total_ / points_ * 1e6; }

 private:
  double points_;
  double last_ = cpu_seconds();
  double total_ = 0;
};

struct Chain {
  PointSurfaces surfaces;
  PatchPacker packer;
  std::span<std::uint8_t> packed;
  std::span<SlicePlace> places;

  void layout(Arena& arena, std::uint32_t n, const PointSurfaceOptions& options) {
    surfaces.layout(arena, n, options);
    packer.layout(arena);
    packed = arena.take<std::uint8_t>(std::size_t{n} * 8 + 65536);
    places = arena.take<SlicePlace>(65535);
  }
};

bool failed(const char* what, Status status) {
  if (status == Status::kOk) return false;
  std::fprintf(stderr, "paper_chain: %s: %s\n", what, std::string(to_string(status)).c_str());
  return true;
}

std::vector<Point3f> finite_points(const PointCloud& cloud, double units) {
  std::vector<Point3f> points;
  const auto scale = static_cast<float>(units);
  for (const Point3f& p : cloud.points) {
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z))
      points.push_back({p.x * scale, p.y * scale, p.z * scale});
  }
  return points;
}

/// The paper's boundary in float32: two coordinates a corner of each outline, 20 bytes a plane.
std::size_t outline_bits(std::span<const PatchDraft> drafts, std::span<const DraftCell> cells) {
  std::size_t corners = 0;
  for (const PatchDraft& d : drafts) {
    const auto inside = [&](std::int64_t i, std::int64_t j) {
      return i >= 0 && j >= 0 && i < d.wide && j < d.high &&
             cells[d.first_cell + static_cast<std::size_t>(j * d.wide + i)].inside();
    };
    for (std::int64_t j = 0; j <= d.high; ++j) {
      for (std::int64_t i = 0; i <= d.wide; ++i) {
        const int n = inside(i - 1, j - 1) + inside(i, j - 1) + inside(i - 1, j) + inside(i, j);
        const bool diagonal = n == 2 && inside(i - 1, j - 1) == inside(i, j);
        corners += n == 1 || n == 3 ? 1 : (diagonal ? 2 : 0);
      }
    }
  }
  return corners * 64 + drafts.size() * 160;
}

void report_errors(const char* name, const std::vector<Point3f>& a, const std::vector<Point3f>& b) {
  DistanceOptions options;
  options.point_to_plane = false;
  const CloudDistance d = cloud_distance(a, b, options);
  std::printf("  %-9s -> regenerated: rmse %8.2f mm, max %9.2f; back: %8.2f mm, max %9.2f\n", name,
              d.d1_ab * 1e3, d.hausdorff_ab * 1e3, d.d1_ba * 1e3, d.hausdorff_ba * 1e3);
}

bool dump(const std::string& prefix, const std::vector<Point3f>& points,
          std::span<const PointRole> roles, const std::vector<Point3f>& out) {
  std::FILE* kept_file = std::fopen((prefix + "-kept.txt").c_str(), "w");
  std::FILE* out_file = std::fopen((prefix + "-out.txt").c_str(), "w");
  if (kept_file == nullptr || out_file == nullptr) return false;
  for (std::size_t i = 0; i < points.size(); ++i) {
    std::fprintf(kept_file, "%.5f %.5f %.5f %d\n", points[i].x, points[i].y, points[i].z,
                 static_cast<int>(roles[i]));
  }
  for (const Point3f& p : out) std::fprintf(out_file, "%.5f %.5f %.5f\n", p.x, p.y, p.z);
  return std::fclose(kept_file) + std::fclose(out_file) == 0;
}

/// N points on the walls, floor and steps of a room, 3 mm of noise: as many square metres for every
/// N, so that spacing shrinks as N grows.
std::vector<Point3f> synthetic_room(std::size_t count) {
  Pcg32 random(1);
  std::vector<Point3f> points(count);
  for (Point3f& p : points) {
    const double u = 4 * random.uniform(), v = 4 * random.uniform();
    const double noise = 0.003 * (random.uniform() + random.uniform() - 1);
    const std::uint32_t face = random.below(4);
    const double step = face == 3 ? 0.3 * std::floor(v) : 0;
    const double x = face == 1 ? noise : u, y = face == 2 ? noise : v;
    const double z = face == 0 ? noise : (face == 3 ? 1 + step + noise : (face == 1 ? u : v));
    p = {static_cast<float>(x), static_cast<float>(y), static_cast<float>(z)};
  }
  return points;
}

int run_points(const std::string& file, const std::vector<Point3f>& points, const Settings& s);

int run_file(const std::string& file, const Settings& s) {
  if (file.starts_with("synthetic:"))
    return run_points(file, synthetic_room(std::stoul(file.substr(10))), s);
  const auto read = read_point_file(file);
  if (!read.ok()) {
    std::fprintf(stderr, "paper_chain: %s\n", read.error().message.c_str());
    return 3;
  }
  return run_points(file, finite_points(read.value(), s.units), s);
}

int run_points(const std::string& file, const std::vector<Point3f>& points, const Settings& s) {
  const auto n = static_cast<std::uint32_t>(points.size());
  Chain c;
  Arena measure = Arena::measuring();
  c.layout(measure, n, s.surfaces);
  auto mapped = Arena::map(measure.bytes_needed());
  if (!mapped.ok()) return 1;
  c.layout(mapped.value(), n, s.surfaces);
  std::printf("%s: %u points, %.0f bytes of memory a point\n", file.c_str(), n,
              static_cast<double>(measure.bytes_needed()) / n);
  PointSurfaces& found = c.surfaces;
  StepClock clock(n);
  if (failed("filter", found.filter(points, s.surfaces))) return 1;
  clock.step("filter");
  if (failed("segment", found.segment(points, s.surfaces))) return 1;
  clock.step("segment");
  if (failed("fit", found.fit(points, s.surfaces))) return 1;
  clock.step("fit");
  FrameReport report;
  if (failed("pack", c.packer.pack(found.drafts(), found.cells(), s.pack, s.slice_bytes, c.packed,
                                   c.places, report)))
    return 1;
  clock.step("pack");

  std::vector<Point3f> out(report.points);
  Arena decoder_memory = std::move(Arena::map(std::size_t{1} << 20U).value());
  PatchUnpacker unpacker;
  PatchFiller filler;
  unpacker.layout(decoder_memory);
  filler.layout(decoder_memory);
  std::size_t next = 0;
  for (std::uint32_t i = 0; i < report.slices; ++i) {
    const SlicePlace place = c.places[i];
    if (failed("unpack", unpacker.begin(c.packed.subspan(place.offset + kPacketHeaderBytes,
                                                         place.bytes - kPacketHeaderBytes))))
      return 1;
    Pcg32 generator = patch_generator(s.stream, 0, i);
    while (unpacker.left() > 0) {
      Patch patch;
      std::span<const std::uint8_t> inside;
      if (failed("unpack", unpacker.next(patch, inside))) return 1;
      if (failed("fill", filler.fill(patch, inside, s.stream, generator,
                                     std::span(out).subspan(next, patch.points))))
        return 1;
      next += patch.points;
    }
  }
  clock.step("decode");

  std::vector<Point3f> kept_points;
  for (std::uint32_t i = 0; i < n; ++i) {
    if (found.roles()[i] == PointRole::kOnSurface) kept_points.push_back(points[i]);
  }
  if (!s.dump.empty() && !dump(s.dump, points, found.roles(), out)) return 1;
  const PointRegionReport& regions = found.regions();
  std::printf(
      "  chain %.3f us/point; outliers %.1f %%, clusters %u, regions %u, planes %u (%.2f a "
      "region), intra %.2f mm, inter %.2f mm\n",
      clock.total_us(), 100.0 * found.cut().outliers / n, regions.clusters, regions.regions,
      found.planes(),
      regions.regions > 0 ? static_cast<double>(found.planes()) / regions.regions : 0.0,
      regions.intra_distance * 1e3, regions.inter_distance * 1e3);
  const std::uint32_t kept = found.on_surface();
  std::printf("  kept %u of %u points (%.1f %%), %zu out; %u patches, %u slices, %zu bytes\n", kept,
              n, 100.0 * kept / n, next, report.surfaces, report.slices, report.bytes);
  std::printf("  bits/point: packed %.3f (of those kept %.3f); outlines as float32 %.3f\n",
              8.0 * static_cast<double>(report.bytes) / n,
              8.0 * static_cast<double>(report.bytes) / kept,
              static_cast<double>(outline_bits(found.drafts(), found.cells())) / n);
  if (kept == 0 || s.times_only) return 0;
  report_errors("kept", kept_points, out);
  report_errors("original", points, out);
  return 0;
}

int run(int argc, char** argv) {
  CLI::App app{"The paper's chain on point files, step by step."};
  Settings s;
  bool absolute = false, random = false, voxels = false;
  // Before the options that overwrite it: what the method's own are.
  for (int i = 1; i < argc; ++i) voxels |= std::string_view(argv[i]) == "--voxels";
  PointSurfaceOptions& o = s.surfaces =
      point_surface_defaults(voxels ? PointMethod::kVoxels : PointMethod::kPaper, s.alpha);
  app.add_option("files", s.files, "point files, or synthetic:N")->required();
  app.add_option("--units", s.units, "metres in a unit of the files");
  app.add_option("--alpha", s.alpha, "pitch of the boundary [m]");
  app.add_flag("--voxels", voxels, "regions over voxels, not the paper's");
  app.add_option("--k", o.neighbours, "neighbours");
  app.add_option("--deviations", o.outlier_deviations, "of the outlier filter");
  app.add_option("--smoothness", o.regions.smoothness_deg, "[degrees]");
  app.add_option("--curvature", o.regions.curvature_limit, "limit of the curvature test");
  app.add_flag("--absolute", absolute, "PCL's curvature test");
  app.add_option("--min-points", o.planes.min_points, "of a region and of a plane");
  app.add_option("--distance", o.planes.distance_m, "of a plane's points [m]");
  app.add_option("--voxel", o.voxels.voxel_m, "side [m]");
  app.add_option("--points-per-voxel", o.voxels.points_per_voxel, "on average, at least");
  app.add_option("--voxel-smoothness", o.voxels.smoothness_deg, "[degrees]");
  app.add_option("--roughness", o.voxels.roughness, "curvature of a voxel");
  app.add_option("--points-per-cell", o.hull.points_per_cell, "of the boundary, at least");
  app.add_option("--least-points", o.hull.least_points, "of a part of a plane");
  app.add_option("--closing", o.hull.closing_rounds, "rounds");
  app.add_option("--height-log2", s.pack.height_log2, "steps of a surface's height");
  app.add_option("--slice-bytes", s.slice_bytes, "most bytes of a slice");
  app.add_flag("--random", random, "random points, as the paper");
  app.add_flag("--times", s.times_only, "no distances");
  app.add_option("--dump", s.dump, "writes PREFIX-kept.txt (x y z role) and PREFIX-out.txt");
  CLI11_PARSE(app, argc, argv);
  if (absolute) o.regions.test = CurvatureTest::kAbsolute;
  o.regions.min_points = o.voxels.min_points = o.planes.min_points;
  s.stream.fill = random ? FillMode::kRandom : FillMode::kLattice;
  s.stream.patch_unit_nm = o.patch_unit_nm = patch_unit_nm(s.alpha);
  int worst = 0;
  for (const std::string& file : s.files) worst = std::max(worst, run_file(file, s));
  return worst;
}

}  // namespace
}  // namespace planecast

int main(int argc, char** argv) {
  return planecast::run(argc, argv);
}
