// A stage at work must not pay for those that wait: on two cores they sleep, and the kernel's own
// count of how often each thread was switched shows it.
#include <gtest/gtest.h>
#include <sched.h>
#include <time.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <string>

#include "tests/core/pipeline/fake_stages.hpp"

namespace planecast::test {
namespace {

/// Leaves this process two cores at most, as on a small board, for one test.
class TwoCores {
 public:
  TwoCores() {
    sched_getaffinity(0, sizeof(before_), &before_);
    cpu_set_t two;
    CPU_ZERO(&two);
    for (int core = 0; core < CPU_SETSIZE && CPU_COUNT(&two) < 2; ++core)
      if (CPU_ISSET(core, &before_)) CPU_SET(core, &two);
    sched_setaffinity(0, sizeof(two), &two);
  }
  ~TwoCores() { sched_setaffinity(0, sizeof(before_), &before_); }

 private:
  cpu_set_t before_;
};

/// How often all other threads of the process were put on a core or taken off, so far.
std::uint64_t switches_of_others() {
  const auto self = static_cast<long>(gettid());
  std::uint64_t sum = 0;
  for (const auto& task : std::filesystem::directory_iterator("/proc/self/task")) {
    if (task.path().filename() == std::to_string(self)) continue;
    std::ifstream status(task.path() / "status");
    std::string word;
    std::uint64_t count = 0;
    while (status >> word)
      if (word.ends_with("voluntary_ctxt_switches:") && status >> count) sum += count;
  }
  return sum;
}

void work_ms(int ms) {
  timespec begin{};
  timespec now{};
  clock_gettime(CLOCK_THREAD_CPUTIME_ID, &begin);
  do {
    clock_gettime(CLOCK_THREAD_CPUTIME_ID, &now);
  } while ((now.tv_sec - begin.tv_sec) * 1000 + (now.tv_nsec - begin.tv_nsec) / 1'000'000 < ms);
}

/// Switches of the source, the other stages and the consumer during 100 ms of work in one stage,
/// all of them waiting meanwhile.
std::uint64_t switches_beside_work(std::int64_t spin_ns) {
  const TwoCores two;
  RunnerConfig config = config_of(RunMode::kThreads, 2);
  config.spin_ns = spin_ns;
  FakeChain chain(config);
  std::uint64_t switches = 0;
  chain.stages[1].extra = [&] {
    work_ms(20);  // the others fall asleep
    const std::uint64_t before = switches_of_others();
    work_ms(100);
    switches = switches_of_others() - before;
  };
  EXPECT_TRUE(chain.runner.start().ok());
  std::thread consumer([&] {
    std::uint32_t handle = 0;
    while (chain.runner.pop_done(handle)) chain.take(handle);
  });
  EXPECT_TRUE(chain.offer(1));
  chain.runner.stop();
  consumer.join();
  return switches;
}

TEST(Waiting, ThoseWhoWaitDoNotRunBesideAStageAtWork) {
  EXPECT_LE(switches_beside_work(-1), 2U);
}

// The same measurement of a runner told to poll for a second shows what it would find. On a machine
// where others take the cores, pollers hardly run in any one measurement.
TEST(Waiting, PollingOnTwoCoresWouldBeSeen) {
  std::uint64_t most = 0;
  for (int i = 0; i < 20 && most <= 10; ++i)
    most = std::max<std::uint64_t>(most, switches_beside_work(1'000'000'000));
  EXPECT_GT(most, 10U);
}

}  // namespace
}  // namespace planecast::test
