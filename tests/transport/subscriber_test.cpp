// Publisher to subscriber over memq://, and what the receiving side does with bytes of any kind.
#include "transport/subscriber.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <thread>
#include <vector>

#include "core/base/random.hpp"
#include "tests/transport/fake_packet.hpp"
#include "transport/doctor.hpp"
#include "transport/plain_subscriber.hpp"
#include "transport/publisher.hpp"

namespace planecast {
namespace {

using test::fake_packet;
using test::key_info;
using test::kSecond;
using test::slice_info;

std::shared_ptr<LcmLink> memory_link() {
  return LcmLink::open(parse_lcm_url("memq://").value(), true).value();
}

SubscriberConfig small_subscriber() {
  SubscriberConfig config;
  config.channel = "TEST";
  config.parse = test::parse_fake;
  config.assembly.max_slices = 16;
  config.assembly.max_frame_bytes = 8192;
  config.assembly.deadline_ns = 50'000'000;
  return config;
}

/// Waits until the subscriber has seen `messages`.
void settle(const Subscriber& subscriber, std::uint64_t messages) {
  for (int i = 0; i < 20'000 && subscriber.statistics().link.messages < messages; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
}

}  // namespace

TEST(Subscriber, FramesComeThroughWithKeyAndBytes) {
  const auto link = memory_link();
  auto subscriber = std::move(Subscriber::create(small_subscriber(), link).value());
  PublisherConfig config;
  config.channel = "TEST";
  auto publisher = std::move(Publisher::create(config, link).value());
  for (std::uint32_t number = 0; number < 200; ++number) {
    FrameBuffer* frame = publisher->claim();
    ASSERT_NE(frame, nullptr);
    if (number % 8 == 0) {
      ASSERT_EQ(frame->append(fake_packet(key_info(5, 2, number)), true), Status::kOk);
    }
    for (std::uint16_t i = 0; i < 6; ++i)
      ASSERT_EQ(frame->append(fake_packet(slice_info(5, 2, number, i, 6))), Status::kOk);
    ASSERT_EQ(publisher->publish(frame), Status::kOk);
    const FrameRef received = subscriber->wait(20 * kSecond);
    ASSERT_TRUE(received);
    EXPECT_EQ(received->frame, number);
    EXPECT_TRUE(received->complete());
    PacketInfo key;
    ASSERT_EQ(test::parse_fake(received->key(), key), Status::kOk);
    EXPECT_EQ(key.frame, number - number % 8);
    const auto bytes = received->slice(5);
    EXPECT_EQ(std::vector<std::uint8_t>(bytes.begin(), bytes.end()),
              fake_packet(slice_info(5, 2, number, 5, 6)));
  }
  const ReceiverStatistics counts = subscriber->statistics();
  EXPECT_EQ(counts.link.messages, 200U * 6 + 25);
  EXPECT_EQ(counts.link.bytes, publisher->statistics().bytes);
  EXPECT_EQ(counts.streams[0].frames_complete, 200U);
  EXPECT_EQ(counts.streams[0].frames_taken, 200U);
}

TEST(Subscriber, PartialFrameArrivesByItsDeadlineWithoutFurtherTraffic) {
  const auto link = memory_link();
  auto subscriber = std::move(Subscriber::create(small_subscriber(), link).value());
  std::vector<std::uint8_t> message(200);
  std::size_t size = 0;
  ASSERT_EQ(encode_envelope(fake_packet(slice_info(5, 2, 0, 0, 6)), message, size), Status::kOk);
  ASSERT_EQ(link->publish("TEST", std::span(message).first(size)), Status::kOk);
  const FrameRef frame = subscriber->wait(20 * kSecond);
  ASSERT_TRUE(frame);
  EXPECT_FALSE(frame->complete());
  EXPECT_GE(frame->ready_ns - frame->first_ns, 50'000'000);
}

TEST(Subscriber, EveryKindOfBadMessageIsCountedUnderItsName) {
  const auto link = memory_link();
  auto subscriber = std::move(Subscriber::create(small_subscriber(), link).value());
  const std::vector<std::uint8_t> packet = fake_packet(slice_info(5, 2, 0, 0, 6));
  std::vector<std::uint8_t> good(packet.size() + 10);
  std::size_t size = 0;
  ASSERT_EQ(encode_envelope(packet, good, size), Status::kOk);
  std::vector<std::vector<std::uint8_t>> messages;
  messages.push_back({});                                // bad_length
  messages.push_back({good.begin(), good.begin() + 9});  // bad_length
  messages.push_back({good.begin(), good.end() - 1});    // bad_length
  messages.push_back(good);
  messages.back().push_back(0);  // bad_length
  messages.push_back(good);
  messages.back()[0] ^= 1;  // bad_type: the envelope's
  messages.push_back(good);
  messages.back()[10] ^= 1;  // bad_type: the packet's
  messages.push_back(good);
  messages.back().back() ^= 1;  // bad_check
  messages.push_back(good);
  messages.back()[11] = 2;  // bad_packet
  messages.push_back({good.begin(), good.begin() + 10});
  messages.back()[8] = messages.back()[9] = 0;  // greeting
  messages.push_back(good);
  for (const auto& message : messages) ASSERT_EQ(link->publish("TEST", message), Status::kOk);
  settle(*subscriber, messages.size());
  const ReceiverStatistics counts = subscriber->statistics();
  EXPECT_EQ(counts.link.messages, messages.size());
  EXPECT_EQ(counts.link.bad_length, 4U);
  EXPECT_EQ(counts.link.bad_type, 2U);
  EXPECT_EQ(counts.link.bad_check, 1U);
  EXPECT_EQ(counts.link.bad_packet, 1U);
  EXPECT_EQ(counts.link.greetings, 1U);
  subscriber->stop();
  EXPECT_EQ(subscriber->statistics().streams[0].slices_received, 1U);
}

TEST(Subscriber, RandomBytesAreAllCountedAndNoneAccepted) {
  const auto link = memory_link();
  auto subscriber = std::move(Subscriber::create(small_subscriber(), link).value());
  Pcg32 random(11);
  constexpr std::uint64_t kMessages = 3000;
  for (std::uint64_t i = 0; i < kMessages; ++i) {
    std::vector<std::uint8_t> message(random.below(120));
    for (std::uint8_t& byte : message) byte = static_cast<std::uint8_t>(random.next());
    // Half of them get as far as the packet's own check.
    if (i % 2 == 0 && message.size() > 10)
      write_envelope_header(message.size() - 10, std::span<std::uint8_t, 10>(message.data(), 10));
    ASSERT_EQ(link->publish("TEST", message), Status::kOk);
  }
  settle(*subscriber, kMessages);
  const LinkStatistics link_counts = subscriber->statistics().link;
  EXPECT_EQ(link_counts.messages, kMessages);
  EXPECT_EQ(link_counts.bad_length + link_counts.bad_type + link_counts.bad_check +
                link_counts.bad_packet + link_counts.bad_version,
            kMessages);
  EXPECT_EQ(subscriber->statistics().stream_count, 0);
}

TEST(Subscriber, OnlyTheNamedChannelIsHeardEvenWithPatternCharacters) {
  const auto link = memory_link();
  SubscriberConfig config = small_subscriber();
  config.channel = "A.B+(c)";
  auto subscriber = std::move(Subscriber::create(config, link).value());
  const std::vector<std::uint8_t> message(20, 1);
  ASSERT_EQ(link->publish("AxB+(c)", message), Status::kOk);
  ASSERT_EQ(link->publish("A.BB(c)", message), Status::kOk);
  ASSERT_EQ(link->publish("A.B+(c)", message), Status::kOk);
  settle(*subscriber, 1);
  subscriber->stop();
  EXPECT_EQ(subscriber->statistics().link.messages, 1U);
}

TEST(Subscriber, StopsInAnyStateAndEndsAWait) {
  const auto link = memory_link();
  auto subscriber = std::move(Subscriber::create(small_subscriber(), link).value());
  std::thread stopper([&] {
    std::this_thread::sleep_for(std::chrono::milliseconds(20));
    subscriber->stop();
  });
  EXPECT_FALSE(subscriber->wait(60 * kSecond));
  stopper.join();
  subscriber->stop();
  EXPECT_FALSE(subscriber->take());
}

TEST(Subscriber, WrongUseIsRefusedWithAReason) {
  const auto link = memory_link();
  SubscriberConfig config = small_subscriber();
  config.parse = nullptr;
  EXPECT_FALSE(Subscriber::create(config, link).ok());
  config = small_subscriber();
  config.channel = "";
  const auto unnamed = Subscriber::create(config, link);
  ASSERT_FALSE(unnamed.ok());
  EXPECT_EQ(unnamed.error().status, Status::kUsage);
  auto first = std::move(Subscriber::create(small_subscriber(), link).value());
  const auto second = Subscriber::create(small_subscriber(), link);
  ASSERT_FALSE(second.ok());
  EXPECT_EQ(second.error().status, Status::kBadConfig);
}

TEST(Subscriber, UnknownKeysAreCountedOnTheirStream) {
  const auto link = memory_link();
  auto subscriber = std::move(Subscriber::create(small_subscriber(), link).value());
  std::vector<std::uint8_t> message(200);
  std::size_t size = 0;
  ASSERT_EQ(encode_envelope(fake_packet(slice_info(5, 2, 0, 0, 1)), message, size), Status::kOk);
  ASSERT_EQ(link->publish("TEST", std::span(message).first(size)), Status::kOk);
  ASSERT_TRUE(subscriber->wait(20 * kSecond));
  subscriber->count_unknown_keys(2, 3);
  subscriber->count_unknown_keys(77, 3);
  EXPECT_EQ(subscriber->statistics().streams[0].unknown_keys, 3U);
}

TEST(Doctor, NamesAMalformedUrlAndTheMend) {
  const std::vector<DoctorLine> lines = run_doctor("udpm://10.0.0.1:7667");
  ASSERT_EQ(lines.size(), 1U);
  EXPECT_EQ(lines[0].level, DoctorLevel::kFail);
  EXPECT_NE(lines[0].text.find("multicast"), std::string::npos);
  EXPECT_FALSE(lines[0].mend.empty());
  EXPECT_EQ(doctor_verdict(lines), Status::kNetwork);
}

TEST(Doctor, HasNothingToExamineInMemory) {
  const std::vector<DoctorLine> lines = run_doctor("memq://");
  EXPECT_EQ(doctor_verdict(lines), Status::kOk);
  EXPECT_EQ(lines.back().level, DoctorLevel::kWarn);
}

}  // namespace planecast
