// The whole stream in one process: source, four stages, publisher, LCM over the loopback,
// subscriber, assembler, decoder. After start no thread of ours touches the heap, and those of the
// pipeline block in nothing but the futex wait. Publisher and subscriber may block in the kernel.
#include <gtest/gtest.h>

#include <array>
#include <atomic>
#include <chrono>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "apps/common/packet_parse.hpp"
#include "tests/core/pipeline/codec_bench.hpp"
#include "tests/support/heap_guard.hpp"
#include "transport/publisher.hpp"
#include "transport/subscriber.hpp"

namespace planecast {
namespace {

using namespace test;

constexpr std::int64_t kSecond = 1'000'000'000;
// Every point is looked at here; tests/system/realtime runs the long streams, in the real programs.
constexpr std::uint64_t kFrames = kSanitized ? 30 : 200;

// Blocking calls of the pipeline's threads alone: what the guard counts for the process holds the
// publisher's and the subscriber's too, which are allowed.
std::atomic<std::uint64_t> pipeline_blocks{0};
std::atomic<bool> plant_in_publisher{false};
void* volatile sink = nullptr;

void disarm_pipeline(const char* name) {
  pipeline_blocks.fetch_add(HeapGuard::this_thread().blocks());
  HeapGuard::disarm_this_thread(name);
}

std::atomic<int> armed{0};

void arm(const char* name) {
  HeapGuard::arm_this_thread(name);
  armed.fetch_add(1);
}

void arm_publisher(const char* name) {
  arm(name);
  if (plant_in_publisher.load()) sink = std::malloc(8);
}

/// What the decoding thread saw.
struct Received {
  std::uint64_t whole = 0, partial = 0, failed = 0, points = 0;
  bool ordered = true;
  std::uint32_t last = 0;
};

std::shared_ptr<LcmLink> open_link(bool for_receiving) {
  return LcmLink::open(parse_lcm_url("").value(), for_receiving).value();
}

/// Every part of the stream, made before anything counts.
class Stream {
 public:
  Stream(const SimStream& sim, const StreamCase& c) : source_(sim, c) {
    EncoderConfig config = encoder_config(sim, c, RunMode::kThreads, 5);
    config.runner.on_thread_start = arm;
    config.runner.on_thread_stop = disarm_pipeline;
    encoder_ = make_encoder(config, false);
    decoder_ = make_decoder(decoder_config(config.stream));
    SubscriberConfig receive;
    receive.parse = parse_planecast_packet;
    receive.assembly.frame_bits = kPacketFrameBits;
    receive.assembly.deadline_ns = 10 * kSecond;  // in lockstep only loss makes a frame partial
    receive.assembly.output_frames = 4;
    receive.on_thread_start = arm;
    subscriber_ = std::move(Subscriber::create(receive, open_link(true)).value());
    PublisherConfig send;
    send.on_thread_start = arm_publisher;
    publisher_ = std::move(Publisher::create(send, open_link(false)).value());
  }

  /// Sends `count` frames, at most two of them on their way at a time so that no buffer on the way
  /// can overflow, and returns what arrived.
  Received run(std::uint64_t count) {
    pipeline_blocks.store(0);
    HeapGuard::reset();
    EXPECT_TRUE(encoder_->start().ok());
    std::thread sender([this] { send_all(); });
    std::thread receiver([this] { receive_all(); });
    for (std::uint64_t i = 0; i < count; ++i) {
      EXPECT_EQ(source_.submit(*encoder_, i, true), Status::kOk);
      wait_until_received(i > 1 ? i - 1 : 0);
    }
    wait_until_received(count);
    encoder_->stop();
    sender.join();
    done_.store(true);
    subscriber_->interrupt();
    receiver.join();
    return received_;
  }

  std::uint64_t kept() const { return kept_; }

 private:
  void send_all() {
    arm("sender");
    std::array<std::uint8_t, kPacketHeaderBytes + kMaxKeyBodyBytes> key{};
    EncodedFrame frame;
    while (encoder_->next(frame)) {
      FrameBuffer* out = publisher_->claim();
      if (out->key_wanted() || frame.slot->number % 8 == 0) {
        const std::size_t bytes =
            encoder_->key_packet(frame.slot->number, frame.slot->stamp_ns, key);
        (void)out->append(std::span(key).first(bytes), true);
      }
      for (std::uint32_t i = 0; i < frame.slot->report.slices; ++i)
        (void)out->append(frame.slot->slice(i));
      kept_ += frame.slot->counts.kept;
      (void)publisher_->publish(out);
      encoder_->release(frame);
    }
    disarm_pipeline("sender");
  }

