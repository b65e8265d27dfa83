// Random stream configurations that check_config accepts, for property tests of every room that
// reads one: any sensor, lens, lattice, noise, bound, pose and name the format can say.
#pragma once

#include <gtest/gtest.h>

#include <algorithm>

#include "core/base/random.hpp"
#include "core/model/stream_config.hpp"

namespace planecast::test {

inline double between(Pcg32& random, double low, double high) {
  return low + (high - low) * random.uniform();
}

/// A camera of the given size with rays of at most about `reach` to each side; a quarter of them
/// with a mild distortion when `lens` is set.
inline CameraModel random_camera(Pcg32& random, std::uint32_t width, std::uint32_t height,
                                 double reach, bool lens) {
  Intrinsics in;
  const double side = std::max(width, height);
  in.fx = side / between(random, 0.3, reach) * 0.7;
  in.fy = in.fx * between(random, 0.9, 1.1);
  in.cx = width * between(random, 0.3, 0.7);
  in.cy = height * between(random, 0.3, 0.7);
  if (lens && random.below(4) == 0) {
    in.k1 = between(random, -0.05, 0.2);
    in.k2 = between(random, -0.01, 0.02);
    in.p1 = between(random, -0.002, 0.002);
    in.p2 = between(random, -0.002, 0.002);
    in.k3 = between(random, 0, 0.005);
  }
  constexpr double kUnits[] = {0.001, 0.0001, 0.00025, 0.0002, 0.01, 0.001, 1.0, 1e-6};
  in.metres_per_unit = kUnits[random.below(8)];
  const auto camera = quantise(in, width, height);
  EXPECT_TRUE(camera.ok()) << camera.error().message;
  return *camera;
}

inline PoseFixed random_pose(Pcg32& random) {
  Pose pose;
  pose.qw = between(random, -1, 1);
  pose.qx = between(random, -1, 1);
  pose.qy = between(random, -1, 1);
  pose.qz = between(random, 0.01, 1);
  pose.tx = between(random, -100, 100);
  pose.ty = between(random, -1e6, 1e6);
  pose.tz = between(random, -1e9, 1e9);
  PoseFixed out;
  EXPECT_EQ(to_fixed(pose, out), Status::kOk);
  return out;
}

/// C of a plausible lattice in 1/256 count, or any at all.
inline Lattice random_lattice(Pcg32& random) {
  Lattice out;
  if (random.below(2) == 0) return out;
  out.c_q8 = random.below(4) == 0 ? std::max(kMinLatticeCQ8, random.next())
                                  : static_cast<std::uint32_t>(between(random, 5e4, 2e6) * 256);
  out.offset_q16 = random.below(3) == 0 ? random.below(65536) : 0;
  out.truncated = random.below(3) == 0;
  return out;
}

/// Sets one of the error contracts with a bound of some counts to some hundred counts.
inline void random_tolerance(Pcg32& random, StreamConfig& config) {
  config.tolerance = static_cast<ToleranceKind>(random.below(4));
  const double unit = static_cast<double>(config.camera.unit_pm) * 1e-12;
  config.noise.kind = static_cast<NoiseModel::Kind>(random.below(3));
  const double s = config.noise.kind == NoiseModel::Kind::kStereo
                       ? between(random, 1e-4, 2e-2) * 0.001 / unit
                       : between(random, 0.2, 40) * unit;
  config.noise.s_e9 = static_cast<std::uint32_t>(std::clamp(s * 1e9, 0.0, 4e9));
  if (config.tolerance == ToleranceKind::kMetres)
    config.tolerance_100nm =
        static_cast<std::uint32_t>(std::min(between(random, 0, 60) * unit * 1e7, 4e9));
  if (config.tolerance >= ToleranceKind::kSigma)
    config.sigmas_q16 = static_cast<std::uint32_t>(between(random, 0.1, 5) * 65536);
  config.drop_off_surface = config.tolerance == ToleranceKind::kSurfaces && random.below(3) == 0;
}

/// Turns a random configuration into one of a points stream.
inline void make_points(Pcg32& random, StreamConfig& c) {
  c.kind = FrameKind::kPoints;
  c.camera = {};
  c.lattice = {};
  c.z_rule = ZRule::kProductInDouble;
  c.mirror_y = false;
  c.axes.q_q30 = PoseFixed{}.q_q30;
  c.points.max_points = 1 + random.below(kMaxFramePoints);
  c.points.step_pm = (std::uint64_t{random.next()} << 32U | random.next()) % (kMaxPointStepPm + 1);
  c.points.patch_unit_nm = 1 + random.below(kMaxPatchUnitNm);
  c.points.fill = static_cast<FillMode>(random.below(2));
  c.points.seed = random.next();
  c.noise.kind = NoiseModel::Kind::kTof;
  if (c.tolerance == ToleranceKind::kLossless) return;
  c.points.step_pm |= 1U;
  const std::uint64_t most = point_bound_pm(c) / c.points.step_pm;
  c.points.tolerance_steps = static_cast<std::uint32_t>(
      std::min<std::uint64_t>(kMaxPointToleranceSteps, most == 0 ? 0 : random.next() % (most + 1)));
}

/// Every field random within its range.
inline StreamConfig random_config(Pcg32& random, std::uint32_t max_side = 400,
                                  bool points_too = false) {
  StreamConfig c;
  c.stream = static_cast<std::uint8_t>(random.next());
  c.session = random.next();
  c.epoch_ns = static_cast<std::int64_t>(std::uint64_t{random.next()} << 32U | random.next());
  c.clock = static_cast<ClockDomain>(random.below(4));
  c.boot_id = random.next();
  c.period_ms = static_cast<std::uint16_t>(1 + random.below(65535));
  c.kind = static_cast<FrameKind>(random.below(2));
  c.camera =
      random_camera(random, 1 + random.below(max_side), 1 + random.below(max_side), 2.0, true);
  c.z_rule = static_cast<ZRule>(random.below(3));
  c.lattice = random_lattice(random);
  random_tolerance(random, c);
  c.effort_best = random.below(2) != 0;
  c.mirror_y = random.below(2) != 0;
  c.pose = random_pose(random);
  c.axes = random_pose(random);
  const std::uint32_t letters = random.below(kMaxFrameIdBytes + 1);
  for (std::uint32_t i = 0; i < letters; ++i)
    c.frame_id[i] = static_cast<char>(0x20 + random.below(0x5f));
  if (points_too && random.below(3) == 0) make_points(random, c);
  EXPECT_EQ(check_config(c), Status::kOk);
  return c;
}

}  // namespace planecast::test
