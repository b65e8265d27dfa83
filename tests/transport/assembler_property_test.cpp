// Random networks: whatever is lost, doubled, reordered and restarted, each packet that arrives is
// handed on exactly once with its own bytes, or is in exactly one counter.
#include <gtest/gtest.h>

#include <algorithm>
#include <map>
#include <memory>
#include <set>
#include <tuple>
#include <vector>

#include "tests/transport/fake_packet.hpp"
#include "transport/assembler.hpp"

namespace planecast {
namespace {

using test::fake_packet;
using test::key_info;
using test::slice_info;

#ifdef PLANECAST_SANITIZED
constexpr std::uint64_t kSeedShare = 8;  // the sanitizers are that much slower
#else
constexpr std::uint64_t kSeedShare = 1;
#endif

struct Network {
  double loss = 0;
  double duplicate = 0;
  std::uint32_t reorder = 0;  ///< packets a packet may fall behind
  double restart = 0;         ///< chance a frame that its sender restarts
};

struct Arrival {
  std::uint64_t order;
  PacketInfo info;
};

/// Three senders interleaved packet by packet, then lost, doubled and reordered.
std::vector<Arrival> make_arrivals(const Network& network, Pcg32& random) {
  std::vector<Arrival> arrivals;
  std::uint64_t order = 0;
  const auto send = [&](const PacketInfo& info) {
    ++order;
    const int copies = 1 + (random.uniform() < network.duplicate ? 1 : 0);
    for (int i = 0; i < copies; ++i)
      if (random.uniform() >= network.loss)
        arrivals.push_back({order + random.below(network.reorder + 1), info});
  };
  std::uint32_t session = 100;
  struct Sender {
    std::uint16_t stream;
    std::uint32_t session;
    std::uint32_t frame;
  };
  std::vector<Sender> senders = {{1, 1, 0}, {2, 2, 0xFFFFFFF0U}, {9, 3, 70'000}};
  for (int round = 0; round < 120; ++round) {
    std::vector<std::vector<PacketInfo>> frames;
    for (Sender& sender : senders) {
      if (random.uniform() < network.restart) sender = {sender.stream, ++session, random.next()};
      std::vector<PacketInfo> frame;
      if (round % 8 == 0) frame.push_back(key_info(sender.session, sender.stream, sender.frame));
      const auto count = static_cast<std::uint16_t>(1 + random.below(12));
      for (std::uint16_t i = 0; i < count; ++i)
        frame.push_back(slice_info(sender.session, sender.stream, sender.frame, i, count));
      ++sender.frame;
      frames.push_back(std::move(frame));
    }
    for (std::size_t i = 0; i < 13; ++i)
      for (const auto& frame : frames)
        if (i < frame.size()) send(frame[i]);
  }
  std::stable_sort(arrivals.begin(), arrivals.end(),
                   [](const Arrival& a, const Arrival& b) { return a.order < b.order; });
  return arrivals;
}

using Identity = std::tuple<std::uint16_t, std::uint32_t, std::uint32_t, std::uint16_t>;

struct Consumer {
  std::set<Identity> seen;
  std::map<std::uint16_t, std::uint64_t> slices;
  std::map<std::uint16_t, std::uint64_t> frames;
  std::map<std::pair<std::uint16_t, std::uint32_t>, std::uint32_t> last;

  void check(const AssembledFrame& frame) {
    ++frames[frame.stream];
    const auto place = last.find({frame.stream, frame.session});
    if (place != last.end()) {
      EXPECT_GT(frame_distance(place->second, frame.frame), 0);
    }
    last[{frame.stream, frame.session}] = frame.frame;
    std::uint16_t present = 0;
    for (std::uint16_t i = 0; i < frame.slice_count; ++i) {
      const auto bytes = frame.slice(i);
      if (bytes.empty()) continue;
      ++present;
      ++slices[frame.stream];
      EXPECT_TRUE(seen.insert({frame.stream, frame.session, frame.frame, i}).second);
      const auto expected =
          fake_packet(slice_info(frame.session, frame.stream, frame.frame, i, frame.slice_count));
      EXPECT_TRUE(std::equal(bytes.begin(), bytes.end(), expected.begin(), expected.end()));
    }
    EXPECT_EQ(present, frame.slices_received);
    if (!frame.key().empty()) {
      PacketInfo key;
      EXPECT_EQ(test::parse_fake(frame.key(), key), Status::kOk);
      EXPECT_EQ(key.session, frame.session);
      EXPECT_EQ(key.stream, frame.stream);
    }
  }
};

void expect_balance(const StreamStatistics& s, std::uint64_t arrived) {
  EXPECT_EQ(s.slices_received, arrived);
  EXPECT_EQ(s.slices_received, s.slices_delivered + s.slices_duplicate + s.slices_late +
                                   s.slices_old_session + s.slices_inconsistent +
                                   s.slices_too_large + s.slices_no_slot + s.slices_discarded);
  EXPECT_EQ(s.frames_complete + s.frames_partial, s.frames_taken + s.frames_skipped);
}

/// Runs one random network through; returns the sums over the streams.
StreamStatistics run(const Network& network, std::uint64_t seed, std::uint16_t output_frames) {
  Pcg32 random(seed);
  AssemblerConfig config;
  config.max_streams = 3;
  config.max_slices = 12;
  config.max_frame_bytes = 2048;
  config.frames_in_assembly = static_cast<std::uint16_t>(1 + random.below(4));
  config.output_frames = output_frames;
  config.session_timeout_ns = 1'000'000'000'000;
  Assembler& assembler = *Assembler::create(config).value().release();
  const std::unique_ptr<Assembler> owner(&assembler);
  Consumer consumer;
  std::map<std::uint16_t, std::uint64_t> arrived;
  std::int64_t now_ns = 1;
  for (const Arrival& arrival : make_arrivals(network, random)) {
    now_ns += 900'000;
    assembler.poll(now_ns);
    if (!arrival.info.key) ++arrived[arrival.info.stream];
    assembler.push(fake_packet(arrival.info), arrival.info, now_ns);
    if (random.below(4) == 0 || output_frames > 100)
      while (const FrameRef frame = assembler.take()) consumer.check(*frame);
  }
  assembler.poll(now_ns + 1'000'000'000);
  EXPECT_EQ(assembler.next_deadline_ns(), std::numeric_limits<std::int64_t>::max());
  while (const FrameRef frame = assembler.take()) consumer.check(*frame);

  StreamStatistics sum;
  const ReceiverStatistics all = assembler.statistics();
  EXPECT_EQ(all.stream_count, 3);
  for (std::uint16_t i = 0; i < all.stream_count; ++i) {
    const StreamStatistics& s = all.streams[i];
    expect_balance(s, arrived[s.stream]);
    EXPECT_EQ(s.frames_taken, consumer.frames[s.stream]);
    if (output_frames > 100) {
      EXPECT_EQ(s.slices_delivered, consumer.slices[s.stream]);
    }
    sum.slices_delivered += s.slices_delivered;
    sum.slices_lost += s.slices_lost;
    sum.slices_duplicate += s.slices_duplicate;
    sum.slices_late += s.slices_late;
    sum.slices_reordered += s.slices_reordered;
    sum.slices_old_session += s.slices_old_session;
    sum.slices_discarded += s.slices_discarded;
    sum.frames_complete += s.frames_complete;
    sum.frames_partial += s.frames_partial;
    sum.frames_lost += s.frames_lost;
    sum.frames_skipped += s.frames_skipped;
    sum.session_changes += s.session_changes;
  }
  return sum;
}

}  // namespace

TEST(AssemblerProperty, APerfectNetworkDeliversEverything) {
  for (std::uint64_t seed = 0; seed < 20 / kSeedShare; ++seed) {
    const StreamStatistics sum = run({}, seed, 256);
    EXPECT_EQ(sum.frames_complete, 360U);
    EXPECT_EQ(sum.frames_partial + sum.frames_lost + sum.slices_lost + sum.slices_duplicate +
                  sum.slices_late + sum.slices_reordered + sum.session_changes,
              0U);
  }
}

TEST(AssemblerProperty, EverySurvivingSliceIsDeliveredOnceOrCounted) {
  StreamStatistics seen;
  for (std::uint64_t seed = 0; seed < 160 / kSeedShare; ++seed) {
    SCOPED_TRACE(seed);
    Pcg32 random(seed, 5);
    Network network;
    network.loss = random.below(3) * 0.1;
    network.duplicate = random.below(3) * 0.1;
    network.reorder = random.below(4) * 15;
    network.restart = random.below(3) * 0.02;
    const StreamStatistics sum = run(network, seed, 256);
    seen.slices_lost += sum.slices_lost;
    seen.slices_duplicate += sum.slices_duplicate;
    seen.slices_late += sum.slices_late;
    seen.slices_reordered += sum.slices_reordered;
    seen.slices_old_session += sum.slices_old_session;
    seen.slices_discarded += sum.slices_discarded;
    seen.frames_lost += sum.frames_lost;
    seen.session_changes += sum.session_changes;
  }
  // The networks really did what the test is about.
  EXPECT_GT(seen.slices_lost, 0U);
  EXPECT_GT(seen.slices_duplicate, 0U);
  EXPECT_GT(seen.slices_late, 0U);
  EXPECT_GT(seen.slices_reordered, 0U);
  EXPECT_GT(seen.slices_old_session, 0U);
  EXPECT_GT(seen.slices_discarded, 0U);
  EXPECT_GT(seen.frames_lost, 0U);
  EXPECT_GT(seen.session_changes, 0U);
}

TEST(AssemblerProperty, ASlowConsumerGetsTheNewestAndTheRestIsCounted) {
  std::uint64_t skipped = 0;
  for (std::uint64_t seed = 0; seed < 48 / kSeedShare; ++seed) {
    SCOPED_TRACE(seed);
    skipped += run({0.05, 0.05, 10, 0.01}, seed, 1).frames_skipped;
  }
  EXPECT_GT(skipped, 0U);
}

TEST(AssemblerProperty, LossAloneLosesOnlyTheSlicesLost) {
  // Without reordering nothing is late, and no slice that arrived goes missing.
  for (std::uint64_t seed = 0; seed < 48 / kSeedShare; ++seed) {
    const StreamStatistics sum = run({0.1, 0, 0, 0}, seed, 256);
    EXPECT_EQ(sum.slices_late + sum.slices_duplicate + sum.slices_reordered, 0U) << seed;
  }
}

}  // namespace planecast
