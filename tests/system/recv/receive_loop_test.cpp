// The receiving thread over LCM inside this process: streams side by side, new senders, loss, heap.
#include "apps/recv/receive_loop.hpp"

#include <thread>

#include "apps/recv/recv_options.hpp"
#include "tests/support/heap_guard.hpp"
#include "tests/system/recv/small_stream.hpp"
#include "transport/publisher.hpp"

namespace planecast {
namespace {

using test::HeapGuard;
using test::SmallStream;
using test::wall_frame;

/// A receiver over memq:// and the publisher that feeds it.
struct Bench {
  std::shared_ptr<LcmLink> link = LcmLink::open(parse_lcm_url("memq://").value(), true).value();
  RecvOptions options;
  std::unique_ptr<Subscriber> subscriber;
  std::unique_ptr<Publisher> publisher;
  std::unique_ptr<SinkQueue> queue;
  std::unique_ptr<ReceiveLoop> loop;
  std::thread thread;

  explicit Bench(std::uint64_t frames, ImageSize max_size = {test::kWidth, test::kHeight},
                 bool guarded = false) {
    options.frames = frames;
    options.max_size = max_size;
    options.streams = 2;
    SubscriberConfig config = subscriber_for(options, {});
    config.assembly.deadline_ns = 50'000'000;
    subscriber = std::move(Subscriber::create(config, link).value());
    PublisherConfig out;
    out.pace_ns = 0;
    publisher = std::move(Publisher::create(out, link).value());
    queue = std::move(SinkQueue::create(2, test::kWidth * test::kHeight).value());
    FrameLimits limits{static_cast<std::uint16_t>(max_size.width),
                       static_cast<std::uint16_t>(max_size.height)};
    limits.max_points = limits.pixels();
    loop = std::move(
        ReceiveLoop::create({2, limits, frames, 0}, *subscriber, nullptr, queue.get()).value());
    thread = std::thread([this, guarded] {
      if (guarded) HeapGuard::arm_this_thread("receive");
      loop->run();
      if (guarded) HeapGuard::disarm_this_thread();
    });
  }
  ~Bench() {
    loop->stop();
    if (thread.joinable()) thread.join();
  }

  /// Publishes a frame, without slice `without`, and waits for its record.
  FrameRecord send(SmallStream& stream, std::uint64_t number, bool key, int without = -1) {
    const SensorFrame frame = wall_frame(number);
    const auto coded = stream.codec.encode(stream.setup, frame);
    FrameBuffer* buffer = publisher->claim();
    if (key) EXPECT_EQ(buffer->append(stream.codec.key_packet(frame), true), Status::kOk);
    for (std::size_t i = 0; i < coded->packets.size(); ++i)
      if (static_cast<int>(i) != without) EXPECT_EQ(buffer->append(coded->packets[i]), Status::kOk);
    EXPECT_EQ(publisher->publish(buffer), Status::kOk);
    FrameRecord record;
    for (int i = 0; i < 20'000 && !loop->records().try_pop(record); ++i)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    return record;
  }
};

}  // namespace

TEST(ReceiveLoop, TwoStreamsAreDecodedSideBySide) {
  Bench bench(0);
  SmallStream left("5mm", 4, 1), right("0", 9, 2);
  for (std::uint64_t number = 0; number < 3; ++number) {
    for (SmallStream* stream : {&left, &right}) {
      const FrameRecord record = bench.send(*stream, number, number == 0);
      EXPECT_EQ(record.end, FrameEnd::kComplete);
      EXPECT_EQ(record.stream, stream->setup.encoder.stream.stream);
      EXPECT_EQ(record.frame, number);
      EXPECT_GT(record.points, 18'000U);
    }
  }
}

TEST(ReceiveLoop, ANewSenderIsFollowedAtItsFirstKeyPacket) {
  Bench bench(0);
  SmallStream before("5mm", 0, 1), after("5mm", 0, 2);
  EXPECT_EQ(bench.send(before, 7, true).end, FrameEnd::kComplete);
  const FrameRecord keyless = bench.send(after, 0, false);
  EXPECT_EQ(keyless.end, FrameEnd::kNoKey);
  EXPECT_EQ(bench.subscriber->statistics().streams[0].unknown_keys, keyless.slices);
  EXPECT_EQ(bench.send(after, 1, true).end, FrameEnd::kComplete);
  EXPECT_EQ(bench.subscriber->statistics().streams[0].session_changes, 1U);
}

TEST(ReceiveLoop, AFrameThatLostASliceIsPartial) {
  Bench bench(0);
  SmallStream stream("0");
  const FrameRecord whole = bench.send(stream, 0, true);
  const FrameRecord partial = bench.send(stream, 1, false, 1);
  EXPECT_EQ(whole.end, FrameEnd::kComplete);
  ASSERT_GT(whole.slice_count, 2U);
  EXPECT_EQ(partial.end, FrameEnd::kPartial);
  EXPECT_EQ(partial.slices + 1U, partial.slice_count);
  EXPECT_LT(partial.points, whole.points);
  EXPECT_GT(partial.points, 0U);
}

TEST(ReceiveLoop, LargerFramesThanTheMemoryAreRefusedByTheirKey) {
  Bench bench(0, {64, 64});
  SmallStream stream("5mm");
  const FrameRecord record = bench.send(stream, 0, true);
  EXPECT_EQ(record.end, FrameEnd::kRefused);
  EXPECT_EQ(record.status, Status::kFrameTooLarge);
}

TEST(ReceiveLoop, EndsAfterTheFramesAskedForLostOnesIncluded) {
  Bench bench(4);
  SmallStream stream("5mm");
  (void)bench.send(stream, 0, true);
  (void)bench.send(stream, 1, false);
  EXPECT_FALSE(bench.loop->finished());
  (void)bench.send(stream, 3, false);  // frame 2 is lost
  bench.thread.join();
  EXPECT_TRUE(bench.loop->finished());
  while (const SinkFrame* frame = bench.queue->take()) bench.queue->release(frame);
}

TEST(ReceiveLoop, DecodingAndHandingOverTouchNoHeap) {
  PLANECAST_NEED_HEAP_GUARD();
  HeapGuard::reset();
  SmallStream stream("2sigma");
  {
    Bench bench(0, {test::kWidth, test::kHeight}, true);
    for (std::uint64_t number = 0; number < 100; ++number)
      ASSERT_EQ(bench.send(stream, number, number % 8 == 0).end, FrameEnd::kComplete);
  }
  EXPECT_EQ(HeapGuard::totals().sum(), 0U) << HeapGuard::first_offender();
}

}  // namespace planecast
