// Runs the encoder's stages over frames of the simulator and scores what they find against the
// truth: surfaces, coefficients, points kept and bytes.
#pragma once

#include <cmath>
#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "core/fit/surface_quantise.hpp"
#include "core/model/inverse_noise.hpp"
#include "core/pipeline/stages.hpp"
#include "core/sim/surface_score.hpp"
#include "core/wire/key_packet.hpp"
#include "tests/core/pipeline/codec_bench.hpp"

namespace planecast::test {

/// Sums over frames.
struct RoomQuality {
  double bytes = 0, points_in = 0, points_out = 0;
  double truth = 0, found = 0, matched = 0;
  double coefficients = 0, within = 0;  ///< of matched planes; within 3 sigma of their covariance
  double surfaces = 0, frames = 0;
  /// True planes of those counted whose least-squares fit to their own readings has the right
  /// normal: what noise leaves to any codec that fits each plane for itself.
  double attainable = 0;

  void add(const RoomQuality& other) {
    bytes += other.bytes;
    points_in += other.points_in;
    points_out += other.points_out;
    truth += other.truth;
    found += other.found;
    matched += other.matched;
    coefficients += other.coefficients;
    within += other.within;
    surfaces += other.surfaces;
    frames += other.frames;
    attainable += other.attainable;
  }

  double ratio_percent() const { return 100 * (1 - bytes / (12 * points_in)); }
  double out_share() const { return points_out / points_in; }
  double precision() const { return matched / found; }
  double recall() const { return matched / truth; }
  double within_share() const { return within / coefficients; }
  double ceiling() const { return attainable / truth; }
};

/// The stages of one stream without the pipeline around them, so that a frame's surfaces can be
/// looked at.
struct StageBench {
  Arena arena;
  StreamTables tables;
  FilterStage filter;
  SegmentStage segment;
  FitStage fit;
  PackStage pack;
  FrameSlot slot;

  explicit StageBench(const StreamConfig& config) {
    Arena measuring = Arena::measuring();
    layout(measuring, config);
    arena = std::move(*Arena::map(measuring.bytes_needed()));
    layout(arena, config);
    std::vector<std::uint8_t> body(kMaxKeyBodyBytes);
    body.resize(write_key_body(config, body));
    EXPECT_EQ(tables.build(config, key_hash(body)), Status::kOk);
    StageOptions options;
    options.slice_bytes = frame_capacity(config.camera.width, config.camera.height);
    filter.bind(tables, options);
    segment.bind(tables, options);
    fit.bind(tables, options);
    pack.bind(tables, options);
  }

  void layout(Arena& into, const StreamConfig& config) {
    const FrameLimits limits{config.camera.width, config.camera.height};
    tables.layout(into, limits);
    filter.layout(into, limits, FrameKind::kDepth);
    segment.layout(into, limits, FrameKind::kDepth);
    fit.layout(into, limits, FrameKind::kDepth);
    pack.layout(into, limits, FrameKind::kDepth);
    slot.layout(into, limits, FrameKind::kDepth);
  }

  void run(const std::vector<std::uint16_t>& depth) {
    std::copy(depth.begin(), depth.end(), slot.depth.begin());
    slot.begin(0, 0, 0);
    EXPECT_EQ(filter.process(slot), Status::kOk);
    EXPECT_EQ(segment.process(slot), Status::kOk);
    EXPECT_EQ(fit.process(slot), Status::kOk);
    EXPECT_EQ(pack.process(slot), Status::kOk);
  }

