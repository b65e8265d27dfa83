#include "apps/planecastd/memory_plan.hpp"

#include <gtest/gtest.h>

#include <charconv>
#include <memory>
#include <ostream>
#include <string>

namespace planecast {
namespace {

MemoryNeeds needs_of(FrameKind kind, std::uint32_t width, std::uint32_t height,
                     std::uint64_t preloaded) {
  MemoryNeeds needs;
  StreamConfig& stream = needs.encoder.stream;
  Intrinsics intrinsics;
  intrinsics.fx = intrinsics.fy = width;
  intrinsics.cx = width / 2.0;
  intrinsics.cy = height / 2.0;
  stream.kind = kind;
  stream.camera = quantise(intrinsics, width, height).value();
  if (kind == FrameKind::kPoints) {
    stream.camera = {};
    stream.points.max_points = width * height;
    stream.tolerance = height > 1 ? ToleranceKind::kSurfaces : ToleranceKind::kMetres;
    stream.sigmas_q16 = 3 << 16;
    stream.tolerance_100nm = 50'000;
    stream.points.step_pm = 10'000'000;
    stream.points.tolerance_steps = 400;
    stream.points.patch_unit_nm = 78'125;
    needs.encoder.stages.paper = height > 2;
  }
  stream.noise.kind = NoiseModel::Kind::kTof;
  stream.noise.s_e9 = 5'000'000;
  needs.publisher = publisher_for(needs.encoder, "PLANECAST", 1200);
  needs.preloaded_frames = preloaded;
  return needs;
}

struct Case {
  FrameKind kind;
  std::uint32_t width, height;
  std::uint64_t preloaded;
};

void PrintTo(const Case& c, std::ostream* out) {
  *out << (c.kind == FrameKind::kDepth    ? "depth "
           : c.kind == FrameKind::kPoints ? "list "
                                          : "raw cloud ")
       << c.width << 'x' << c.height << ", " << c.preloaded << " preloaded";
}

class MemoryPlanOf : public testing::TestWithParam<Case> {};

}  // namespace

TEST_P(MemoryPlanOf, IsExactlyWhatIsTaken) {
  const Case& c = GetParam();
  const MemoryNeeds needs = needs_of(c.kind, c.width, c.height, c.preloaded);
  const MemoryPlan plan = plan_memory(needs).value();
  auto memory = std::move(take_memory(needs, plan, {}).value());
  EXPECT_EQ(memory.arena.capacity(), plan.arena);
  EXPECT_EQ(memory.preloaded.size(), c.preloaded);
  const auto encoder = Encoder::create(needs.encoder, memory.encoder);
  ASSERT_TRUE(encoder.ok()) << encoder.error().message;
  EXPECT_EQ((*encoder)->memory_in_use(), plan.encoder);
  const auto link = LcmLink::open(parse_lcm_url("memq://").value(), false).value();
  const auto publisher = Publisher::create(needs.publisher, link, &memory.arena);
  ASSERT_TRUE(publisher.ok()) << publisher.error().message;
  EXPECT_EQ(memory.arena.bytes_used(), plan.arena);
  EXPECT_FALSE(memory.arena.failed());
}

INSTANTIATE_TEST_SUITE_P(
    Streams, MemoryPlanOf,
    testing::Values(Case{FrameKind::kDepth, 640, 480, 0}, Case{FrameKind::kDepth, 37, 23, 5},
                    Case{FrameKind::kDepth, 1, 1, 1}, Case{FrameKind::kRawCloud, 61, 45, 3},
                    Case{FrameKind::kPoints, 3000, 1, 2}, Case{FrameKind::kPoints, 1500, 2, 0},
                    Case{FrameKind::kPoints, 700, 3, 1}));

TEST(MemoryPlan, LinesAddUpToTheTotal) {
  const MemoryNeeds needs = needs_of(FrameKind::kDepth, 320, 240, 7);
  const MemoryPlan plan = plan_memory(needs).value();
  std::size_t arena = 0, stacks = 0, total = 0;
  for (const std::string& line : to_lines(plan, needs, 12345)) {
    const std::size_t at = line.find_first_of("0123456789");
    std::size_t bytes = 0;
    std::from_chars(line.data() + at, line.data() + line.size(), bytes);
    if (line.starts_with("arena")) arena = bytes;
    if (line.starts_with("stacks")) stacks = bytes;
    if (line.starts_with("total")) total = bytes;
  }
  EXPECT_EQ(arena, plan.arena);
  EXPECT_EQ(total, arena + stacks);
  EXPECT_GE(arena, plan.encoder + plan.publisher + plan.preloaded);
  EXPECT_EQ(plan.preloaded, 7U * 320 * 240 * 2);
}

TEST(MemoryPlan, PublisherHoldsTheLargestFrameThereIs) {
  const MemoryNeeds needs = needs_of(FrameKind::kDepth, 640, 480, 0);
  EXPECT_GE(needs.publisher.max_packets, 4800U + 1);  // a slice a block, and the key packet
  EXPECT_GE(needs.publisher.message_bytes, 1200U);
  EXPECT_GE(publisher_for(needs.encoder, "X", 256).message_bytes, 354U) << "a key packet must fit";
}

}  // namespace planecast
