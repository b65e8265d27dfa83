#include "bench/latency_run.hpp"

#include <sched.h>
#include <sys/prctl.h>

#include <algorithm>
#include <atomic>
#include <cmath>
#include <memory>
#include <thread>

#include "apps/common/frame_slices.hpp"
#include "apps/common/packet_parse.hpp"
#include "apps/common/stream_sender.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/pipeline/frame_team.hpp"
#include "core/pipeline/worker_thread.hpp"
#include "core/wire/frame_pack.hpp"
#include "core/wire/key_packet.hpp"
#include "core/wire/raw_pack.hpp"
#include "transport/lcm_url.hpp"
#include "transport/publisher.hpp"
#include "transport/subscriber.hpp"
#include "transport/wake.hpp"

namespace planecast::bench {
namespace {

constexpr std::int64_t kTimerNs = 2'000'000;
constexpr std::int64_t kEndWaitNs = 500'000'000;
constexpr std::uint32_t kWarmUpFrames = 10;

void sleep_until(std::int64_t ns) {
  const timespec at = to_timespec(ns);
  while (::clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &at, nullptr) == EINTR) continue;
}

/// Moments of one frame, monotonic clock; 0: did not get there.
struct Moments {
  std::int64_t submitted = 0, packed = 0, arrived = 0, assembled = 0, taken = 0, unpacked = 0,
               readable = 0;
};

class Measurement {
 public:
  Measurement(const LatencyPlan& plan, const StreamSetup& setup, const CodecOptions& options,
              const Frames& frames)
      : plan_(plan),
        setup_(setup),
        options_(options),
        frames_(frames),
        moments_(plan.frames + kWarmUpFrames) {}

  Result<LatencyResult> run() {
    if (const auto ready = prepare(); !ready) return ready.error();
    if (const auto started = encoder_->start(); !started) return started.error();
    std::thread timer([this] { time_the_machine(); });
    std::thread load([this] { keep_a_core_busy(); });
    std::thread consumer([this] { plan_.lcm ? receive() : consume(); });
    std::thread sender([this] {
      if (plan_.lcm) sender_->run();
    });
    play();
    encoder_->stop(StopMode::kDrain);
    sender.join();
    if (plan_.lcm) (void)publisher_->flush(kEndWaitNs);
    sleep_until(monotonic_ns() + kEndWaitNs / 5);
    over_ = true;
    if (subscriber_) subscriber_->interrupt();
    for (std::thread* thread : {&timer, &load, &consumer}) thread->join();
    return result();
  }

 private:
  Result<Done> prepare() {
    auto made = Encoder::create(setup_.encoder);
    if (!made) return made.error();
    encoder_ = std::move(*made);
    const CameraModel& camera = setup_.encoder.stream.camera;
    if (team_.start({.name = "unpack2"}) != 0)
      return Error{Status::kStopped, "no thread to help with decoding"};
    FrameLimits limits{camera.width, camera.height};
    limits.max_points = setup_.encoder.stream.points.max_points;
    auto decoder = Decoder::create({limits, team_.work()});
    if (!decoder) return decoder.error();
    decoder_ = std::move(*decoder);
    std::vector<std::uint8_t> key(kPacketHeaderBytes + kMaxKeyBodyBytes);
    key.resize(encoder_->key_packet(0, 0, key));
    if (const Status status = decoder_->set_key(key); status != Status::kOk)
      return Error{status, "the key packet is refused"};
    return plan_.lcm ? prepare_lcm() : Done{};
  }

  Result<Done> prepare_lcm() {
    const auto url = options_.lcm_url.empty() ? default_lcm_url() : parse_lcm_url(options_.lcm_url);
    if (!url) return url.error();
    auto receiving = LcmLink::open(*url, true);
    if (!receiving) return receiving.error();
    SubscriberConfig subscribe;
    subscribe.channel = options_.channel;
    subscribe.parse = parse_planecast_packet;
    subscribe.assembly.frame_bits = kPacketFrameBits;
    subscribe.assembly.max_streams = 1;
    subscribe.assembly.deadline_ns = 100'000'000;
    subscribe.message_bytes = options_.slice_bytes;
    auto subscribed = Subscriber::create(subscribe, std::move(*receiving));
    if (!subscribed) return subscribed.error();
    subscriber_ = std::move(*subscribed);
    auto sending = LcmLink::open(*url, false);
    if (!sending) return sending.error();
    PublisherConfig publish;
    publish.channel = options_.channel;
    publish.message_bytes = std::max<std::uint32_t>(options_.slice_bytes, 1200);
    auto published = Publisher::create(publish, std::move(*sending));
    if (!published) return published.error();
    publisher_ = std::move(*published);
    sender_ = std::make_unique<StreamSender>(
        *encoder_, *publisher_, SenderConfig{.key_every_frames = key_interval(plan_.rate_hz)});
    return Done{};
  }

  void play() {
    const auto period_ns = static_cast<std::int64_t>(std::llround(1e9 / plan_.rate_hz));
    std::int64_t due_ns = monotonic_ns() + period_ns;
    for (std::uint32_t i = 0; i < moments_.size(); ++i, due_ns += period_ns) {
      sleep_until(due_ns);
      const std::int64_t now_ns = monotonic_ns();
      moments_[i].submitted = now_ns;
      const std::size_t which = i % frames_.count();
      if (frames_.depth.empty()) {
        (void)encoder_->submit(frames_.points[which], i, now_ns);
      } else {
        (void)encoder_->submit(DepthView{frames_.depth[which], i, now_ns});
      }
    }
  }

