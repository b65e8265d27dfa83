// planecastd and planecast-recv as they are installed, over LCM, every thread that touches frames
// under the guard: no allocation, no mapping, no page fault, no wait for a mutex, no write, no
// sleep after start; and one of each, planted into the running program, is caught.
#include <gtest/gtest.h>

#include <csignal>
#include <set>

#include "tests/system/realtime/guarded.hpp"

namespace planecast {
namespace {

using test::Child;
using test::Guarded;
using test::GuardReport;
using test::kDaemonThreads;
using test::kReceiverThreads;
using test::number_after;
using test::operator+;
using test::ThreadCounts;

/// Frames that must come out of the daemon: a thousand, or what PLANECAST_REALTIME_FRAMES says.
long long frames_wanted() {
  const char* told = std::getenv("PLANECAST_REALTIME_FRAMES");
  return told == nullptr ? 1000 : std::atoll(told);
}

struct Stream {
  const char* name;
  std::vector<std::string> input;
};

const Stream kStreams[] = {
    {"Organised", {"sim:room:50", "--size", "160x120", "--tolerance", "2sigma"}},
    {"List", {"sim:scan:50", "--size", "64x48", "--tolerance", "10mm"}},
    {"ListSurfaces", {"sim:scan:50", "--size", "64x48", "--tolerance", "surfaces"}},
    {"ListPaper", {"sim:scan:50", "--size", "64x48", "--method", "paper"}},
};

// May block in the kernel's send and receive, or wait for their own clock; all others never.
const std::set<std::string> kMayBlock = {"source", "publisher", "subscriber"};

bool locked(const Child& child) {
  return child.talk().find("memory is not locked") == std::string::npos;
}

/// Every thread of the list ended and did nothing forbidden.
void expect_clean(const GuardReport& report, const std::string& threads, bool judge_faults) {
  std::istringstream names(threads);
  for (std::string name; std::getline(names, name, ',');) {
    ASSERT_EQ(report.threads.count(name), 1U) << name << " was never under the guard";
    const ThreadCounts& counts = report.threads.at(name);
    std::vector<std::string> forbidden = {"allocations", "frees", "maps"};
    if (kMayBlock.count(name) == 0)
      forbidden.insert(forbidden.end(), {"mutex_waits", "writes", "waits"});
    if (judge_faults) forbidden.insert(forbidden.end(), {"minor_faults", "major_faults"});
    for (const std::string& what : forbidden)
      EXPECT_EQ(counts.at(what), 0) << what << " on thread " << name << "\n" << report.offender;
  }
}

/// Waits until the receiver says that it listens.
void wait_until_listening(Child& receiver) {
  for (int ms = 0; ms < 20'000 && receiver.talk().find("listening") == std::string::npos; ++ms)
    ::usleep(1000);
  ::usleep(50'000);
}

/// Streams `frames` frames at `rate` and looks at every thread of both ends; `least` must come out.
void run_stream(const Stream& stream, long long frames, const std::string& rate, long long least) {
  const std::string repeat = std::to_string((frames + 49) / 50);
  const bool depth = std::string_view(stream.name) == "Organised";
  const std::string daemon_threads = kDaemonThreads + std::string(depth ? test::kPackHelper : "");
  Guarded receiver({PLANECAST_RECV, "--mlock", "--max-size", "320x240"}, kReceiverThreads);
  wait_until_listening(receiver.child());
  Guarded daemon(
      std::vector<std::string>{PLANECASTD, "--mlock", "--rate", rate, "--repeat", repeat} +
          stream.input,
      daemon_threads);
  ASSERT_EQ(daemon.child().wait(std::chrono::seconds(1200)), 0) << daemon.child().talk();
  ::usleep(300'000);
  receiver.child().signal(SIGTERM);
  ASSERT_EQ(receiver.child().wait(), 0) << receiver.child().talk();
  const std::string talk = daemon.child().talk();
  const long long out = number_after(talk, "frames out");
  EXPECT_GE(out, least) << talk;
  EXPECT_EQ(number_after(talk, "frames in"), out + number_after(talk, "frames dropped")) << talk;
  EXPECT_NE(talk.find("in = out + failed + dropped: holds"), std::string::npos) << talk;
  EXPECT_EQ(number_after(talk, "frames failed"), 0) << talk;
  expect_clean(daemon.report(), daemon_threads, locked(daemon.child()));
  expect_clean(receiver.report(), kReceiverThreads, locked(receiver.child()));
  if (!locked(daemon.child()) || !locked(receiver.child()))
    std::printf("page faults were not judged: mlockall is not permitted here\n");
  std::printf("%s at %s Hz: %lld of %lld frames out, %zu threads clean\n", stream.name,
              rate.c_str(), out, number_after(talk, "frames in"),
              daemon.report().threads.size() + receiver.report().threads.size());
}

class RealtimeStream : public testing::TestWithParam<Stream> {};
INSTANTIATE_TEST_SUITE_P(Kinds, RealtimeStream, testing::ValuesIn(kStreams),
                         [](const auto& param) { return std::string(param.param.name); });

TEST_P(RealtimeStream, AtRateNoThreadDoesAnythingForbidden) {
  const long long frames = frames_wanted();
  run_stream(GetParam(), frames, "100", frames / 2);
}

// Twenty times faster than the stages can work: most frames find no slot.
TEST_P(RealtimeStream, OverloadedNoThreadDoesAnythingForbidden) {
  const long long frames = frames_wanted();
  run_stream(GetParam(), 4 * frames, "2000", frames / 20);
}

/// The daemon alone with one planted fault on its thread "fit"; what the guard counted there.
ThreadCounts planted(const std::string& kind, std::string* talk = nullptr) {
  Guarded daemon({PLANECASTD, "sim:room:40", "--size", "96x72", "--rate", "100", "--mlock",
                  "--watchdog-ms", "100"},
                 kDaemonThreads, kind + ":fit");
  EXPECT_EQ(daemon.child().wait(), 0) << daemon.child().talk();
  if (talk != nullptr) *talk = daemon.child().talk();
  const GuardReport report = daemon.report();
  for (const auto& [name, counts] : report.threads) {
    if (name != "fit") EXPECT_EQ(counts.at("allocations") + counts.at("maps"), 0) << name;
  }
  return report.threads.count("fit") == 0 ? ThreadCounts{} : report.threads.at("fit");
}

TEST(RealtimePlanted, NothingPlantedNothingCaught) {
  for (const auto& [what, count] : planted("none"))
    if (what != "idle" && what.find("fault") == std::string::npos) EXPECT_EQ(count, 0) << what;
}

TEST(RealtimePlanted, AMallocInAStageIsCaught) {
  EXPECT_EQ(planted("malloc")["allocations"], 1);
}

TEST(RealtimePlanted, AMappingInAStageIsCaught) {
  EXPECT_EQ(planted("mmap")["maps"], 1);
}

TEST(RealtimePlanted, APageFaultInAStageIsCaught) {
  EXPECT_GE(planted("fault")["minor_faults"], 1);
}

TEST(RealtimePlanted, AMutexWaitInAStageIsCaught) {
  EXPECT_EQ(planted("mutex")["mutex_waits"], 1);
}

TEST(RealtimePlanted, AWriteInAStageIsCaught) {
  EXPECT_EQ(planted("write")["writes"], 1);
}

TEST(RealtimePlanted, ASleepInAStageIsCaughtAndItsDeadlineMissed) {
  std::string talk;
  EXPECT_EQ(planted("sleep", &talk)["waits"], 3);
  EXPECT_NE(talk.find("watchdog, 100 ms: late"), std::string::npos) << talk;
  const std::size_t late = talk.find(": late");
  EXPECT_NE(talk.substr(late, talk.find(';', late) - late).find("fit"), std::string::npos) << talk;
  EXPECT_NE(talk.find("watchdog: stage fit is silent"), std::string::npos) << talk;
}

/// Resident kilobytes of a process.
long long resident_kb(const Child& child) {
  std::ifstream file("/proc/" + std::to_string(child.pid()) + "/status");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("VmRSS:")) return std::atoll(line.c_str() + 6);
  }
  return -1;
}

// A minute, or PLANECAST_SOAK_SECONDS.
TEST(RealtimeSoak, ResidentMemoryOfBothEndsIsConstant) {
  const char* told = std::getenv("PLANECAST_SOAK_SECONDS");
  const int seconds = told == nullptr ? 60 : std::atoi(told);
  constexpr int kSettled = 5;
  Child receiver({PLANECAST_RECV, "--mlock", "--max-size", "320x240"});
  wait_until_listening(receiver);
  Child daemon(
      {PLANECASTD, "sim:room:50", "--size", "160x120", "--repeat", "0", "--rate", "30", "--mlock"});
  // A busy machine may take its time to render and start: measured from the first frames sent on.
  for (int ms = 0; ms < 60'000 && daemon.talk().find(" surfaces  raw ") == std::string::npos; ++ms)
    ::usleep(1000);
  long long first[2] = {}, least[2] = {}, most[2] = {};
  for (int second = 0; second < seconds; ++second) {
    ::sleep(1);
    const long long now[2] = {resident_kb(daemon), resident_kb(receiver)};
    for (int i = 0; i < 2; ++i) {
      ASSERT_GT(now[i], 0) << daemon.talk() << receiver.talk();
      if (second == kSettled) first[i] = least[i] = most[i] = now[i];
      least[i] = std::min(least[i], now[i]);
      most[i] = std::max(most[i], now[i]);
    }
  }
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.talk();
  receiver.signal(SIGTERM);
  EXPECT_EQ(receiver.wait(), 0) << receiver.talk();
  EXPECT_GE(number_after(daemon.talk(), "frames out"), seconds * 15) << daemon.talk();
  std::printf("%d s: planecastd %lld kB (%+lld), planecast-recv %lld kB (%+lld)\n", seconds,
              first[0], most[0] - first[0], first[1], most[1] - first[1]);
  EXPECT_EQ(most[0], first[0]) << "planecastd grew";
  EXPECT_EQ(most[1], first[1]) << "planecast-recv grew";
}

}  // namespace
}  // namespace planecast
