// Over memq://. A gate that holds the sending thread stands for a network that takes nothing.
#include "transport/publisher.hpp"

#include <gtest/gtest.h>

#include <atomic>
#include <memory>
#include <mutex>
#include <thread>
#include <vector>

#include "tests/transport/fake_packet.hpp"
#include "transport/plain_subscriber.hpp"

namespace planecast {
namespace {

using test::fake_packet;
using test::key_info;
using test::kSecond;
using test::slice_info;

PublisherConfig small_publisher() {
  PublisherConfig config;
  config.channel = "TEST";
  config.frames = 4;
  config.max_packets = 8;
  config.max_frame_bytes = 4096;
  return config;
}

/// Holds the sending thread at its start until opened.
std::atomic<bool> gate_open{true};
void wait_at_gate(const char* /*name*/) {
  gate_open.wait(false);
}
void open_gate() {
  gate_open.store(true);
  gate_open.notify_all();
}

std::unique_ptr<Publisher> gated_publisher(const std::shared_ptr<LcmLink>& link) {
  gate_open.store(false);
  PublisherConfig config = small_publisher();
  config.on_thread_start = wait_at_gate;
  return std::move(Publisher::create(config, link).value());
}

/// A link whose every message is kept.
class Recorder {
 public:
  Recorder() : link_(LcmLink::open(parse_lcm_url("memq://").value(), true).value()) {
    subscriber_ = std::move(
        PlainSubscriber::create("TEST", link_,
                                [this](std::span<const std::uint8_t> message, std::int64_t) {
                                  const std::lock_guard lock(mutex_);
                                  messages_.emplace_back(message.begin(), message.end());
                                })
            .value());
  }

  const std::shared_ptr<LcmLink>& link() const { return link_; }

  /// The packets of everything received once `count` messages are here.
  std::vector<PacketInfo> packets(std::uint64_t count) {
    const std::int64_t limit_ns = 20 * kSecond;
    for (std::int64_t waited = 0; subscriber_->statistics().messages < count && waited < limit_ns;
         waited += 1'000'000)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    subscriber_->stop();
    const std::lock_guard lock(mutex_);
    std::vector<PacketInfo> infos;
    for (const auto& message : messages_) {
      std::span<const std::uint8_t> packet;
      PacketInfo info;
      EXPECT_EQ(decode_envelope(message, packet), Status::kOk);
      EXPECT_EQ(test::parse_fake(packet, info), Status::kOk);
      infos.push_back(info);
    }
    return infos;
  }