  // What a library's user does without a network: bytes go from the encoder to the decoder.
  void consume() {
    EncodedFrame frame;
    while (encoder_->next(frame)) {
      Moments& at = moments_[frame.slot->number];
      at.taken = monotonic_ns();
      at.packed = frame.slot->packed_ns;
      if (frame.status == Status::kOk) {
        (void)decoder_->begin();
        (void)decoder_->add_all(
            {frame.slot, frame.slot->report.slices, [](const void* slot, std::uint32_t i) noexcept {
               return static_cast<const FrameSlot*>(slot)->slice(i);
             }});
        finish(at, frame.slot->report.slices);
      }
      encoder_->release(frame);
    }
  }

  void receive() {
    while (!over_) {
      const FrameRef frame = subscriber_->wait(kEndWaitNs);
      if (!frame || frame->frame >= moments_.size()) continue;
      Moments& at = moments_[frame->frame];
      at.taken = monotonic_ns();
      at.arrived = frame->first_ns;
      at.assembled = frame->ready_ns;
      (void)decoder_->begin();
      (void)decoder_->add_all(slices_of(*frame));
      finish(at, frame->slice_count);
    }
  }

  void finish(Moments& at, std::uint32_t slices) {
    at.unpacked = monotonic_ns();
    (void)decoder_->finish();
    if (decoder_->counts().slices == slices) at.readable = monotonic_ns();
  }

  // As cyclictest: how late a thread that sleeps until a given moment is on its core.
  void time_the_machine() {
    ::prctl(PR_SET_TIMERSLACK, 1UL, 0UL, 0UL, 0UL);
    timer_.reserve(1U << 20U);
    for (std::int64_t due_ns = monotonic_ns() + kTimerNs; !over_; due_ns += kTimerNs) {
      sleep_until(due_ns);
      timer_.push_back(monotonic_ns() - due_ns);
      if (timer_.back() > kTimerNs) due_ns = monotonic_ns();
    }
  }

  void keep_a_core_busy() const {
    if (!plan_.loaded) return;
    (void)prepare_worker({.name = "load", .core = 0});
    while (!over_) continue;
  }

  template <class F>
  Step step(const char* name, F&& between) const {
    Step out{name, {}};
    for (std::size_t i = kWarmUpFrames; i < moments_.size(); ++i)
      if (moments_[i].readable != 0) out.ns.push_back(between(moments_[i]));
    std::sort(out.ns.begin(), out.ns.end());
    return out;
  }

  LatencyResult result() {
    LatencyResult out{plan_, {}, {"timer", std::move(timer_)}, moments_.size(), 0, 0, 0, 0, 0};
    std::sort(out.timer.ns.begin(), out.timer.ns.end());
    if (plan_.lcm) {
      out.steps = {step("to first slice", [](const Moments& m) { return m.arrived - m.submitted; }),
                   step("all slices", [](const Moments& m) { return m.assembled - m.arrived; }),
                   step("receiver wakes", [](const Moments& m) { return m.taken - m.assembled; })};
    } else {
      out.steps = {step("to packed", [](const Moments& m) { return m.packed - m.submitted; }),
                   step("consumer wakes", [](const Moments& m) { return m.taken - m.packed; })};
    }
    out.steps.push_back(step("unpack", [](const Moments& m) { return m.unpacked - m.taken; }));
    out.steps.push_back(
        step("regenerate", [](const Moments& m) { return m.readable - m.unpacked; }));
    out.steps.push_back(
        step("frame to cloud", [](const Moments& m) { return m.readable - m.submitted; }));
    for (const Moments& at : moments_) out.readable += at.readable != 0 ? 1 : 0;
    out.no_slot = encoder_->runner().totals().dropped;
    if (plan_.lcm) {
      const PublisherStatistics sent = publisher_->statistics();
      const ReceiverStatistics got = subscriber_->statistics();
      out.not_sent = sent.frames_published - sent.frames_sent;
      out.skipped = got.streams[0].frames_skipped;
      out.lost =
          got.streams[0].frames_lost + got.streams[0].frames_partial - out.no_slot - out.not_sent;
    }
    return out;
  }

  LatencyPlan plan_;
  const StreamSetup& setup_;
  const CodecOptions& options_;
  const Frames& frames_;
  std::vector<Moments> moments_;
  std::vector<std::int64_t> timer_;
  std::atomic<bool> over_{false};
  std::unique_ptr<Encoder> encoder_;
  FrameTeam team_;  ///< as planecast-recv has one
  std::unique_ptr<Decoder> decoder_;
  std::unique_ptr<Subscriber> subscriber_;
  std::unique_ptr<Publisher> publisher_;
  std::unique_ptr<StreamSender> sender_;
};

}  // namespace

std::int64_t Step::at(double percent) const {
  if (ns.empty()) return 0;
  const double rank = std::ceil(percent / 100 * static_cast<double>(ns.size()));
  return ns[static_cast<std::size_t>(std::clamp(rank, 1.0, static_cast<double>(ns.size()))) - 1];
}

Result<LatencyResult> run_latency(const LatencyPlan& plan, const StreamSetup& setup,
                                  const CodecOptions& options, const Frames& frames) {
  return Measurement(plan, setup, options, frames).run();
}

}  // namespace planecast::bench
