// The real runner on real threads, by chance: stages that fail and dawdle, a source that waits or
// drops, a consumer that stalls, an onlooker, stops of both kinds at any moment and starts after
// them. What Spin and relacy prove in the small must hold here; ThreadSanitizer watches.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <thread>

#include "core/base/random.hpp"
#include "tests/core/pipeline/fake_stages.hpp"

namespace planecast::test {
namespace {

int stress_seconds() {
  const char* given = std::getenv("PLANECAST_STRESS_SECONDS");
  return given != nullptr ? std::atoi(given) : PLANECAST_STRESS_SECONDS;
}

void dawdle(Pcg32& random) {
  const std::uint32_t kind = random.below(8);
  if (kind == 0) std::this_thread::yield();
  if (kind == 1) std::this_thread::sleep_for(std::chrono::microseconds(random.below(200)));
}

/// One runner for one life of several starts and stops.
class Life {
 public:
  explicit Life(std::uint64_t seed) : random_(seed), chain_(config(random_)) {
    for (std::uint32_t i = 0; i < FakeChain::kStages; ++i) {
      chain_.stages[i].fails = random_.below(3) == 0;
      pace_[i] = Pcg32(seed * 31 + i);
      chain_.stages[i].extra = [this, i] { dawdle(pace_[i]); };
    }
  }

  void run() {
    ASSERT_EQ(chain_.init_status, Status::kOk);
    std::thread consumer([this] { consume(); });
    std::thread onlooker([this] { look(); });
    const int starts = 1 + static_cast<int>(random_.below(3));
    for (int i = 0; i < starts; ++i) one_start(i + 1 == starts);
    consumer.join();
    over_ = true;
    onlooker.join();
    expect_nothing_lost();
  }

 private:
  static RunnerConfig config(Pcg32& random) {
    RunnerConfig config = config_of(RunMode::kThreads, 1 + random.below(6));
    config.spin_ns = random.below(3) == 0 ? 20'000 : 0;
    return config;
  }

  void one_start(bool last) {
    EXPECT_TRUE(chain_.runner.start().ok());
    const std::uint64_t frames = 20 + random_.below(200);
    const std::uint64_t seed = random_.next();
    std::thread source([this, frames, seed] {
      Pcg32 random(seed);
      for (std::uint64_t i = 0; i < frames; ++i) {
        dawdle(random);
        accepted_ += chain_.offer(++offered_, random.below(2) == 0) ? 1 : 0;
      }
    });
    if (random_.below(2) == 0) source.join();  // else the stop meets a source at work
    if (source.joinable())
      std::this_thread::sleep_for(std::chrono::microseconds(random_.below(3000)));
    chain_.runner.stop(random_.below(2) == 0 ? StopMode::kDrain : StopMode::kDiscard);
    if (source.joinable()) source.join();
    if (last) last_stop_ = true;
  }

  // pop_done() ends at every stop; the consumer stays until the last one is through.
  void consume() {
    Pcg32 random(17);
    for (;;) {
      const bool ending = last_stop_;
      std::uint32_t handle = 0;
      while (chain_.runner.pop_done(handle)) {
        dawdle(random);
        const Seen seen = chain_.take(handle);
        in_order_ = in_order_ && seen.frame > last_seen_;
        last_seen_ = seen.frame;
        ++delivered_;
      }
      if (ending) return;
      std::this_thread::yield();
    }
  }

  void look() {
    while (!over_) {
      const FrameTotals totals = chain_.runner.totals();
      balanced_ = balanced_ && totals.in >= totals.ok + totals.failed + totals.dropped;
      for (std::uint32_t i = 0; i < chain_.runner.stage_count(); ++i) {
        (void)chain_.runner.report(i);
        (void)chain_.runner.stalled(i, 1'000'000);
      }
      std::this_thread::sleep_for(std::chrono::microseconds(300));
    }
  }

  void expect_nothing_lost() {
    const FrameTotals totals = chain_.runner.totals();
    expect_balance(totals);
    EXPECT_EQ(totals.in, offered_);
    EXPECT_EQ(totals.ok + totals.failed, accepted_);
    EXPECT_EQ(delivered_, accepted_);
    EXPECT_TRUE(in_order_);
    EXPECT_TRUE(balanced_);
    std::size_t free = 0;
    while (chain_.runner.claim()) ++free;
    EXPECT_EQ(free, chain_.slots.size()) << "slots that never came back";
  }

  Pcg32 random_;
  std::array<Pcg32, FakeChain::kStages> pace_{Pcg32(0), Pcg32(0), Pcg32(0), Pcg32(0)};
  FakeChain chain_;
  std::uint64_t offered_ = 0, accepted_ = 0;  // the source's, read after it
  std::uint64_t delivered_ = 0, last_seen_ = 0;
  bool in_order_ = true, balanced_ = true;
  std::atomic<bool> last_stop_{false}, over_{false};
};

TEST(StageRunnerStress, LosesDoublesAndRacesNothing) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(stress_seconds());
  std::uint64_t lives = 0;
  for (; std::chrono::steady_clock::now() < end && !HasFailure(); ++lives) {
    SCOPED_TRACE(lives);
    Life(lives + 1).run();
  }
  EXPECT_GT(lives, 0U);
  RecordProperty("lives", std::to_string(lives));
  std::printf("%llu lives\n", static_cast<unsigned long long>(lives));
}

}  // namespace
}  // namespace planecast::test
