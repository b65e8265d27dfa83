// The rings under relacy: every order of the product holds over 100,000 schedules, and none of them
// can be weakened without a schedule that shows why it is there.
#include <gtest/gtest.h>

#include "tests/core/ring/model/model_run.hpp"

namespace planecast::model {
namespace {

constexpr std::uint64_t kSchedules = 100'000;

void print(const Case& one, const Outcome& outcome) {
  std::printf("%-38s %-28s %8llu schedules %s\n", one.name.c_str(),
              one.weakened.empty() ? "as in the product" : one.weakened.c_str(),
              static_cast<unsigned long long>(outcome.schedules), outcome.fault.c_str());
}

TEST(RingModel, HoldsInEverySchedule) {
  for (const Case& one : sound_cases()) {
    const Outcome outcome = one.run(kSchedules);
    print(one, outcome);
    EXPECT_TRUE(outcome.holds) << one.name << ": " << outcome.fault;
    EXPECT_GE(outcome.schedules, kSchedules) << one.name;
  }
}

TEST(RingModel, NoOrderCanBeWeakened) {
  for (const Case& one : mutant_cases()) {
    const Outcome outcome = one.run(kSchedules);
    print(one, outcome);
    EXPECT_FALSE(outcome.holds) << one.name << " with " << one.weakened
                                << " holds as well: the product may ask for less";
  }
}

}  // namespace
}  // namespace planecast::model