 private:
  std::shared_ptr<LcmLink> link_;
  std::mutex mutex_;
  std::vector<std::vector<std::uint8_t>> messages_;
  std::unique_ptr<PlainSubscriber> subscriber_;
};

void publish_frame(Publisher& publisher, std::uint32_t number, std::uint16_t count,
                   bool key = false) {
  FrameBuffer* frame = publisher.claim();
  ASSERT_NE(frame, nullptr);
  if (key) {
    ASSERT_EQ(frame->append(fake_packet(key_info(1, 1, number)), true), Status::kOk);
  }
  for (std::uint16_t i = 0; i < count; ++i)
    ASSERT_EQ(frame->append(fake_packet(slice_info(1, 1, number, i, count))), Status::kOk);
  ASSERT_EQ(publisher.publish(frame), Status::kOk);
}

}  // namespace

TEST(Publisher, SendsEveryPacketOfEveryFrameInOrder) {
  Recorder recorder;
  auto publisher = std::move(Publisher::create(small_publisher(), recorder.link()).value());
  std::uint64_t bytes = 0;
  for (std::uint32_t number = 0; number < 50; ++number) {
    publish_frame(*publisher, number, 5, number == 0);
    ASSERT_TRUE(publisher->flush(20 * kSecond));
    for (std::uint16_t i = 0; i < 5; ++i)
      bytes += fake_packet(slice_info(1, 1, number, i, 5)).size() + kEnvelopeOverheadBytes;
  }
  bytes += fake_packet(key_info(1, 1, 0)).size() + kEnvelopeOverheadBytes;
  const std::vector<PacketInfo> packets = recorder.packets(251);
  ASSERT_EQ(packets.size(), 251U);
  EXPECT_TRUE(packets[0].key);
  for (std::size_t i = 1; i < packets.size(); ++i) {
    EXPECT_EQ(packets[i].frame, (i - 1) / 5);
    EXPECT_EQ(packets[i].slice, (i - 1) % 5);
  }
  const PublisherStatistics counts = publisher->statistics();
  EXPECT_EQ(counts.frames_published, 50U);
  EXPECT_EQ(counts.frames_sent, 50U);
  EXPECT_EQ(counts.packets, 251U);
  EXPECT_EQ(counts.bytes, bytes);
  EXPECT_EQ(counts.frames_dropped_oldest + counts.publish_errors + counts.frames_queued, 0U);
}

TEST(Publisher, ANetworkThatStallsLosesTheOldestFramesWhole) {
  Recorder recorder;
  auto publisher = gated_publisher(recorder.link());
  for (std::uint32_t number = 0; number < 30; ++number) publish_frame(*publisher, number, 3);
  EXPECT_EQ(publisher->statistics().frames_dropped_oldest, 26U);
  EXPECT_EQ(publisher->statistics().frames_queued, 4U);
  open_gate();
  ASSERT_TRUE(publisher->flush(60 * kSecond));
  EXPECT_EQ(publisher->statistics().frames_sent, 4U);
  const std::vector<PacketInfo> packets = recorder.packets(12);
  ASSERT_EQ(packets.size(), 12U);
  for (std::size_t i = 0; i < packets.size(); ++i) {
    EXPECT_EQ(packets[i].frame, 26 + i / 3);
    EXPECT_EQ(packets[i].slice, i % 3);
  }
}

TEST(Publisher, FramesAreNeverMixedWhenTheSourceIsFasterThanTheSender) {
  Recorder recorder;
  auto publisher = std::move(Publisher::create(small_publisher(), recorder.link()).value());
  constexpr std::uint32_t kFrames = 3000;
  for (std::uint32_t number = 0; number < kFrames; ++number) publish_frame(*publisher, number, 3);
  ASSERT_TRUE(publisher->flush(60 * kSecond));
  const PublisherStatistics counts = publisher->statistics();
  EXPECT_EQ(counts.frames_published, kFrames);
  EXPECT_EQ(counts.frames_sent + counts.frames_dropped_oldest, kFrames);
  const std::vector<PacketInfo> packets = recorder.packets(counts.frames_sent * 3);
  ASSERT_EQ(packets.size(), counts.frames_sent * 3);
  for (std::size_t i = 0; i < packets.size(); ++i) {
    EXPECT_EQ(packets[i].slice, i % 3);
    EXPECT_EQ(packets[i].frame, packets[i - i % 3].frame);
    if (i >= 3 && i % 3 == 0) {
      EXPECT_GT(packets[i].frame, packets[i - 1].frame);
    }
  }
  EXPECT_EQ(packets.back().frame, kFrames - 1);
}

TEST(Publisher, APacedFrameIsSentWhole) {
  Recorder recorder;
  PublisherConfig config = small_publisher();
  config.burst_packets = 2;
  config.pace_above_packets = 3;
  config.pace_ns = 1'000'000;
  auto publisher = std::move(Publisher::create(config, recorder.link()).value());
  publish_frame(*publisher, 0, 7);
  ASSERT_TRUE(publisher->flush(60 * kSecond));
  EXPECT_EQ(recorder.packets(7).size(), 7U);
  EXPECT_EQ(publisher->statistics().frames_sent, 1U);
}

TEST(Publisher, AKeyPacketDroppedUnsentIsAskedForAgain) {
  Recorder recorder;
  auto publisher = gated_publisher(recorder.link());
  publish_frame(*publisher, 0, 2, true);
  for (std::uint32_t number = 1; number < 4; ++number) publish_frame(*publisher, number, 3);
  FrameBuffer* frame = publisher->claim();  // overwrites frame 0
  ASSERT_NE(frame, nullptr);
  EXPECT_TRUE(frame->key_wanted());
  publisher->abandon(frame);
  publish_frame(*publisher, 5, 3);
  frame = publisher->claim();
  EXPECT_TRUE(frame->key_wanted());  // still not sent
  ASSERT_EQ(frame->append(fake_packet(key_info(1, 1, 6)), true), Status::kOk);
  ASSERT_EQ(publisher->publish(frame), Status::kOk);
  frame = publisher->claim();
  EXPECT_FALSE(frame->key_wanted());
  publisher->abandon(frame);
  open_gate();
}

TEST(Publisher, StopDropsWhatIsQueuedAndCountsIt) {
  Recorder recorder;
  PublisherConfig config = small_publisher();
  config.burst_packets = 1;
  config.pace_above_packets = 0;
  config.pace_ns = 100'000'000;  // 2.8 s for what is queued
  auto publisher = std::move(Publisher::create(config, recorder.link()).value());
  for (std::uint32_t number = 0; number < 4; ++number) publish_frame(*publisher, number, 7);
  publisher->stop();
  publisher->stop();
  EXPECT_EQ(publisher->claim(), nullptr);
  const PublisherStatistics counts = publisher->statistics();
  EXPECT_EQ(counts.frames_queued, 0U);
  EXPECT_EQ(counts.frames_sent + counts.frames_failed + counts.frames_dropped_oldest +
                counts.frames_dropped_at_stop,
            4U);
  EXPECT_GT(counts.frames_dropped_at_stop, 0U);
}

TEST(Publisher, PacketsMayBeWrittenInPlace) {
  Recorder recorder;
  auto publisher = std::move(Publisher::create(small_publisher(), recorder.link()).value());
  FrameBuffer* frame = publisher->claim();
  const std::vector<std::uint8_t> packet = fake_packet(slice_info(1, 1, 3, 0, 1));
  const std::span<std::uint8_t> space = frame->space();
  EXPECT_EQ(space.size(), 1190U);
  std::copy(packet.begin(), packet.end(), space.begin());
  EXPECT_EQ(frame->commit(0), Status::kWrongSize);
  EXPECT_EQ(frame->commit(1191), Status::kWrongSize);
  EXPECT_EQ(frame->commit(packet.size()), Status::kOk);
  EXPECT_EQ(frame->bytes(), packet.size() + 10);
  ASSERT_EQ(publisher->publish(frame), Status::kOk);
  const std::vector<PacketInfo> packets = recorder.packets(1);
  ASSERT_EQ(packets.size(), 1U);
  EXPECT_EQ(packets[0].frame, 3U);
}

TEST(Publisher, AFullFrameSaysSo) {
  Recorder recorder;
  auto publisher = std::move(Publisher::create(small_publisher(), recorder.link()).value());
  FrameBuffer* frame = publisher->claim();
  const std::vector<std::uint8_t> large(1190, 1);
  EXPECT_EQ(frame->append(std::vector<std::uint8_t>(1191, 1)), Status::kWrongSize);
  for (int i = 0; i < 3; ++i) EXPECT_EQ(frame->append(large), Status::kOk);
  EXPECT_EQ(frame->append(large), Status::kTooLarge);
  EXPECT_EQ(frame->append(std::vector<std::uint8_t>(486, 1)), Status::kOk);
  EXPECT_EQ(frame->bytes(), 4096U);
  EXPECT_TRUE(frame->space().empty());
  publisher->abandon(frame);

  frame = publisher->claim();
  for (int i = 0; i < 8; ++i)
    EXPECT_EQ(frame->append(std::vector<std::uint8_t>(5, 1)), Status::kOk);
  EXPECT_EQ(frame->append(std::vector<std::uint8_t>(5, 1)), Status::kTooLarge);
  publisher->abandon(frame);
  EXPECT_EQ(publisher->statistics().frames_abandoned, 2U);
  EXPECT_EQ(publisher->statistics().frames_published, 0U);
}

TEST(Publisher, OnlyOneFrameIsClaimedAtATime) {
  Recorder recorder;
  auto publisher = std::move(Publisher::create(small_publisher(), recorder.link()).value());
  FrameBuffer* frame = publisher->claim();
  EXPECT_EQ(publisher->claim(), nullptr);
  EXPECT_EQ(publisher->publish(nullptr), Status::kBadConfig);
  EXPECT_EQ(publisher->publish(frame), Status::kWrongSize);  // empty: abandoned
  EXPECT_EQ(publisher->publish(frame), Status::kBadConfig);
  EXPECT_NE(publisher->claim(), nullptr);
}

TEST(Publisher, MemoryIsExactlyWhatWasTold) {
  Recorder recorder;
  const PublisherConfig config = small_publisher();
  Result<Arena> arena = Arena::map(Publisher::memory_bytes(config));
  ASSERT_TRUE(arena.ok());
  EXPECT_TRUE(Publisher::create(config, recorder.link(), &arena.value()).ok());
  EXPECT_EQ(arena->bytes_used(), Publisher::memory_bytes(config));
  Arena none;
  const auto refused = Publisher::create(config, recorder.link(), &none);
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().status, Status::kOutOfArena);
}

