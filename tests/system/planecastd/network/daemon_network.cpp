// planecastd as a program, heard over LCM in a network namespace of its own.
#include <gtest/gtest.h>

#include <cmath>
#include <cstring>
#include <map>
#include <memory>
#include <set>
#include <string>
#include <vector>

#include "apps/common/frame_source.hpp"
#include "apps/common/packet_parse.hpp"
#include "core/pipeline/decoder.hpp"
#include "drake/lcmt_point_cloud.hpp"
#include "tests/system/planecastd/network/child.hpp"
#include "transport/subscriber.hpp"

namespace planecast {
namespace {

using test::Child;
using test::number_after;

constexpr std::int64_t kSecond = 1'000'000'000;

// A frame takes seconds under a thread sanitizer.
#if defined(__SANITIZE_THREAD__)
constexpr std::uint32_t kFrames = 4;
#elif defined(PLANECAST_SANITIZED)
constexpr std::uint32_t kFrames = 10;
#else
constexpr std::uint32_t kFrames = 30;
#endif

std::string room(std::uint32_t frames) {
  return "sim:room:" + std::to_string(frames);
}

std::shared_ptr<LcmLink> open_link(bool for_receiving) {
  return LcmLink::open(parse_lcm_url("").value(), for_receiving).value();
}

// Frames are handed on when complete; a slow machine is no reason for a partial one.
std::unique_ptr<Subscriber> open_subscriber() {
  SubscriberConfig config;
  config.parse = parse_planecast_packet;
  config.assembly.frame_bits = kPacketFrameBits;
  config.assembly.output_frames = 64;
  config.assembly.deadline_ns = 20 * kSecond;
  config.assembly.max_frame_bytes = 1U << 20U;
  config.lcm_queue = 2'000;  // several frames, for machines that hold the receiving thread up
  return std::move(Subscriber::create(config, open_link(true)).value());
}

std::unique_ptr<Decoder> open_decoder() {
  return std::move(Decoder::create(DecoderConfig{{640, 480}}).value());
}

/// Decodes a complete frame; the statuses of its slices are all ok.
void decode(Decoder& decoder, const AssembledFrame& frame) {
  ASSERT_TRUE(frame.complete()) << "frame " << frame.frame << ": " << frame.slices_received
                                << " of " << frame.slice_count << " slices";
  ASSERT_EQ(decoder.set_key(frame.key()), Status::kOk);
  ASSERT_EQ(decoder.begin(), Status::kOk);
  for (std::uint16_t i = 0; i < frame.slice_count; ++i)
    ASSERT_EQ(decoder.add(frame.slice(i)), Status::kOk) << "slice " << i;
  ASSERT_EQ(decoder.finish(), Status::kOk);
}

/// The largest distance of a point from its own reconstruction [m]; holes must agree.
double largest_error(const Decoder& decoder, const DepthImage& truth, const Intrinsics& camera) {
  double largest = 0;
  std::size_t differing_holes = 0;
  for (std::size_t i = 0; i < truth.depth.size(); ++i) {
    const Point3f& got = decoder.cloud()[i];
    if ((truth.depth[i] == 0) != std::isnan(got.z)) ++differing_holes;
    if (truth.depth[i] == 0 || std::isnan(got.z)) continue;
    const double z = truth.depth[i] * camera.metres_per_unit;
    const double x = (static_cast<double>(i % truth.width) - camera.cx) / camera.fx * z;
    const double y = (static_cast<double>(i / truth.width) - camera.cy) / camera.fy * z;
    largest = std::max(largest, std::hypot(x - got.x, y - got.y, z - got.z));
  }
  EXPECT_EQ(differing_holes, 0U);
  return largest;
}

/// Waits for the first frame that `wanted` accepts.
template <class Wanted>
FrameRef wait_for(Subscriber& subscriber, Wanted wanted) {
  for (int i = 0; i < 5'000; ++i) {
    FrameRef frame = subscriber.wait(kSecond / 10);
    if (frame && wanted(*frame)) return frame;
  }
  return {};
}

bool any_frame(const AssembledFrame&) {
  return true;
}

/// An organised cloud of 64 x 48 as a depth camera of 60 px sees a wall 2 m off; one row: the same
/// points without their grid.
std::vector<std::uint8_t> wall_message(bool organised) {
  constexpr int kWidth = 64, kHeight = 48;
  drake::lcmt_point_cloud cloud;
  cloud.utime = 1'000'000;
  cloud.frame_name = "wall";
  cloud.width = organised ? kWidth : kWidth * kHeight;
  cloud.height = organised ? kHeight : 1;
  cloud.num_fields = 3;
  cloud.fields.resize(3);
  for (std::size_t i = 0; i < 3; ++i) {
    cloud.fields[i].name = std::string(1, "xyz"[i]);
    cloud.fields[i].byte_offset = static_cast<std::int32_t>(4 * i);
    cloud.fields[i].datatype = drake::lcmt_point_cloud_field::FLOAT32;
    cloud.fields[i].count = 1;
  }
  cloud.point_step = 12;
  cloud.row_step = cloud.width * 12;
  cloud.flags = organised ? 0 : 2;
  cloud.filler_size = 0;
  cloud.data_size = kWidth * kHeight * 12;
  cloud.data.resize(static_cast<std::size_t>(cloud.data_size));
  for (int i = 0; i < kWidth * kHeight; ++i) {
    const float z = 2.0F + 0.001F * static_cast<float>(i % 7);
    const float xyz[3] = {(static_cast<float>(i % kWidth) - 32.0F) / 60.0F * z,
                          (static_cast<float>(i / kWidth) - 24.0F) / 60.0F * z, z};
    std::memcpy(cloud.data.data() + i * 12, xyz, 12);
  }
  std::vector<std::uint8_t> message(static_cast<std::size_t>(cloud.getEncodedSize()));
  cloud.encode(message.data(), 0, static_cast<int>(message.size()));
  return message;
}

}  // namespace

TEST(DaemonStream, EveryFrameArrivesCompleteAndWithinTheBound) {
  auto subscriber = open_subscriber();
  CodecOptions options;
  options.rate_hz = 10;  // the camera moves on by a frame period
  auto source = std::move(open_source({room(kFrames)}, options).value());
  const Intrinsics camera = source->sensor().intrinsics.value();
  auto decoder = open_decoder();
  Child daemon({PLANECASTD, room(kFrames), "--tolerance", "10mm", "--rate", "10", "--wait"});
  for (std::uint32_t number = 0; number < kFrames; ++number) {
    const FrameRef frame = wait_for(*subscriber, any_frame);
    ASSERT_TRUE(frame) << "frame " << number << "; " << daemon.talk();
    ASSERT_EQ(frame->frame, number);
    decode(*decoder, *frame);
    SensorFrame truth;
    ASSERT_TRUE(source->next(truth).value());
    EXPECT_LE(largest_error(*decoder, truth.depth, camera), 0.010 + 1e-6) << "frame " << number;
  }
  EXPECT_EQ(decoder->config().clock, ClockDomain::kMonotonic);
  EXPECT_NE(decoder->config().boot_id, 0U);
  EXPECT_EQ(daemon.wait(), 0) << daemon.talk();
  EXPECT_EQ(number_after(daemon.talk(), "frames in"), kFrames);
  EXPECT_EQ(number_after(daemon.talk(), "frames out"), kFrames);
  EXPECT_EQ(subscriber->statistics().streams[0].frames_lost, 0U);
}

TEST(DaemonStream, FasterThanItCanEncodeEveryFrameIsAccountedFor) {
  for (const char* threads : {"pipeline", "inline"}) {
    Child daemon({PLANECASTD, room(kFrames + 10), "--rate", "5000", "--threads", threads});
    ASSERT_EQ(daemon.wait(), 0) << daemon.talk();
    const std::string talk = daemon.talk();
    const long long in = number_after(talk, "frames in");
    const long long out = number_after(talk, "frames out");
    const long long failed = number_after(talk, "frames failed");
    const long long dropped = number_after(talk, "frames dropped");
    EXPECT_EQ(in, kFrames + 10) << talk;
    EXPECT_EQ(in, out + failed + dropped) << talk;
    EXPECT_GT(out, 0) << talk;
    EXPECT_EQ(failed, 0) << talk;
    EXPECT_NE(talk.find("in = out + failed + dropped: holds"), std::string::npos) << talk;
    // One worker a stage cannot keep up with 5 kHz; inline the source waits for its own work.
    if (threads[0] == 'p') {
      EXPECT_GT(dropped, 0) << talk;
      EXPECT_EQ(number_after(talk, "claim") + std::max(0LL, number_after(talk, "publisher")),
                dropped)
          << talk;
    }
  }
}

TEST(DaemonStream, SigtermDrainsAndPrintsTheBalance) {
  auto subscriber = open_subscriber();
  for (const int number : {SIGTERM, SIGINT}) {
    // At one frame in a hundred seconds the source sleeps when the signal comes.
    for (const char* rate : {"30", "0.01"}) {
      Child daemon({PLANECASTD, "sim:room:5", "--repeat", "0", "--rate", rate});
      ASSERT_TRUE(wait_for(*subscriber, any_frame)) << daemon.talk();
      daemon.signal(number);
      ASSERT_EQ(daemon.wait(std::chrono::seconds(120)), 0) << daemon.talk();
      const std::string talk = daemon.talk();
      EXPECT_NE(talk.find("stopped by a signal"), std::string::npos) << talk;
      EXPECT_NE(talk.find("in = out + failed + dropped: holds"), std::string::npos) << talk;
      EXPECT_GE(number_after(talk, "frames out"), 1) << talk;
      while (subscriber->wait(kSecond / 5)) {  // what was under way
      }
    }
  }
}

TEST(DaemonStream, RestartedDaemonIsJoinedMidStream) {
  auto subscriber = open_subscriber();
  auto decoder = open_decoder();
  auto daemon =
      std::make_unique<Child>(std::vector<std::string>{PLANECASTD, "sim:room:5", "--repeat", "0"});
  FrameRef before = wait_for(*subscriber, any_frame);
  ASSERT_TRUE(before) << daemon->talk();
  const std::uint32_t session = before->session;
  before.reset();
  daemon->signal(SIGKILL);
  ASSERT_EQ(daemon->wait(), 128 + SIGKILL);
  daemon =
      std::make_unique<Child>(std::vector<std::string>{PLANECASTD, "sim:room:5", "--repeat", "0"});
  const FrameRef after = wait_for(
      *subscriber, [session](const AssembledFrame& frame) { return frame.session != session; });
  ASSERT_TRUE(after) << daemon->talk();
  decode(*decoder, *after);
  EXPECT_EQ(subscriber->statistics().streams[0].session_changes, 1U);
}

TEST(DaemonStream, TwoDaemonsShareAChannel) {
  auto subscriber = open_subscriber();
  Child left({PLANECASTD, room(kFrames / 2), "--stream", "3", "--rate", "5", "--wait"});
  Child right(
      {PLANECASTD, room(kFrames / 2), "--stream", "255", "--seed", "2", "--rate", "5", "--wait"});
  std::map<int, std::set<std::uint32_t>> arrived;
  while (arrived[3].size() + arrived[255].size() < kFrames) {
    const FrameRef frame = wait_for(*subscriber, any_frame);
    ASSERT_TRUE(frame) << left.talk() << right.talk();
    EXPECT_TRUE(frame->complete());
    arrived[frame->stream].insert(frame->frame);
  }
  EXPECT_EQ(arrived.size(), 2U);
  EXPECT_EQ(left.wait(), 0);
  EXPECT_EQ(right.wait(), 0);
}

TEST(DaemonStream, CloudsFromLcmAreSentAndThoseOfAnotherShapeRefused) {
  auto subscriber = open_subscriber();
  auto decoder = open_decoder();
  const auto sender = open_link(false);
  Child daemon({PLANECASTD, "lcm:CLOUDS", "--tolerance", "10mm"});
  FrameRef frame;
  for (int i = 0; i < 2'000 && !frame; ++i) {
    (void)sender->publish("CLOUDS", wall_message(true));
    frame = subscriber->wait(kSecond / 20);
  }
  for (int i = 0; i < 100 && daemon.talk().find("is 3072x1") == std::string::npos; ++i) {
    (void)sender->publish("CLOUDS", wall_message(false));
    (void)subscriber->wait(kSecond / 20);
  }
  ASSERT_TRUE(frame) << daemon.talk();
  decode(*decoder, *frame);
  ASSERT_EQ(decoder->cloud().size(), 64U * 48U);
  EXPECT_NEAR(decoder->cloud()[0].z, 2.0F, 0.010F);
  EXPECT_EQ(decoder->config().clock, ClockDomain::kSensor);
  EXPECT_STREQ(decoder->config().frame_id.data(), "wall");
  EXPECT_EQ(stamp_of_offset(decoder->config().epoch_ns, frame->stamp_ns, 0), kSecond);
  daemon.signal(SIGTERM);
  EXPECT_EQ(daemon.wait(), 0) << daemon.talk();
  EXPECT_NE(daemon.talk().find("is 3072x1"), std::string::npos) << daemon.talk();
  EXPECT_NE(daemon.talk().find("in = out + failed + dropped: holds"), std::string::npos)
      << daemon.talk();
  EXPECT_GE(number_after(daemon.talk(), "frames failed"), 1) << daemon.talk();
}

}  // namespace planecast
