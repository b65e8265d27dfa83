#include "bench/paper_steps.hpp"

#include "apps/common/frame_codec.hpp"
#include "bench/alpha_shape.hpp"
#include "core/filter/statistical_outliers.hpp"
#include "core/fit/point_planes.hpp"
#include "core/hull/occupancy_hull.hpp"
#include "core/regen/patch_fill.hpp"
#include "core/segment/point_normals.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/patch_pack.hpp"
#include "core/wire/patch_unpack.hpp"

namespace planecast::bench {
namespace {

constexpr float kReach_m = 1e6F;
constexpr double kHull3Bytes = 41.3, kHull2Bytes = 31.9;  // of the paper's Table 1, a hull point
constexpr std::size_t kPlaneTextBytes = 50, kPlaneFloatBytes = 20, kHullFloatBytes = 8;

void check(Status status, const char* step) {
  if (status != Status::kOk)
    throw std::runtime_error(std::string(step) + ": " + std::string(to_string(status)));
}

// The steps and their memory, taken once for all runs.
class Chain {
 public:
  Chain(std::size_t points, const ChainOptions& options) : options_(options) {
    const auto most = static_cast<std::uint32_t>(points);
    Arena measuring = Arena::measuring();
    layout(measuring, most);
    arena_ = std::move(*Arena::map(measuring.bytes_needed()));
    layout(arena_, most);
    flags_.resize(points);
    for (auto* column : {&x_, &y_, &z_, &curvature_}) column->resize(points);
    regions_.resize(points);
    members_.resize(points);
    planes_.resize(points / options.min_points + 1);
    stream_.max_points = most;
    stream_.patch_unit_nm = patch_unit_nm(options.alpha_m);
    stream_.seed = static_cast<std::uint32_t>(options.seed);
  }

  void encode(const baselines::PointList& points) {
    check(neighbours_.search(points, options_.k, kReach_m), "neighbours");
    const std::size_t n = neighbours_.size();
    const std::span<std::uint8_t> flags = std::span(flags_).first(n);
    check(flag_statistical_outliers(neighbours_.mean_distance(), options_.deviations, flags, cut_),
          "outliers");
    const PointNormals normals{std::span(x_).first(n), std::span(y_).first(n),
                               std::span(z_).first(n), std::span(curvature_).first(n)};
    check(estimate_normals(neighbours_, flags, normals), "normals");
    PointRegionOptions grow;
    grow.smoothness_deg = options_.smoothness_deg;
    grow.test = options_.curvature_test;
    grow.curvature_limit = options_.curvature_limit;
    grow.min_points = options_.min_points;
    const std::span<std::uint32_t> regions = std::span(regions_).first(n);
    // Search order does not depend on k: normals of one search are those of the other.
    const bool shared = options_.grow_k == options_.k;
    if (!shared) check(grow_neighbours_.search(points, options_.grow_k, kReach_m), "neighbours");
    check(growing_.grow(shared ? neighbours_ : grow_neighbours_, normals, grow, regions, report_),
          "regions");
    PointPlaneOptions fit;
    fit.distance_m = options_.distance_m;
    fit.min_points = options_.min_points;
    fit.seed = options_.seed;
    check(fitter_.fit(columns(), regions, report_.regions, fit, planes_, plane_count_,
                      std::span(members_).first(n), member_count_),
          "planes");
    hulls();
    pack();
  }

  std::size_t bytes() const { return packed_.bytes; }
  const PointRegionReport& regions() const { return report_; }
  std::uint32_t planes() const { return plane_count_; }

  void decode(FillMode fill, baselines::PointList& out) {
    PointStream stream = stream_;
    stream.fill = fill;
    out.clear();
    for (std::uint32_t s = 0; s < packed_.slices; ++s) {
      const SlicePlace place = places_[s];
      Pcg32 generator = patch_generator(stream, 0, s);
      check(unpacker_.begin(std::span(out_).subspan(place.offset + kPacketHeaderBytes,
                                                    place.bytes - kPacketHeaderBytes)),
            "slice");
      while (unpacker_.left() > 0) {
        Patch patch;
        std::span<const std::uint8_t> cells;
        check(unpacker_.next(patch, cells), "patch");
        const std::size_t at = out.size();
        out.resize(at + patch.points);
        check(filler_.fill(patch, cells, stream, generator, std::span(out).subspan(at)), "fill");
      }
    }
  }

  void describe(ChainResult& result) const {
    result.clusters = report_.clusters;
    result.regions = report_.regions;
    result.planes = plane_count_;
    result.in_regions = report_.points;
    result.in_planes = kept_.size();
    result.intra_mm = report_.intra_distance * 1e3;
    result.inter_mm = report_.inter_distance * 1e3;
    result.bytes = packed_.bytes;
    result.hull_points = alpha_corners();
    const PointColumns c = columns();
    for (std::uint32_t i = 0; i < neighbours_.size(); ++i) {
      if (flags_[i] == 0) result.filtered_cloud.push_back({c.x[i], c.y[i], c.z[i]});
    }
    result.filtered = result.filtered_cloud.size();
    for (const std::uint32_t i : kept_) {
      result.kept_cloud.push_back({c.x[i], c.y[i], c.z[i]});
    }
  }

