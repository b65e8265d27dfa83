// The error contract as an independent reader would check it: in doubles, against the readings as
// they were submitted, with nothing of the codec's own bound tables.
#pragma once

#include <gtest/gtest.h>

#include <cmath>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "core/pipeline/decoder.hpp"
#include "core/pipeline/encoder.hpp"

namespace planecast::test {

/// What a stream allows a reading of `count` to move by [m]; 0 for lossless streams.
inline double bound_m(const StreamConfig& config, std::uint16_t count) {
  const double z = count * (static_cast<double>(config.camera.unit_pm) * 1e-12);
  switch (config.tolerance) {
    case ToleranceKind::kLossless:
      return 0;
    case ToleranceKind::kMetres:
      return config.tolerance_100nm * 1e-7;
    case ToleranceKind::kSigma:
    case ToleranceKind::kSurfaces:
      return config.sigmas_q16 / 65536.0 * config.noise.sigma_m(z);
  }
  return 0;
}

/// Distance [m] of a regenerated point from where the reading was.
inline double distance_m(const StreamTables& tables, std::uint32_t u, std::uint32_t v,
                         std::uint16_t count, const Point3f& point) {
  const CameraModel& camera = tables.config().camera;
  const double z = count * (static_cast<double>(camera.unit_pm) * 1e-12);
  double x = tables.rays().x(u, v) * 0x1p-27, y = tables.rays().y(u, v) * 0x1p-27;
  if (!camera.distorted()) {
    x = (u - camera.cx_q16 / 65536.0) / (camera.fx_q16 / 65536.0);
    y = (v - camera.cy_q16 / 65536.0) / (camera.fy_q16 / 65536.0);
  }
  const double dx = point.x - x * z, dy = point.y - y * z, dz = point.z - z;
  return std::sqrt(dx * dx + dy * dy + dz * dz);
}

/// What a frame came back as, against what was asked.
struct ContractReport {
  std::uint32_t input = 0, gated = 0, lost = 0, kept = 0;
  std::uint32_t broken = 0;  ///< points outside their bound, holes filled, gated readings kept
  double worst_share = 0;    ///< of the bound that the worst point used
  double worst_m = 0;        ///< largest distance of any point
  std::string first_broken;  ///< where and how
};

/// Compares the decoder's frame with the readings as submitted.
inline ContractReport check_contract(const Decoder& decoder, const StageOptions& stages,
                                     std::span<const std::uint16_t> original) {
  ContractReport out;
  const StreamConfig& config = decoder.config();
  const std::span<const std::uint16_t> depth = decoder.depth();
  const std::span<const Point3f> cloud = decoder.cloud();
  EXPECT_EQ(depth.size(), original.size());
  EXPECT_EQ(cloud.size(), original.size());
  if (depth.size() != original.size() || cloud.size() != original.size()) return out;
  const auto broken = [&](std::size_t i, const std::string& how) {
    if (out.broken++ == 0) {
      out.first_broken = "pixel " + std::to_string(i % config.camera.width) + "," +
                         std::to_string(i / config.camera.width) + ": " + how + " (reading " +
                         std::to_string(original[i]) + ", decoded " + std::to_string(depth[i]) +
                         ")";
    }
  };
  for (std::size_t i = 0; i < original.size(); ++i) {
    const std::uint16_t reading = original[i];
    const bool gated = reading != 0 && (reading < stages.range_min || reading > stages.range_max);
    out.input += reading != 0;
    out.gated += gated;
    if (std::isnan(cloud[i].z) != (depth[i] == 0)) broken(i, "depth and cloud disagree on a hole");
    if (reading == 0 || gated) {
      if (depth[i] != 0) broken(i, "a hole was filled");
      continue;
    }
    if (depth[i] == 0) {
      ++out.lost;
      continue;
    }
    ++out.kept;
    if (config.tolerance == ToleranceKind::kLossless) {
      if (depth[i] != reading) broken(i, "lossless, but another count");
      continue;
    }
    const auto u = static_cast<std::uint32_t>(i % config.camera.width);
    const auto v = static_cast<std::uint32_t>(i / config.camera.width);
    const double bound = bound_m(config, reading);
    const double distance = distance_m(decoder.tables(), u, v, reading, cloud[i]);
    out.worst_m = std::max(out.worst_m, distance);
    out.worst_share = std::max(out.worst_share, distance / bound);
    if (!(distance <= bound)) {
      broken(i, std::to_string(distance * 1e3) + " mm off, bound " + std::to_string(bound * 1e3));
    }
  }
  return out;
}

/// The balance of an encoded frame, and that decoding agrees with it.
inline void expect_balance(const PointCounts& counts, const ContractReport& report,
                           const StreamConfig& config, const StageOptions& stages) {
  EXPECT_EQ(counts.input, report.input);
  EXPECT_EQ(counts.out_of_range, report.gated);
  EXPECT_EQ(counts.outliers_dropped + counts.off_surface_dropped, report.lost);
  EXPECT_EQ(counts.kept, report.kept);
  EXPECT_EQ(counts.input, counts.out_of_range + counts.outliers_dropped +
                              counts.off_surface_dropped + counts.kept);
  if (!stages.drop_outliers) EXPECT_EQ(counts.outliers_dropped, 0U);
  if (!config.drop_off_surface) EXPECT_EQ(counts.off_surface_dropped, 0U);
  EXPECT_LE(counts.outliers_dropped, counts.outliers);
}

}  // namespace planecast::test
