// Everything a fit test needs around one camera: tables, segmenter, fitter and a plane renderer.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <utility>
#include <vector>

#include "core/fit/surface_fitter.hpp"
#include "core/segment/region_growing.hpp"

namespace planecast::test {

inline CameraModel fit_camera(std::uint32_t width, std::uint32_t height) {
  Intrinsics in;
  in.fx = in.fy = 400;
  in.cx = width / 2.0;
  in.cy = height / 2.0;
  return *quantise(in, width, height);
}

struct FitBench {
  StreamConfig config;
  std::vector<std::int32_t> storage;
  RayTable rays;
  Arena arena;
  LevelTable levels;
  BoundTable bounds;
  Segmenter segmenter;
  SurfaceFitter fitter;
  RegionMap regions;
  FitReport report;
  std::vector<BlockLabel> labels;
  std::vector<Surface> surfaces;

  explicit FitBench(StreamConfig stream) : config(std::move(stream)) {
    const CameraModel& camera = config.camera;
    storage.resize(ray_table_entries(camera));
    EXPECT_EQ(build_ray_table(camera, storage, rays), Status::kOk);
    arena = std::move(*Arena::map(32U << 20U));
    levels.layout(arena);
    bounds.layout(arena, camera.pixels());
    segmenter.layout(arena, camera.width, camera.height);
    fitter.layout(arena, camera.width, camera.height);
    EXPECT_FALSE(arena.failed());
    EXPECT_EQ(levels.build(config.lattice), Status::kOk);
    EXPECT_EQ(bounds.build(config, rays, levels), Status::kOk);
    labels.resize(std::size_t{(rays.width + 7U) / 8U} * ((rays.height + 7U) / 8U));
    surfaces.resize(kMaxSurfaces);
  }

  FitTables tables() const { return {&config, &rays, &levels, &bounds}; }

  Status run(const std::vector<std::uint16_t>& depth) {
    const Status status = segmenter.process(config, rays, depth, regions);
    if (status != Status::kOk) return status;
    return fitter.fit(tables(), depth, regions, labels, surfaces, report);
  }
};

inline StreamConfig fit_config(std::uint32_t width, std::uint32_t height,
                               ToleranceKind kind = ToleranceKind::kLossless) {
  StreamConfig out;
  out.camera = fit_camera(width, height);
  out.noise = {NoiseModel::Kind::kStereo, 2'000'000};
  out.tolerance = kind;
  out.tolerance_100nm = 100'000;
  out.sigmas_q16 = 3U << 16U;
  return out;
}

/// Depth count where the ray meets 1 / z = a x + b y + c (1 / counts).
inline double plane_depth(const RayTable& rays, std::uint32_t u, std::uint32_t v, double a,
                          double b, double c) {
  const double x = rays.x(u, v) * 0x1p-27, y = rays.y(u, v) * 0x1p-27;
  return 1.0 / (a * x + b * y + c);
}

}  // namespace planecast::test
