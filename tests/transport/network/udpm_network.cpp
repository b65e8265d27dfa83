// LCM over real UDP multicast on the loopback of a private namespace (tests/support/netns.sh).
// Frames go in lockstep where a test counts losses, so that a busy machine cannot lose any.
#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "tests/transport/fake_packet.hpp"
#include "tests/transport/network/malloc_count.hpp"
#include "transport/doctor.hpp"
#include "transport/drake_point_cloud.hpp"
#include "transport/plain_subscriber.hpp"
#include "transport/publisher.hpp"
#include "transport/subscriber.hpp"

namespace planecast {
namespace {

using test::fake_packet;
using test::key_info;
using test::kSecond;
using test::slice_info;

constexpr std::uint16_t kSlices = 60;

/// While positive, the receiving thread is held up in its callback.
std::atomic<int> stall_ms{0};

Status parse_or_stall(std::span<const std::uint8_t> packet, PacketInfo& out) noexcept {
  const int ms = stall_ms.exchange(0);
  if (ms > 0) std::this_thread::sleep_for(std::chrono::milliseconds(ms));
  return test::parse_fake(packet, out);
}

std::shared_ptr<LcmLink> open_link(bool for_receiving) {
  return LcmLink::open(parse_lcm_url("").value(), for_receiving).value();
}

std::unique_ptr<Publisher> open_publisher(std::uint32_t pace_ns = 60'000) {
  PublisherConfig config;
  config.pace_ns = pace_ns;
  return std::move(Publisher::create(config, open_link(false)).value());
}

// In lockstep only loss would make a frame partial, so the deadline may be long.
std::unique_ptr<Subscriber> open_subscriber(std::int64_t deadline_ns = 5 * kSecond) {
  SubscriberConfig config;
  config.parse = parse_or_stall;
  config.assembly.deadline_ns = deadline_ns;
  return std::move(Subscriber::create(config, open_link(true)).value());
}

/// One frame of full-size packets; made before anything counts allocations.
std::vector<std::vector<std::uint8_t>> make_frame(std::uint32_t session, std::uint16_t stream,
                                                  std::uint32_t number, std::uint16_t slices) {
  std::vector<std::vector<std::uint8_t>> packets;
  packets.push_back(fake_packet(key_info(session, stream, number)));
  for (std::uint16_t i = 0; i < slices; ++i)
    packets.push_back(fake_packet(slice_info(session, stream, number, i, slices), 0, 1190 - 28));
  return packets;
}

void send(Publisher& publisher, const std::vector<std::vector<std::uint8_t>>& packets) {
  FrameBuffer* frame = publisher.claim();
  ASSERT_NE(frame, nullptr);
  for (const auto& packet : packets)
    ASSERT_EQ(frame->append(packet, &packet == &packets.front()), Status::kOk);
  ASSERT_EQ(publisher.publish(frame), Status::kOk);
}

class RawSender {
 public:
  RawSender() : fd_(::socket(AF_INET, SOCK_DGRAM, 0)) {
    const unsigned char ttl = 0;
    ::setsockopt(fd_, IPPROTO_IP, IP_MULTICAST_TTL, &ttl, sizeof ttl);
  }
  ~RawSender() { ::close(fd_); }
  void send(const std::string& bytes) const {
    sockaddr_in to{};
    to.sin_family = AF_INET;
    to.sin_port = htons(7667);
    ::inet_pton(AF_INET, "239.255.76.67", &to.sin_addr);
    EXPECT_EQ(
        ::sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to),
        static_cast<ssize_t>(bytes.size()));
  }

 private:
  int fd_;
};

const DoctorLine* find_line(const std::vector<DoctorLine>& lines, std::string_view subject) {
  for (const DoctorLine& line : lines)
    if (line.subject == subject) return &line;
  return nullptr;
}

}  // namespace

TEST(Udpm, FramesArriveWholeAndInOrder) {
  auto subscriber = open_subscriber();
  auto publisher = open_publisher();
  constexpr std::uint32_t kFrames = 100;
  for (std::uint32_t number = 0; number < kFrames; ++number) {
    send(*publisher, make_frame(9, 1, number, kSlices));
    const FrameRef frame = subscriber->wait(10 * kSecond);
    ASSERT_TRUE(frame) << number;
    EXPECT_EQ(frame->frame, number);
    EXPECT_TRUE(frame->complete());
    EXPECT_FALSE(frame->key().empty());
  }
  EXPECT_TRUE(publisher->flush(kSecond));
  EXPECT_EQ(publisher->statistics().publish_errors, 0U);
  EXPECT_EQ(subscriber->statistics().streams[0].slices_received, kFrames * kSlices);
}