  /// Surface of each pixel as the surfaces contract codes it: 0 none, else index + 1.
  std::vector<std::uint8_t> pixel_labels() const {
    const RayTable& rays = tables.rays();
    std::vector<std::uint8_t> out(std::size_t{rays.width} * rays.height);
    for (std::uint32_t v = 0; v < rays.height; ++v) {
      for (std::uint32_t u = 0; u < rays.width; ++u) {
        const std::size_t i = std::size_t{v} * rays.width + u;
        const BlockLabel label = slot.blocks[std::size_t{v / 8} * ((rays.width + 7U) / 8) + u / 8];
        for (const std::uint8_t candidate : {label.first, label.second}) {
          if (candidate == 0 || out[i] != 0 || slot.depth[i] == 0) continue;
          const std::uint16_t at =
              surface_depth(slot.surfaces[candidate - 1U], rays.x(u, v), rays.y(u, v));
          const auto error = static_cast<std::uint32_t>(std::abs(int{at} - int{slot.depth[i]}));
          if (at != 0 && error <= tables.bounds().max_error(
                                      slot.depth[i], tables.bounds().ray_class(u / 8, v / 8))) {
            out[i] = candidate;
          }
        }
      }
    }
    return out;
  }
};

/// A stream of the simulator's sensor in which points off the surfaces (3 sigma) are dropped.
inline StreamConfig drop_stream(const RoomSimulator& simulator,
                                std::span<const std::uint16_t> first) {
  StreamConfig config = stream_of(simulator, first);
  set_case({"", FrameKind::kDepth, ToleranceKind::kSurfaces, 3, true}, config);
  return config;
}

inline std::vector<FoundSurface> found_surfaces(const StageBench& bench) {
  std::vector<FoundSurface> out;
  for (const Surface& s : bench.slot.surfaces.first(bench.slot.surface_count)) {
    out.push_back({double(s.a), double(s.b), double(s.c), double(s.d), double(s.e), double(s.f)});
  }
  return out;
}

/// Adds the coefficients of the planes that match to `sum`: how many, and how many lie within three
/// standard deviations, as the fit states them, of the truth.
inline void score_coefficients(const StageBench& bench, std::span<const TruthSurface> truth,
                               const SurfaceScore& score, double unit_m, RoomQuality& sum) {
  const RegionMap& regions = bench.fit.fitter().refined();
  const std::span<const RegionFit> fits = bench.fit.fitter().fits();
  std::vector<PlaneSigmas> sigmas(kMaxSurfaces);
  plane_sigmas(regions, fits, sigmas);
  const std::span<const Surface> found = bench.slot.surfaces.first(bench.slot.surface_count);
  for (std::size_t f = 0; f < found.size(); ++f) {
    if (score.truth_of[f] == 0 || found[f].curved()) continue;
    const TruthSurface& t = truth[score.truth_of[f] - 1U];
    // Metres to inverse-depth steps: n . p = distance is (n . ray) / distance = 1 / z.
    const double scale = 0x1p31 * unit_m / t.distance;
    for (int k = 0; k < regions.regions; ++k) {
      Surface rounded;
      if (!quantise_surface(fits[k].surface, bench.slot.shift, rounded) || rounded != found[f])
        continue;
      const FloatSurface& s = fits[k].surface;
      sum.coefficients += 3;
      sum.within += std::abs(s.a - scale * t.normal.x) <= 3 * sigmas[k].a;
      sum.within += std::abs(s.b - scale * t.normal.y) <= 3 * sigmas[k].b;
      sum.within += std::abs(s.c - scale * t.normal.z) <= 3 * sigmas[k].c;
      break;
    }
  }
}

/// Of each true plane's readings, told by `ids`, the least-squares plane: how many of at least 500
/// pixels are within two degrees of the truth. Faces that lie in one plane count as one.
inline double attainable_planes(const StageBench& bench, std::span<const TruthSurface> truth,
                                std::span<const std::uint16_t> ids,
                                std::span<const std::uint16_t> depth) {
  const RayTable& rays = bench.tables.rays();
  const InverseNoise noise(bench.tables.config());
  std::vector<PlaneSums> sums(truth.size());
  std::vector<std::uint32_t> pixels(truth.size());
  const auto same = [](const TruthSurface& a, const TruthSurface& b) {
    const Vec3 off = a.normal - b.normal;
    return a.kind == b.kind && dot(off, off) < 1e-12 && std::abs(a.distance - b.distance) < 1e-6;
  };
  std::vector<std::size_t> first(truth.size());
  for (std::size_t t = 0; t < truth.size(); ++t) {
    while (!same(truth[first[t]], truth[t])) ++first[t];
  }
  for (std::uint32_t i = 0; i < ids.size(); ++i) {
    if (ids[i] == 0) continue;
    const std::uint32_t u = i % rays.width, v = i / rays.width;
    const double x = rays.x(u, v) * 0x1p-27, y = rays.y(u, v) * 0x1p-27, w = 0x1p31 / depth[i];
    const double weight = 1 / (noise.sigma(w) * noise.sigma(w));
    PlaneSums one{1, x, y, x * x, x * y, y * y, w, x * w, y * w, w * w};
    sums[first[ids[i] - 1U]].add(one, weight);
    ++pixels[first[ids[i] - 1U]];
  }
  double out = 0;
  for (std::size_t t = 0; t < truth.size(); ++t) {
    FloatSurface plane;
    if (truth[t].kind != TruthSurface::Kind::kPlane || pixels[t] < ScoreOptions{}.min_pixels ||
        !sums[t].solve(plane)) {
      continue;
    }
    const Vec3 normal = found_normal({plane.a, plane.b, plane.c}, 0, 0);
    out += std::abs(dot(normal, truth[t].normal)) >= std::cos(2 * 3.14159265358979 / 180);
  }
  return out;
}

/// Codes and scores frames `first`, `first` + step, ... of one seed and adds to `sum`.
inline void score_room(const SimConfig& sim, std::uint64_t first, std::uint64_t step, int frames,
                       double min_width, RoomQuality& sum) {
  auto simulator = RoomSimulator::create(sim, room_scene());
  ASSERT_TRUE(simulator.ok());
  DepthImage image;
  std::vector<std::uint16_t> ids;
  Pose pose;
  std::unique_ptr<StageBench> bench;
  for (int i = 0; i < frames; ++i) {
    simulator->render(first + step * static_cast<std::uint64_t>(i), image, ids, pose);
    if (!bench) bench = std::make_unique<StageBench>(drop_stream(*simulator, image.depth));
    bench->run(image.depth);
    for (std::size_t k = 0; k < ids.size(); ++k) ids[k] = image.depth[k] == 0 ? 0 : ids[k];
    ScoreOptions options;
    options.min_width = min_width;
    const SurfaceScore score =
        score_surfaces(bench->tables.rays(), ids, simulator->surfaces(), bench->pixel_labels(),
                       found_surfaces(*bench), options);
    score_coefficients(*bench, simulator->surfaces(), score, sim.intrinsics.metres_per_unit, sum);
    sum.bytes += static_cast<double>(bench->slot.report.bytes);
    sum.points_in += bench->slot.counts.input;
    sum.points_out += bench->slot.counts.kept;
    if (min_width == 0)
      sum.attainable += attainable_planes(*bench, simulator->surfaces(), ids, image.depth);
    sum.truth += score.truth;
    sum.found += score.found;
    sum.matched += score.matched;
    sum.surfaces += bench->slot.surface_count;
    sum.frames += 1;
  }
}

}  // namespace planecast::test
