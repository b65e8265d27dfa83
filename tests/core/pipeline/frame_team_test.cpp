// Two threads share out the pieces of many frames: each piece is done once, by somebody, and all is
// seen by the caller; with a helper that sleeps, is late, or was never started.
#include "core/pipeline/frame_team.hpp"

#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <thread>
#include <vector>

namespace planecast {
namespace {

constexpr std::uint32_t kPieces = 8;

struct Job {
  std::uint64_t frame = 0;
  std::array<std::uint64_t, kPieces> done{};  // plain: the team must order them
  std::array<std::uint32_t, kPieces> times{};
  std::array<std::uint64_t, kMaxTeamWorkers> by{};
  std::uint32_t busy = 0;
};

void work(void* self, std::uint32_t piece, std::uint32_t worker) noexcept {
  auto& job = *static_cast<Job*>(self);
  job.done[piece] = job.frame;
  ++job.times[piece];
  ++job.by[worker];
  std::atomic<std::uint32_t> turns{0};
  while (turns.fetch_add(1) < job.busy) continue;
}

// The counts by worker are added by one thread each, so they need no atomics either.
std::uint64_t run_frames(FrameTeam& team, std::uint64_t frames, std::uint32_t busy, Job& job) {
  job.busy = busy;
  std::uint64_t wrong = 0;
  for (std::uint64_t frame = 1; frame <= frames; ++frame) {
    job.frame = frame;
    team.work().run(kPieces, work, &job);
    for (std::uint32_t i = 0; i < kPieces; ++i)
      wrong += job.done[i] != frame || job.times[i] != frame ? 1 : 0;
  }
  return wrong;
}

TEST(FrameTeam, DoesEachPieceOnceAlone) {
  FrameTeam team;
  Job job;
  EXPECT_EQ(run_frames(team, 100, 0, job), 0U);
  EXPECT_EQ(job.by[0], 100 * kPieces);
  EXPECT_EQ(job.by[1], 0U);
}

TEST(FrameTeam, DoesEachPieceOnceWithAHelper) {
  FrameTeam team;
  ASSERT_EQ(team.start({.name = "helper"}), 0);
  Job job;
  EXPECT_EQ(run_frames(team, 20'000, 20, job), 0U);
  EXPECT_EQ(job.by[0] + job.by[1], 20'000 * kPieces);
}

TEST(FrameTeam, HelperTakesAShareOfWorkThatLasts) {
  FrameTeam team;
  ASSERT_EQ(team.start({.name = "helper"}), 0);
  Job job;
  // Until it helped: on a busy machine it may come late to any one frame, never to all.
  for (int round = 0; round < 1000 && job.by[1] == 0; ++round) {
    job.times = {};
    ASSERT_EQ(run_frames(team, 10, 100'000, job), 0U);
  }
  EXPECT_GT(job.by[1], 0U);
}

TEST(FrameTeam, StartsAndStopsInAnyState) {
  FrameTeam team;
  team.stop();
  Job job;
  for (int round = 0; round < 50; ++round) {
    ASSERT_EQ(team.start({.name = "helper"}), 0);
    ASSERT_EQ(team.start({.name = "helper"}), 0);
    job.times = {};
    EXPECT_EQ(run_frames(team, static_cast<std::uint64_t>(round % 4), 0, job), 0U);
    team.stop();
    job.times = {};
    EXPECT_EQ(run_frames(team, 3, 0, job), 0U);
  }
}

TEST(FrameTeam, SaysWhoItIs) {
  static std::atomic<int> begun{0}, ended{0};
  begun = ended = 0;
  FrameTeam team;
  ASSERT_EQ(team.start(
                {.name = "helper"}, [](const char*) { ++begun; }, [](const char*) { ++ended; }),
            0);
  EXPECT_EQ(begun, 1);
  team.stop();
  EXPECT_EQ(ended, 1);
}

}  // namespace
}  // namespace planecast