TEST(Udpm, NothingAllocatesAfterStart) {
  if (!test::malloc_is_counted()) GTEST_SKIP() << "a sanitizer owns malloc in this build";
  const std::uint64_t planted = test::malloc_count();
  void* volatile block = std::malloc(10);  // NOLINT: the counter must see a planted one
  int* volatile number_block = new int(1);
  std::free(block);  // NOLINT
  delete number_block;
  ASSERT_EQ(test::malloc_count(), planted + 2);

  constexpr std::uint32_t kFrames = 400;
  std::vector<std::vector<std::vector<std::uint8_t>>> frames;
  for (std::uint32_t number = 0; number < kFrames; ++number)
    frames.push_back(make_frame(9, 1, number, kSlices));
  auto subscriber = open_subscriber(100'000'000);
  auto publisher = open_publisher(0);
  const std::uint64_t before = test::malloc_count();
  for (std::uint32_t number = 0; number < kFrames; ++number) {
    // Now and then the receiving thread is held up until liblcm's queue is full and drops.
    const bool stalled = number % 40 == 39;
    if (stalled) stall_ms.store(30);
    send(*publisher, frames[number]);
    if (stalled) {
      ASSERT_TRUE(publisher->flush(10 * kSecond));
      continue;
    }
    while (const FrameRef frame = subscriber->wait(10 * kSecond)) {
      if (frame->frame == number) break;
    }
  }
  const std::uint64_t allocations = test::malloc_count() - before;
  EXPECT_EQ(allocations, 0U);
  EXPECT_GT(subscriber->statistics().streams[0].frames_complete, kFrames / 2);
}

