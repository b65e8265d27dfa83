// A time budget takes effort from frames that would overrun it, gives it back when there is time,
// and never touches the bound. Time is a counter here: nothing depends on this machine's.
#include "core/pipeline/frame_budget.hpp"

#include <gtest/gtest.h>

#include "tests/core/pipeline/codec_bench.hpp"

namespace planecast {
namespace {

using namespace test;

constexpr std::int64_t kMs = 1'000'000;

std::int64_t fake_ns = 0;    // the time
std::int64_t fake_step = 0;  // what every look at the clock takes

SimStream budgeted_stream(std::uint64_t frames) {
  return kSanitized ? sim_stream(80, 60, frames) : sim_stream(160, 120, frames);
}

std::int64_t fake_clock() noexcept {
  return fake_ns += fake_step;
}

TEST(FrameBudget, WithoutALimitAllFramesGetAll) {
  FrameBudget budget;
  budget.set(0, fake_clock, 307'200);
  EXPECT_FALSE(budget.limited());
  EXPECT_EQ(budget.plan(TimedStage::kSegment, FrameEffort::kFull, 1000 * kMs), FrameEffort::kFull);
}

TEST(FrameBudget, PlansByWhatStagesTook) {
  FrameBudget budget;
  budget.set(20 * kMs, fake_clock, 307'200);
  for (int i = 0; i < 200; ++i) {
    budget.learn(TimedStage::kSegment, FrameEffort::kFull, 2 * kMs);
    budget.learn(TimedStage::kFit, FrameEffort::kFull, 3 * kMs);
    budget.learn(TimedStage::kPack, FrameEffort::kFull, 10 * kMs);
  }
  const auto plan = [&](std::int64_t spent) {
    return budget.plan(TimedStage::kSegment, FrameEffort::kFull, spent);
  };
  EXPECT_EQ(plan(0), FrameEffort::kFull);
  EXPECT_EQ(plan(2 * kMs), FrameEffort::kFull);
  EXPECT_GT(plan(4 * kMs), FrameEffort::kFull);
  EXPECT_EQ(plan(19 * kMs), FrameEffort::kNeighbours);
  budget.learn(TimedStage::kPack, FrameEffort::kFull, 16 * kMs);  // once is enough
  EXPECT_GT(plan(0), FrameEffort::kFull);
}

TEST(FrameBudget, NeverRaisesTheEffortOfAFrameNorGoesBelowTheLeast) {
  FrameBudget budget;
  budget.set(20 * kMs, fake_clock, 307'200, FrameEffort::kPlanes);
  EXPECT_EQ(budget.plan(TimedStage::kFit, FrameEffort::kPlanes, 0), FrameEffort::kPlanes);
  EXPECT_EQ(budget.plan(TimedStage::kSegment, FrameEffort::kFull, 50 * kMs), FrameEffort::kPlanes);
}

TEST(FrameBudget, TriesAgainWhatWasTooSlow) {
  FrameBudget budget;
  budget.set(20 * kMs, fake_clock, 307'200);
  budget.learn(TimedStage::kPack, FrameEffort::kFull, 40 * kMs);
  const auto plan = [&] { return budget.plan(TimedStage::kPack, FrameEffort::kFull, 0); };
  EXPECT_NE(plan(), FrameEffort::kFull);
  for (int i = 0; i < 100; ++i) budget.learn(TimedStage::kPack, FrameEffort::kRuns, kMs);
  EXPECT_EQ(plan(), FrameEffort::kFull);
}

struct BudgetRun {
  FrameEffort effort = FrameEffort::kFull;
  std::uint32_t run_tiles = 0, surfaces = 0;
  Coded coded;
};

class BudgetedEncoder {
 public:
  BudgetedEncoder(const SimStream& stream, const StreamCase& c, double budget_ms)
      : source_(stream, c) {
    EncoderConfig config = encoder_config(stream, c);
    config.budget_ms = budget_ms;
    config.clock = fake_clock;
    encoder_ = make_encoder(config);
  }

  BudgetRun run(std::uint64_t i) {
    BudgetRun out;
    EXPECT_EQ(source_.submit(*encoder_, i), Status::kOk);
    EncodedFrame frame;
    if (!encoder_->try_next(frame)) {
      ADD_FAILURE();
      return out;
    }
    out = {frame.slot->effort, frame.slot->report.run_tiles, frame.slot->report.surfaces,
           copy_of(frame)};
    encoder_->release(frame);
    return out;
  }

  std::vector<std::uint16_t> decoded(const BudgetRun& run) {
    const auto decoder = make_decoder();
    EXPECT_EQ(decoder->set_key(key_of(*encoder_)), Status::kOk);
    decode_frame(*decoder, run.coded);
    return {decoder->depth().begin(), decoder->depth().end()};
  }

 private:
  Source source_;
  std::unique_ptr<Encoder> encoder_;
};

TEST(FrameBudget, FramesGetLessEffortAsTimeRunsOutAndAllOfItBack) {
  const SimStream stream = budgeted_stream(1);
  BudgetedEncoder encoder(stream, kStreamCases[2], 10);
  fake_step = 0;
  BudgetRun run;
  for (std::uint64_t i = 0; i < 400 && run.effort != FrameEffort::kFull; ++i) run = encoder.run(i);
  run = encoder.run(0);
  EXPECT_EQ(run.effort, FrameEffort::kFull);
  EXPECT_GT(run.surfaces, 0U);
  EXPECT_EQ(run.run_tiles, 0U);
  fake_step = kMs;  // dozens of looks a frame: no time for all
  run = encoder.run(0);
  EXPECT_EQ(run.effort, FrameEffort::kRuns);
  EXPECT_GT(run.run_tiles, 0U);
  fake_step = 20 * kMs;  // every stage is too late
  for (std::uint64_t i = 0; i < 3; ++i) run = encoder.run(i);
  EXPECT_EQ(run.effort, FrameEffort::kRuns);
  EXPECT_EQ(run.surfaces, 0U);
  fake_step = 0;
  for (std::uint64_t i = 0; i < 1000 && run.effort != FrameEffort::kFull; ++i) run = encoder.run(i);
  EXPECT_EQ(run.effort, FrameEffort::kFull);
}

TEST(FrameBudget, EveryEffortKeepsTheBound) {
  const SimStream stream = budgeted_stream(2);
  for (const std::int64_t step : {std::int64_t{0}, kMs / 20, kMs / 5, kMs, 50 * kMs}) {
    BudgetedEncoder encoder(stream, kStreamCases[0], 10);
    fake_step = step;
    for (std::uint64_t i = 0; i < 4; ++i) {
      const BudgetRun run = encoder.run(i);
      ASSERT_EQ(run.coded.status, Status::kOk);
      EXPECT_EQ(encoder.decoded(run), stream.frames[i % 2]) << "step " << step;
    }
  }
}

TEST(FrameBudget, StreamsThatDropWhatIsOffTheSurfacesAlwaysHaveSome) {
  const SimStream stream = budgeted_stream(1);
  BudgetedEncoder encoder(stream, kStreamCases[4], 1);
  fake_step = 50 * kMs;
  for (std::uint64_t i = 0; i < 3; ++i) {
    const BudgetRun run = encoder.run(i);
    EXPECT_GT(run.surfaces, 0U);
    EXPECT_GT(run.coded.counts.kept, run.coded.counts.input / 2);
  }
}

}  // namespace
}  // namespace planecast
