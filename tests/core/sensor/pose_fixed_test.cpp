// Poses in fixed point: bounds of the round trip, canonical form, refusals.
#include "core/sensor/pose_fixed.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/random.hpp"

namespace planecast {
namespace {

Pose random_pose(Pcg32& random) {
  auto spread = [&](double size) { return size * (2 * random.uniform() - 1); };
  Pose pose{spread(1), spread(1), spread(1), spread(1), spread(1e4), spread(1e4), spread(100)};
  const double norm =
      std::sqrt(pose.qw * pose.qw + pose.qx * pose.qx + pose.qy * pose.qy + pose.qz * pose.qz);
  pose.qw /= norm;
  pose.qx /= norm;
  pose.qy /= norm;
  pose.qz /= norm;
  return pose;
}

// Angle between two rotations, whatever the norms and signs.
double angle_between(const Pose& a, const Pose& b) {
  const double dot = a.qw * b.qw + a.qx * b.qx + a.qy * b.qy + a.qz * b.qz;
  const double s = dot < 0 ? -1 : 1;
  const double gap = std::sqrt(std::pow(a.qw - s * b.qw, 2) + std::pow(a.qx - s * b.qx, 2) +
                               std::pow(a.qy - s * b.qy, 2) + std::pow(a.qz - s * b.qz, 2));
  return 4 * std::asin(gap / 2);
}

TEST(PoseFixed, RoundTripWithin4NanoradiansAndHalfAMicrometre) {
  Pcg32 random(5);
  for (int i = 0; i < 20000; ++i) {
    const Pose pose = random_pose(random);
    PoseFixed fixed;
    ASSERT_EQ(to_fixed(pose, fixed), Status::kOk);
    ASSERT_EQ(check_pose(fixed), Status::kOk);
    const Pose back = to_pose(fixed);
    ASSERT_LT(angle_between(pose, back), 4e-9);
    ASSERT_NEAR(back.tx, pose.tx, 0.51e-6);
    ASSERT_NEAR(back.tz, pose.tz, 0.51e-6);
    PoseFixed again;
    ASSERT_EQ(to_fixed(back, again), Status::kOk);
    ASSERT_EQ(again, fixed);
  }
}

TEST(PoseFixed, OneRotationHasOneForm) {
  Pcg32 random(6);
  for (int i = 0; i < 1000; ++i) {
    const Pose pose = random_pose(random);
    Pose negated = pose;
    negated.qw = -pose.qw;
    negated.qx = -pose.qx;
    negated.qy = -pose.qy;
    negated.qz = -pose.qz;
    PoseFixed a, b;
    ASSERT_EQ(to_fixed(pose, a), Status::kOk);
    ASSERT_EQ(to_fixed(negated, b), Status::kOk);
    ASSERT_EQ(a, b);
  }
}

TEST(PoseFixed, QuaternionsOfAnyLengthAreNormalised) {
  for (const double scale : {1e-300, 1e-6, 0.3, 7.0, 1e12, 1e300}) {
    PoseFixed fixed;
    ASSERT_EQ(to_fixed(Pose{0, 3 * scale, 0, -4 * scale, 0, 0, 0}, fixed), Status::kOk);
    EXPECT_EQ(check_pose(fixed), Status::kOk);
    EXPECT_NEAR(fixed.q_q30[1], 0.6 * 1073741824, 1);
    EXPECT_NEAR(fixed.q_q30[3], -0.8 * 1073741824, 1);
  }
}

TEST(PoseFixed, RefusesWhatIsNoPose) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double inf = std::numeric_limits<double>::infinity();
  PoseFixed fixed;
  EXPECT_EQ(to_fixed(Pose{0, 0, 0, 0, 0, 0, 0}, fixed), Status::kFieldRange);
  for (const double bad : {nan, inf, -inf}) {
    EXPECT_EQ(to_fixed(Pose{1, bad, 0, 0, 0, 0, 0}, fixed), Status::kFieldRange);
    EXPECT_EQ(to_fixed(Pose{1, 0, 0, 0, 0, bad, 0}, fixed), Status::kFieldRange);
  }
  EXPECT_EQ(to_fixed(Pose{1, 0, 0, 0, 1.1e9, 0, 0}, fixed), Status::kFieldRange);
  EXPECT_EQ(fixed, PoseFixed{});
}

TEST(PoseFixed, CheckRefusesFormsThatToFixedDoesNotMake) {
  PoseFixed pose;
  EXPECT_EQ(check_pose(pose), Status::kOk);
  pose.q_q30 = {0, 0, 0, 0};
  EXPECT_EQ(check_pose(pose), Status::kFieldRange);
  pose.q_q30 = {1 << 29, 0, 0, 0};
  EXPECT_EQ(check_pose(pose), Status::kFieldRange);
  pose.q_q30 = {-(1 << 30), 0, 0, 0};
  EXPECT_EQ(check_pose(pose), Status::kFieldRange);
  pose.q_q30 = {std::numeric_limits<std::int32_t>::min(), 0, 0, 0};
  EXPECT_EQ(check_pose(pose), Status::kFieldRange);
  pose = PoseFixed{};
  pose.t_um[2] = -kMaxTranslationUm - 1;
  EXPECT_EQ(check_pose(pose), Status::kFieldRange);
}

}  // namespace
}  // namespace planecast