TEST(Udpm, SurvivesHostileDatagrams) {
  auto subscriber = open_subscriber();
  const RawSender raw;
  const std::string head("LC02\0\0\0\1", 8);
  const std::uint64_t before = subscriber->statistics().link.messages;
  raw.send(head + "PLANECAST");                     // no NUL after the channel
  raw.send(head + std::string("PLANECAST\0", 10));  // no payload
  raw.send(head + std::string("PLANECAST\0", 10) + std::string(9, 'x'));
  raw.send(head + std::string("PLANECAST\0", 10) + std::string(20'000, 'x'));
  raw.send("LC02");
  raw.send(std::string("LC99\0\0\0\1PLANECAST\0", 18));
  raw.send(head + std::string(300, 'c'));  // a channel name without end
  auto publisher = open_publisher();
  send(*publisher, make_frame(9, 1, 0, 4));
  const FrameRef frame = subscriber->wait(10 * kSecond);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->complete());
  const LinkStatistics counts = subscriber->statistics().link;
  EXPECT_GE(counts.messages, before + 3 + 5);
  EXPECT_GE(counts.bad_length, 2U);
  EXPECT_GE(counts.bad_type, 1U);
}

TEST(Udpm, FollowsARestartedSenderAtOnce) {
  auto subscriber = open_subscriber();
  for (std::uint32_t session = 1; session <= 3; ++session) {
    auto publisher = open_publisher();
    for (std::uint32_t number = 0; number < 3; ++number) {
      send(*publisher, make_frame(session, 1, number, 5));
      const FrameRef frame = subscriber->wait(10 * kSecond);
      ASSERT_TRUE(frame);
      EXPECT_EQ(frame->session, session);
      EXPECT_EQ(frame->frame, number);
      EXPECT_TRUE(frame->complete());
    }
  }
  EXPECT_EQ(subscriber->statistics().streams[0].session_changes, 2U);
}

TEST(Udpm, JoinsAStreamThatIsAlreadyRunningAndNeverSilent) {
  std::atomic<bool> stop{false};
  std::thread sender([&stop] {
    auto publisher = open_publisher();
    for (std::uint32_t number = 0; !stop.load(); ++number) {
      send(*publisher, make_frame(4, 1, number, 5));
      std::this_thread::sleep_for(std::chrono::milliseconds(3));
    }
  });
  std::this_thread::sleep_for(std::chrono::milliseconds(50));
  auto subscriber = open_subscriber();
  const FrameRef frame = subscriber->wait(10 * kSecond);
  EXPECT_TRUE(frame);
  stop.store(true);
  sender.join();
}

TEST(Udpm, TwoSendersSideBySide) {
  auto subscriber = open_subscriber();
  auto first = open_publisher();
  auto second = open_publisher();
  for (std::uint32_t number = 0; number < 30; ++number) {
    send(*first, make_frame(1, 10, number, 20));
    send(*second, make_frame(2, 20, 1000 + number, 20));
    for (int i = 0; i < 2; ++i) {
      const FrameRef frame = subscriber->wait(10 * kSecond);
      ASSERT_TRUE(frame);
      EXPECT_TRUE(frame->complete());
      EXPECT_EQ(frame->frame, frame->stream == 10 ? number : 1000 + number);
    }
  }
  EXPECT_EQ(subscriber->statistics().stream_count, 2);
}

TEST(Udpm, CloudsReachAPlainSubscriber) {
  std::atomic<std::size_t> points{0};
  auto subscriber =
      std::move(PlainSubscriber::create(
                    "DRAKE_POINT_CLOUD_test", open_link(true),
                    [&points](std::span<const std::uint8_t> message, std::int64_t) {
                      DrakePointCloud cloud;
                      if (decode_drake_point_cloud(message, 100'000, cloud) == Status::kOk)
                        points.store(cloud.points());
                    })
                    .value());
  const std::vector<float> xyz(3 * 20'000, 0.5F);
  // One datagram, then one that liblcm fragments.
  for (const std::size_t limit : {kDrakeDatagramPoints, std::size_t{20'000}}) {
    auto publisher = std::move(
        DrakePublisher::create("DRAKE_POINT_CLOUD_test", "world", limit, open_link(false)).value());
    points.store(0);
    for (int i = 0; i < 200 && points.load() == 0; ++i) {
      ASSERT_EQ(publisher->publish(7, xyz), Status::kOk);
      std::this_thread::sleep_for(std::chrono::milliseconds(20));
    }
    EXPECT_EQ(points.load(), limit);
  }
}

TEST(Udpm, DoctorApprovesAHostThatWorks) {
  const std::vector<DoctorLine> lines = run_doctor(kDefaultLcmUrl);
  EXPECT_EQ(doctor_verdict(lines), Status::kOk);
  for (const std::string_view subject : {"multicast route", "round trip", "datagram size"}) {
    const DoctorLine* line = find_line(lines, subject);
    ASSERT_NE(line, nullptr) << subject;
    EXPECT_EQ(line->level, DoctorLevel::kOk) << line->text;
  }
  for (const DoctorLine& line : lines)
    EXPECT_EQ(line.mend.empty(), line.level == DoctorLevel::kOk) << line.subject;
}

TEST(Udpm, MissingRouteIsNamedWithItsMend) {
  ASSERT_EQ(std::system("ip route del 224.0.0.0/4 dev lo"), 0);
  const auto link = LcmLink::open(parse_lcm_url("").value(), true);
  ASSERT_FALSE(link.ok());
  EXPECT_EQ(link.error().status, Status::kNetwork);
  EXPECT_NE(link.error().message.find("ip route add 224.0.0.0/4 dev lo"), std::string::npos);
  EXPECT_NE(link.error().message.find("ip link set lo up multicast on"), std::string::npos);
  const std::vector<DoctorLine> lines = run_doctor("");
  EXPECT_EQ(doctor_verdict(lines), Status::kNetwork);
  const DoctorLine* line = find_line(lines, "multicast route");
  ASSERT_NE(line, nullptr);
  EXPECT_EQ(line->mend, multicast_route_mend());
}

}  // namespace planecast

int main(int argc, char** argv) {
  const char* inside = std::getenv("PLANECAST_NETNS");
  if (inside == nullptr || std::strcmp(inside, "1") != 0) {
    std::fprintf(stderr,
                 "skipped: run this by tests/support/netns.sh, in a namespace of its own\n");
    return 77;
  }
  ::unsetenv("LCM_DEFAULT_URL");
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