TEST(Publisher, ImpossibleConfigurationsAreRefused) {
  Recorder recorder;
  const auto status = [&recorder](auto change) {
    PublisherConfig config = small_publisher();
    change(config);
    const auto result = Publisher::create(config, recorder.link());
    return result.ok() ? Status::kOk : result.error().status;
  };
  EXPECT_EQ(status([](PublisherConfig& c) { c.frames = 2; }), Status::kBadConfig);
  EXPECT_EQ(status([](PublisherConfig& c) { c.max_packets = 0; }), Status::kBadConfig);
  EXPECT_EQ(status([](PublisherConfig& c) { c.message_bytes = 10; }), Status::kBadConfig);
  EXPECT_EQ(status([](PublisherConfig& c) { c.message_bytes = 40'000; }), Status::kBadConfig);
  EXPECT_EQ(status([](PublisherConfig& c) { c.max_frame_bytes = 1199; }), Status::kBadConfig);
  EXPECT_EQ(status([](PublisherConfig& c) { c.burst_packets = 0; }), Status::kBadConfig);
  EXPECT_EQ(status([](PublisherConfig& c) { c.channel = "two words"; }), Status::kUsage);
  EXPECT_EQ(status([](PublisherConfig& c) { c.channel = std::string(64, 'x'); }), Status::kUsage);
  EXPECT_EQ(status([](PublisherConfig&) {}), Status::kOk);
}

}  // namespace planecast
