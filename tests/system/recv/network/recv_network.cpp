// planecast-recv and planecastd as programs over LCM, in a network namespace of their own.
#include <gtest/gtest.h>

#include <atomic>
#include <chrono>
#include <fstream>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "apps/common/frame_source.hpp"
#include "core/io/depth_png.hpp"
#include "tests/system/planecastd/network/child.hpp"
#include "tests/system/recv/own_folder.hpp"
#include "transport/drake_point_cloud.hpp"
#include "transport/plain_subscriber.hpp"

namespace planecast {
namespace {

using test::Child;
using test::OwnFolder;
using Words = std::vector<std::string>;

constexpr int kRateHz = 10;
// A small sensor: sanitizers on a busy machine are slow.
constexpr const char* kCamera = "azure-nfov-binned";

/// Asks every 20 ms, for at most two minutes.
template <class Condition>
bool eventually(Condition condition) {
  for (int i = 0; i < 6'000; ++i) {
    if (condition()) return true;
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
  }
  return false;
}

/// A receiver that listens already, with its --status file.
struct Receiver {
  OwnFolder folder;
  std::string status = folder / "status";
  std::unique_ptr<Child> child;

  explicit Receiver(Words more = {}) {
    Words words = {PLANECAST_RECV, "--max-size", "320x288", "--camera",
                   kCamera,        "--status",   status};
    words.insert(words.end(), more.begin(), more.end());
    child = std::make_unique<Child>(words);
    EXPECT_TRUE(eventually([this] { return !lines("ready=1").empty(); })) << child->talk();
  }