  // Waits for the network in Subscriber::wait, which is this thread's to do; decoding is not.
  void receive_all() {
    arm("decoder");
    while (!done_.load()) {
      const FrameRef frame = subscriber_->wait(kSecond);
      if (!frame) continue;
      const std::uint64_t before = HeapGuard::this_thread().blocks();
      bool good = decoder_->set_key(frame->key()) == Status::kOk;
      good = decoder_->begin() == Status::kOk && good;
      for (std::uint16_t i = 0; i < frame->slice_count; ++i) {
        if (!frame->slice(i).empty()) good = decoder_->add(frame->slice(i)) == Status::kOk && good;
      }
      good = decoder_->finish() == Status::kOk && good;
      pipeline_blocks.fetch_add(HeapGuard::this_thread().blocks() - before);
      received_.ordered = received_.ordered && (seen_.load() == 0 || frame->frame > received_.last);
      received_.last = frame->frame;
      received_.points += decoder_->counts().points;
      ++(!good ? received_.failed : frame->complete() ? received_.whole : received_.partial);
      seen_.fetch_add(1);
    }
    HeapGuard::disarm_this_thread();
  }

  // A frame lost on the way would never come: the wait ends by itself.
  void wait_until_received(std::uint64_t count) const {
    for (int ms = 0; seen_.load() < count && ms < 20'000; ++ms)
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
  }

  Source source_;
  std::unique_ptr<Encoder> encoder_;
  std::unique_ptr<Decoder> decoder_;
  std::unique_ptr<Subscriber> subscriber_;
  std::unique_ptr<Publisher> publisher_;
  std::atomic<std::uint64_t> seen_{0};
  std::atomic<bool> done_{false};
  std::uint64_t kept_ = 0;
  Received received_;
};

class NoHeapStream : public testing::TestWithParam<StreamCase> {};
INSTANTIATE_TEST_SUITE_P(Kinds, NoHeapStream,
                         testing::Values(kStreamCases[0], kStreamCases[2], kStreamCases[4],
                                         kStreamCases[5]),
                         [](const auto& param) { return std::string(param.param.name); });
INSTANTIATE_TEST_SUITE_P(Lists, NoHeapStream, testing::Values(kListCases[1], kListCases[2]),
                         [](const auto& param) { return std::string(param.param.name); });

// Under a sanitizer the guard counts nothing; the run then only shows that the threads agree.
TEST_P(NoHeapStream, FramesOverLcmArriveWholeAndNoThreadDoesAnythingForbidden) {
  const FrameKind kind = GetParam().kind;
  const SimStream sim = kind == FrameKind::kDepth      ? sim_stream(160, 120, 30)
                        : kind == FrameKind::kRawCloud ? sim_stream(80, 60, 30)
                                                       : sim_stream(40, 30, 30);
  armed.store(0);
  Stream stream(sim, GetParam());
  const Received received = stream.run(kFrames);
  const HeapGuardTotals totals = HeapGuard::totals();
  // Four stages, sender, publisher, subscriber, decoder; depth frames are packed by two.
  EXPECT_EQ(armed.load(), kind == FrameKind::kDepth ? 9 : 8);
  EXPECT_EQ(received.whole, kFrames);
  EXPECT_EQ(received.partial, 0U);
  EXPECT_EQ(received.failed, 0U);
  EXPECT_TRUE(received.ordered);
  EXPECT_EQ(received.points, stream.kept());
  EXPECT_EQ(totals.allocations, 0U) << HeapGuard::first_offender();
  EXPECT_EQ(totals.frees, 0U) << HeapGuard::first_offender();
  EXPECT_EQ(totals.maps, 0U) << HeapGuard::first_offender();
  EXPECT_EQ(pipeline_blocks.load(), 0U) << HeapGuard::first_offender();
}

TEST(NoHeapStreamGuard, CatchesAnAllocationPlantedOnThePublishersThread) {
  PLANECAST_NEED_HEAP_GUARD();
  const SimStream sim = sim_stream(96, 72, 2);
  HeapGuard::reset();
  plant_in_publisher.store(true);
  const Stream stream(sim, kStreamCases[0]);
  // The plant comes at the thread's start, which nobody waits for.
  for (int i = 0; i < 10'000 && HeapGuard::totals().allocations == 0; ++i)
    std::this_thread::sleep_for(std::chrono::milliseconds(1));
  plant_in_publisher.store(false);
  EXPECT_EQ(HeapGuard::totals().allocations, 1U);
}

}  // namespace
}  // namespace planecast

int main(int argc, char** argv) {
  const char* inside = std::getenv("PLANECAST_NETNS");
  if (inside == nullptr || std::strcmp(inside, "1") != 0) {
    std::fprintf(stderr, "skipped: run this by tests/support/netns.sh, in a namespace\n");
    return 77;
  }
  ::unsetenv("LCM_DEFAULT_URL");
  ::testing::InitGoogleTest(&argc, argv);
  return RUN_ALL_TESTS();
}
