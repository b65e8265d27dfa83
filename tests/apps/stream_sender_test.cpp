// The sender between a real encoder and a real publisher, over LCM inside the process.
#include "apps/common/stream_sender.hpp"

#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "apps/common/packet_parse.hpp"
#include "transport/subscriber.hpp"

namespace planecast {
namespace {

constexpr std::int64_t kMs = 1'000'000;
constexpr std::uint16_t kWidth = 48, kHeight = 32;

EncoderConfig small_stream() {
  EncoderConfig config;
  Intrinsics intrinsics;
  intrinsics.fx = intrinsics.fy = 40;
  intrinsics.cx = kWidth / 2.0;
  intrinsics.cy = kHeight / 2.0;
  config.stream.camera = quantise(intrinsics, kWidth, kHeight).value();
  config.stream.noise.kind = NoiseModel::Kind::kTof;
  config.stream.noise.s_e9 = 5'000'000;
  config.stream.stream = 4;
  config.runner.mode = RunMode::kInline;
  config.runner.slots = 64;
  return config;
}

/// Encodes `frames` flat images with stamps `period_ns` apart and sends them.
struct SenderBench {
  explicit SenderBench(const PublisherConfig& publishing = {}) {
    encoder = std::move(Encoder::create(small_stream()).value());
    auto link = LcmLink::open(parse_lcm_url("memq://").value(), true).value();
    SubscriberConfig receiving;
    receiving.parse = parse_planecast_packet;
    receiving.assembly.frame_bits = kPacketFrameBits;
    receiving.assembly.output_frames = 64;
    receiving.assembly.deadline_ns = 10'000 * kMs;
    receiving.lcm_queue = 10'000;
    subscriber = std::move(Subscriber::create(receiving, link).value());
    publisher = std::move(Publisher::create(publishing, link).value());
  }

  void send(std::uint64_t frames, std::int64_t period_ns, std::uint16_t depth = 1'500) {
    StreamSender sender(*encoder, *publisher, {.key_every_frames = 7, .wait = true});
    ASSERT_TRUE(encoder->start().ok());
    const std::vector<std::uint16_t> image(kWidth * kHeight, depth);
    for (std::uint64_t i = 0; i < frames; ++i) {
      ASSERT_EQ(encoder->submit(DepthView{image, i, static_cast<std::int64_t>(i) * period_ns}),
                Status::kOk);
    }
    encoder->stop();
    sender.run();
    totals = sender.totals();
    first_failure = sender.first_failure();
    median_ns = sender.encode_median_ns(0);
    EXPECT_TRUE(publisher->flush(10'000 * kMs));
  }

  std::unique_ptr<Encoder> encoder;
  std::unique_ptr<Subscriber> subscriber;
  std::unique_ptr<Publisher> publisher;
  SenderTotals totals;
  Status first_failure = Status::kOk;
  std::int64_t median_ns = 0;
};

}  // namespace

TEST(StreamSender, EveryFrameArrivesWithItsKeyPacket) {
  SenderBench bench;
  bench.send(20, 33 * kMs);
  for (std::uint32_t i = 0; i < 20; ++i) {
    const FrameRef frame = bench.subscriber->wait(10'000 * kMs);
    ASSERT_TRUE(frame) << i;
    EXPECT_EQ(frame->frame, i);
    EXPECT_EQ(frame->stream, 4);
    EXPECT_TRUE(frame->complete());
    EXPECT_FALSE(frame->key().empty());
    EXPECT_EQ(frame->stamp_ns, i * 33 * kMs);
  }
  EXPECT_EQ(bench.totals.sent, 20U);
  EXPECT_EQ(bench.totals.readings, 20U * kWidth * kHeight);
  EXPECT_EQ(bench.totals.last_frame, 19U);
  EXPECT_EQ(bench.totals.bytes, bench.publisher->statistics().bytes);
  EXPECT_GT(bench.median_ns, 0);
}

TEST(StreamSender, KeyPacketsComeByFrameCount) {
  SenderBench bench;
  bench.send(22, 1 * kMs);
  EXPECT_EQ(bench.totals.keys, 4U);  // 0, 7, 14, 21
}

TEST(StreamSender, KeyPacketsComeByStampWhereTheSourceIsSlow) {
  SenderBench bench;
  bench.send(22, 100 * kMs);
  EXPECT_EQ(bench.totals.keys, 8U);  // every third: 300 ms
}

TEST(StreamSender, AnImageOfHolesIsAFrameAsWell) {
  SenderBench bench;
  bench.send(1, kMs, 0);
  EXPECT_EQ(bench.totals.sent, 1U);
  EXPECT_EQ(bench.totals.readings, 0U);
  const FrameRef frame = bench.subscriber->wait(10'000 * kMs);
  ASSERT_TRUE(frame);
  EXPECT_TRUE(frame->complete());
}

TEST(StreamSender, FrameThatFitsNoBufferIsCountedAndNotSent) {
  PublisherConfig publishing;
  publishing.max_packets = 1;  // the key packet alone
  SenderBench bench(publishing);
  bench.send(3, kMs);
  EXPECT_EQ(bench.totals.did_not_fit, 3U);  // each wants the key packet that never went out
  EXPECT_EQ(bench.totals.sent, 0U);
  EXPECT_EQ(bench.totals.keys, 0U);
  EXPECT_NE(bench.first_failure, Status::kOk);
  EXPECT_EQ(bench.publisher->statistics().frames_abandoned, 3U);
}

}  // namespace planecast