 private:
  void layout(Arena& arena, std::uint32_t most) {
    neighbours_.layout(arena, most, options_.k);
    if (options_.grow_k != options_.k) grow_neighbours_.layout(arena, most, options_.grow_k);
    growing_.layout(arena, most);
    fitter_.layout(arena, most);
    packer_.layout(arena);
    unpacker_.layout(arena);
    filler_.layout(arena);
  }

  PointColumns columns() const { return {neighbours_.x(), neighbours_.y(), neighbours_.z()}; }

  void hulls() {
    cells_.resize(hull_cells(member_count_, plane_count_, {}));
    drafts_.resize(hull_drafts(member_count_, plane_count_, {}));
    hulls_ = {.cells = cells_, .drafts = drafts_};
    kept_.clear();
    for (const PointPlane& plane : std::span(planes_).first(plane_count_)) {
      const std::span<std::uint32_t> own = std::span(members_).subspan(plane.first, plane.count);
      std::uint32_t kept = 0;
      check(make_hulls(plane, own, columns(), patch_unit_m(stream_), {}, hulls_, kept), "hull");
      kept_.insert(kept_.end(), own.begin(), own.begin() + kept);
    }
  }

  // Bytes are few; room for the worst is doubled until it is enough.
  void pack() {
    if (out_.empty()) out_.resize(std::size_t{1} << 20U);
    places_.resize(65535);
    const std::span<const PatchDraft> drafts = std::span(drafts_).first(hulls_.drafts_used);
    for (;;) {
      packed_ = {};
      const Status status = packer_.pack(drafts, std::span(cells_).first(hulls_.cells_used), {},
                                         kFileSliceBytes, out_, places_, packed_);
      if (status != Status::kTooLarge || out_.size() > (std::size_t{1} << 30U))
        return check(status, "pack");
      out_.resize(out_.size() * 2);
    }
  }

  // Corners of the alpha shapes of all planes.
  std::size_t alpha_corners() const {
    std::size_t corners = 0;
    const PointColumns c = columns();
    baselines::PointList own;
    for (const PointPlane& plane : std::span(planes_).first(plane_count_)) {
      own.clear();
      for (const std::uint32_t i : std::span(members_).subspan(plane.first, plane.count))
        own.push_back({c.x[i], c.y[i], c.z[i]});
      corners += alpha_shape(own, {plane.a, plane.b, plane.c}, options_.paper_alpha_m).corners;
    }
    return corners;
  }

  ChainOptions options_;
  Arena arena_;
  PointNeighbours neighbours_, grow_neighbours_;
  PointRegionGrowing growing_;
  PointPlaneFitter fitter_;
  PatchPacker packer_;
  PatchUnpacker unpacker_;
  PatchFiller filler_;
  PointStream stream_;
  StatisticalCut cut_;
  PointRegionReport report_;
  FrameReport packed_;
  std::vector<std::uint8_t> flags_, out_;
  std::vector<float> x_, y_, z_, curvature_;
  std::vector<std::uint32_t> regions_, members_, kept_;
  std::vector<PointPlane> planes_;
  std::vector<PatchDraft> drafts_;
  std::vector<DraftCell> cells_;
  std::vector<SlicePlace> places_;
  HullOutput hulls_;
  std::uint32_t plane_count_ = 0, member_count_ = 0;
};

template <class F>
double cpu_ms(bool timed, F&& f) {
  constexpr int kTimes = 3, kWarmUps = 1;
  std::vector<double> ms;
  for (int i = 0; i < (timed ? kTimes + kWarmUps : 1); ++i) {
    const double begin = thread_cpu_ms();
    f();
    if (!timed || i >= kWarmUps) ms.push_back(thread_cpu_ms() - begin);
  }
  return median_ms(std::move(ms));
}

}  // namespace

ChainOptions pcl_options() {
  ChainOptions options;
  options.k = 50;
  options.curvature_test = CurvatureTest::kAbsolute;
  options.curvature_limit = 1;
  return options;
}

PaperBytes paper_bytes(const ChainResult& chain) {
  PaperBytes bytes;
  const auto hull = static_cast<double>(chain.hull_points);
  bytes.hull3 = static_cast<std::size_t>(hull * kHull3Bytes);
  bytes.hull2 = static_cast<std::size_t>(hull * kHull2Bytes);
  bytes.coefficients = chain.planes * kPlaneTextBytes;
  bytes.float32 = chain.hull_points * kHullFloatBytes + chain.planes * kPlaneFloatBytes;
  return bytes;
}

ChainResult run_chain(const baselines::PointList& points, const ChainOptions& options, bool timed) {
  ChainResult result;
  result.points = points.size();
  Chain chain(points.size(), options);
  result.encode_ms = cpu_ms(timed, [&] { chain.encode(points); });
  chain.describe(result);
  result.decode_ms = cpu_ms(timed, [&] { chain.decode(FillMode::kRandom, result.random_cloud); });
  chain.decode(FillMode::kLattice, result.lattice_cloud);
  return result;
}

}  // namespace planecast::bench