  /// Lines of the status file that hold `part`.
  Words lines(const std::string& part) const {
    Words found;
    std::ifstream file(status);
    for (std::string line; std::getline(file, line);)
      if (line.find(part) != std::string::npos) found.push_back(line);
    return found;
  }
};

/// The value of NAME=VALUE in a line; "" where there is none.
std::string value(const std::string& line, const std::string& name) {
  const std::size_t at = (" " + line).find(" " + name + "=");
  if (at == std::string::npos) return {};
  const std::size_t begin = at + name.size() + 1;
  return line.substr(begin, line.find(' ', begin) - begin);
}

Words daemon_words(Words more) {
  Words words = {PLANECASTD, "sim:room:5",           "--camera", kCamera, "--wait",
                 "--rate",   std::to_string(kRateHz)};
  words.insert(words.end(), more.begin(), more.end());
  return words;
}

}  // namespace

TEST(Recv, TwoDaemonsAreReceivedSideBySide) {
  Receiver receiver({"--reference", "sim:room:5", "--rate", std::to_string(kRateHz), "--frames",
                     "20", "--timeout", "100"});
  Child left(daemon_words({"--repeat", "2"}));
  Child right(daemon_words({"--repeat", "2", "--stream", "1"}));
  EXPECT_EQ(receiver.child->wait(), 0) << receiver.child->talk() << left.talk() << right.talk();
  const Words totals = receiver.lines("final=1");
  ASSERT_EQ(totals.size(), 2U);
  for (std::size_t i = 0; i < totals.size(); ++i) {
    EXPECT_EQ(value(totals[i], "stream"), std::to_string(i));
    EXPECT_EQ(value(totals[i], "complete"), "10");
    EXPECT_EQ(value(totals[i], "checked"), "10");
    EXPECT_LE(std::stod(value(totals[i], "max_error_ratio")), 1.0);
    EXPECT_GT(std::stod(value(totals[i], "latency_p50_ms")), 0.0) << "one boot, one clock";
  }
}

TEST(Recv, RestartedDaemonIsJoinedWithinASecondOfItsStream) {
  const OwnFolder out;
  Receiver receiver({"--out", out.text(), "--format", "png"});
  const Words endless = daemon_words({"--repeat", "0"});
  auto daemon = std::make_unique<Child>(endless);
  ASSERT_TRUE(eventually([&] { return !out.names().empty(); })) << daemon->talk();
  daemon->signal(SIGKILL);
  ASSERT_EQ(daemon->wait(), 128 + SIGKILL);
  daemon = std::make_unique<Child>(endless);
  // Files of the second sender are named ".2-" and its frame number.
  const auto second = [&] {
    for (const std::string& name : out.names())
      if (name.find(".2-") != std::string::npos) return name;
    return std::string();
  };
  ASSERT_TRUE(eventually([&] { return !second().empty(); })) << daemon->talk();
  EXPECT_LE(std::stoi(second().substr(second().find(".2-") + 3)), kRateHz);
  receiver.child->signal(SIGTERM);
  EXPECT_EQ(receiver.child->wait(), 0) << receiver.child->talk();
  EXPECT_EQ(value(receiver.lines("final=1").at(0), "senders"), "2");
}

TEST(Recv, RestartedReceiverJoinsWithinASecondOfTheStream) {
  Child daemon(daemon_words({"--repeat", "0"}));
  {
    Receiver first;
    ASSERT_TRUE(eventually([&] { return !first.lines("frames=").empty(); })) << daemon.talk();
    first.child->signal(SIGKILL);
    ASSERT_EQ(first.child->wait(), 128 + SIGKILL);
  }
  Receiver second({"--frames", std::to_string(2 * kRateHz), "--timeout", "100"});
  EXPECT_EQ(second.child->wait(), 0) << second.child->talk() << daemon.talk();
  const std::string totals = second.lines("final=1").at(0);
  EXPECT_LE(std::stoi(value(totals, "joining")) + std::stoi(value(totals, "no_key")), kRateHz);
  EXPECT_GE(std::stoi(value(totals, "complete")), kRateHz / 2);
}

TEST(Recv, EveryFrameBecomesAFileOfTheSameDepth) {
  const OwnFolder out;
  Receiver receiver({"--out", out.text(), "--format", "png", "--frames", "5", "--timeout", "100"});
  Child daemon(daemon_words({"--tolerance", "0"}));
  ASSERT_EQ(receiver.child->wait(), 0) << receiver.child->talk() << daemon.talk();
  ASSERT_EQ(out.names().size(), 5U);
  CodecOptions options;
  options.camera = parse_camera(kCamera).value();
  options.rate_hz = kRateHz;  // how far the simulated camera moves from frame to frame
  auto source = std::move(open_source({"sim:room:5"}, options).value());
  SensorFrame frame;
  for (const std::string& name : out.names()) {
    ASSERT_TRUE(source->next(frame).value());
    EXPECT_EQ(name, "camera_optical-00000" + std::to_string(frame.number) + ".png");
    EXPECT_EQ(read_depth_png(out / name)->depth, frame.depth.depth) << name;
  }
}

TEST(Recv, PlainCloudsReachViewersInOneDatagram) {
  std::atomic<int> good{0}, bad{0};
  auto link = std::move(LcmLink::open(parse_lcm_url("").value(), true).value());
  auto viewer = PlainSubscriber::create(
      "DRAKE_POINT_CLOUD_front", link, [&](std::span<const std::uint8_t> message, std::int64_t) {
        DrakePointCloud cloud;
        const bool read = decode_drake_point_cloud(message, 10'000, cloud) == Status::kOk;
        ++(read && cloud.points() == kDrakeDatagramPoints && cloud.strictly_finite &&
                   cloud.frame_name == "camera_optical"
               ? good
               : bad);
      });
  ASSERT_TRUE(viewer.ok());
  Receiver receiver({"--publish-plain", "front", "--frames", "5", "--timeout", "100"});
  Child daemon(daemon_words({}));
  EXPECT_EQ(receiver.child->wait(), 0) << receiver.child->talk() << daemon.talk();
  EXPECT_TRUE(eventually([&] { return good > 0; }));
  EXPECT_EQ(bad, 0);
}

TEST(Recv, AnotherOriginalIsABoundExceeded) {
  Receiver receiver(
      {"--reference", "sim:room:5", "--seed", "2", "--frames", "5", "--timeout", "100"});
  Child daemon(daemon_words({}));
  EXPECT_EQ(receiver.child->wait(), 5) << receiver.child->talk() << daemon.talk();
}

TEST(Recv, SilenceEndsWithAHint) {
  Receiver receiver({"--timeout", "0.5"});
  EXPECT_EQ(receiver.child->wait(), 1);
  EXPECT_NE(receiver.child->talk().find("planecast doctor"), std::string::npos);
}

TEST(Recv, LargerFramesThanTheMemoryAreRefusedByName) {
  Receiver receiver({"--max-size", "160x120", "--frames", "3", "--timeout", "100"});
  Child daemon(daemon_words({}));
  EXPECT_EQ(receiver.child->wait(), 1);
  EXPECT_NE(receiver.child->talk().find("--max-size"), std::string::npos) << receiver.child->talk();
}

TEST(Recv, SignalEndsItCleanlyWithTheBalance) {
  Receiver receiver({"--stats"});
  Child daemon(daemon_words({"--repeat", "0"}));
  ASSERT_TRUE(eventually([&] { return !receiver.lines("frames=").empty(); })) << daemon.talk();
  receiver.child->signal(SIGINT);
  EXPECT_EQ(receiver.child->wait(), 0);
  EXPECT_NE(receiver.child->out().find("handed on ="), std::string::npos) << receiver.child->out();
  // Every frame handed on by the assembler is complete, partial, unreadable or replaced.
  const std::string totals = receiver.lines("final=1").at(0);
  EXPECT_GT(std::stoi(value(totals, "complete")), 0);
}

TEST(Recv, MistakesEndWithTheirExitCodes) {
  const auto ends = [](Words more) {
    Words words = {PLANECAST_RECV};
    words.insert(words.end(), more.begin(), more.end());
    Child child(words);
    return child.wait();
  };
  EXPECT_EQ(ends({"--help"}), 0);
  EXPECT_EQ(ends({"--formt", "ply"}), 2);
  EXPECT_EQ(ends({"--format", "tiff"}), 2);
  EXPECT_EQ(ends({"--streams", "17"}), 2);
  EXPECT_EQ(ends({"--full-cloud"}), 2);
  EXPECT_EQ(ends({"--lcm-url", "udpm://239.255.76.67"}), 2);
  EXPECT_EQ(ends({"--reference", "not-there.png"}), 3);
}

}  // namespace planecast
