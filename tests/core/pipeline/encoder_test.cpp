// The encoder from outside: memory told and given, what submit() refuses, start and stop.
#include "core/pipeline/encoder.hpp"

#include <gtest/gtest.h>

#include <limits>

#include "core/ring/slot_pool.hpp"
#include "tests/core/pipeline/codec_bench.hpp"
#include "tests/support/data_path.hpp"

namespace planecast {
namespace {

using namespace test;

const SimStream& encoder_stream() {
  static const SimStream stream = sim_stream(96, 72, 12);
  return stream;
}

/// A 64-byte aligned block of exactly `bytes`, on the heap so that sanitizers see its ends.
class Block {
 public:
  explicit Block(std::size_t bytes)
      : bytes_(static_cast<std::byte*>(::operator new (bytes, std::align_val_t{64})), bytes) {}
  ~Block() { ::operator delete (bytes_.data(), std::align_val_t{64}); }
  Block(const Block&) = delete;
  Block& operator=(const Block&) = delete;
  std::span<std::byte> span() const { return bytes_; }

 private:
  std::span<std::byte> bytes_;
};

class EncoderOf : public testing::TestWithParam<StreamCase> {};
INSTANTIATE_TEST_SUITE_P(Kinds, EncoderOf, testing::ValuesIn(kStreamCases),
                         [](const auto& param) { return std::string(param.param.name); });

TEST_P(EncoderOf, UsesExactlyTheMemoryItTold) {
  for (const std::uint32_t slots : {1U, 6U}) {
    for (const std::uint32_t width : {1U, 96U, 97U}) {
      EncoderConfig config = encoder_config(encoder_stream(), GetParam(), RunMode::kInline, slots);
      config.stream.camera.width = static_cast<std::uint16_t>(width);
      const auto bytes = Encoder::memory_bytes(config);
      ASSERT_TRUE(bytes.ok()) << bytes.error().message;
      EXPECT_EQ(make_encoder(config)->memory_in_use(), *bytes)
          << slots << " slots, width " << width;
    }
  }
}

TEST_P(EncoderOf, RunsInTheCallersMemoryAndRefusesOneByteLess) {
  const EncoderConfig config = encoder_config(encoder_stream(), GetParam(), RunMode::kThreads);
  const std::size_t bytes = *Encoder::memory_bytes(config);
  const Source source(encoder_stream(), GetParam());
  const auto own = make_encoder(config);
  constexpr std::uint64_t kFrames = kSanitized ? 4 : 12;
  const auto expected = encode_frames(*own, source, 0, kFrames);
  const Block block(bytes);
  {
    auto encoder = Encoder::create(config, block.span());
    ASSERT_TRUE(encoder.ok()) << encoder.error().message;
    ASSERT_TRUE((*encoder)->start().ok());
    EXPECT_EQ((*encoder)->memory_in_use(), bytes);
    const auto coded = encode_frames(**encoder, source, 0, kFrames);
    ASSERT_EQ(coded.size(), expected.size());
    for (std::size_t i = 0; i < coded.size(); ++i) EXPECT_EQ(coded[i].slices, expected[i].slices);
  }
  const auto refused = Encoder::create(config, block.span().first(bytes - 1));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().status, Status::kOutOfArena);
  EXPECT_NE(refused.error().message.find(std::to_string(bytes)), std::string::npos);
}

TEST(Encoder, RefusesMisalignedMemory) {
  const EncoderConfig config = encoder_config(encoder_stream(), kStreamCases[0]);
  const std::size_t bytes = *Encoder::memory_bytes(config);
  const Block block(bytes + 8);
  const auto refused = Encoder::create(config, block.span().subspan(8));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().status, Status::kBadConfig);
}

TEST(Encoder, RefusesSettingsOutOfRangeByName) {
  const auto status = [](auto change) {
    EncoderConfig config = encoder_config(encoder_stream(), kStreamCases[0]);
    change(config);
    const auto bytes = Encoder::memory_bytes(config);
    const auto encoder = Encoder::create(config);
    if (encoder.ok()) {
      EXPECT_TRUE(bytes.ok());
    } else {
      EXPECT_FALSE(encoder.error().message.empty());
    }
    return encoder.ok() ? Status::kOk : encoder.error().status;
  };
  EXPECT_EQ(status([](EncoderConfig&) {}), Status::kOk);
  EXPECT_EQ(status([](EncoderConfig& c) { c.runner.slots = 0; }), Status::kBadConfig);
  EXPECT_EQ(status([](EncoderConfig& c) { c.runner.slots = SlotPool::kMaxSlots + 1; }),
            Status::kBadConfig);
  EXPECT_EQ(
      status([](EncoderConfig& c) { c.runner.slots = std::numeric_limits<std::uint32_t>::max(); }),
      Status::kBadConfig);
  EXPECT_EQ(status([](EncoderConfig& c) { c.runner.spin_ns = -2; }), Status::kBadConfig);
  EXPECT_EQ(status([](EncoderConfig& c) { c.stages.slice_bytes = kMinSliceBytes - 1; }),
            Status::kBadConfig);
  EXPECT_EQ(status([](EncoderConfig& c) { c.stages.slice_bytes = kFileSliceBytes + 1; }),
            Status::kBadConfig);
  EXPECT_EQ(status([](EncoderConfig& c) { c.stages.range_min = c.stages.range_max = 5; }),
            Status::kOk);
  EXPECT_EQ(status([](EncoderConfig& c) {
              c.stages.range_min = 6;
              c.stages.range_max = 5;
            }),
            Status::kBadConfig);
  EXPECT_EQ(status([](EncoderConfig& c) { c.stream.camera.width = 0; }), Status::kFieldRange);
  EXPECT_EQ(status([](EncoderConfig& c) { c.stream.camera.fx_q16 = 0; }), Status::kFieldRange);
  EXPECT_EQ(status([](EncoderConfig& c) { c.stream.tolerance = ToleranceKind::kSigma; }),
            Status::kFieldRange);
  EXPECT_EQ(status([](EncoderConfig& c) { c.stream.drop_off_surface = true; }),
            Status::kFieldRange);
  EXPECT_EQ(status([](EncoderConfig& c) {
              c.stream.tolerance = ToleranceKind::kSigma;
              c.stream.sigmas_q16 = 65536;
              c.stream.noise = {};
            }),
            Status::kBadConfig);
  EXPECT_EQ(status([](EncoderConfig& c) { c.stream.lattice.c_q8 = 100; }), Status::kFieldRange);
  EXPECT_EQ(status([](EncoderConfig& c) { c.stream.camera.k1_q24 = -(2 << 24); }),
            Status::kFieldRange);
}

TEST(Encoder, NamesTheSettingThatIsWrong) {
  const auto message = [](auto change) {
    EncoderConfig config = encoder_config(encoder_stream(), kStreamCases[0]);
    change(config);
    return Encoder::create(config).error().message;
  };
  EXPECT_NE(message([](EncoderConfig& c) { c.stages.slice_bytes = 10; }).find("256"),
            std::string::npos);
  EXPECT_NE(message([](EncoderConfig& c) {
              c.stages.slice_bytes = std::size_t{1} << 30U;
            }).find(std::to_string(kFileSliceBytes)),
            std::string::npos);
  EXPECT_NE(message([](EncoderConfig& c) { c.runner.slots = 0; }).find("slots"), std::string::npos);
  EXPECT_NE(message([](EncoderConfig& c) { c.stream.lattice.c_q8 = 100; }).find("lattice"),
            std::string::npos);
}

TEST(Encoder, RefusesFramesOfAnotherSizeOrKindUncounted) {
  const auto encoder = make_encoder(encoder_config(encoder_stream(), kStreamCases[0]));
  const std::vector<std::uint16_t> longer(96 * 72 + 1), shorter(96 * 72 - 1);
  const std::vector<Point3f> points(96 * 72);
  EXPECT_EQ(encoder->submit(DepthView{longer}), Status::kWrongSize);
  EXPECT_EQ(encoder->submit(DepthView{shorter}), Status::kWrongSize);
  EXPECT_EQ(encoder->submit(DepthView{}), Status::kWrongSize);
  EXPECT_EQ(encoder->submit(points, 0, 0), Status::kWrongSize);
  EXPECT_EQ(encoder->runner().totals().in, 0U);

  const auto raw = make_encoder(encoder_config(encoder_stream(), kStreamCases[5]));
  EXPECT_EQ(raw->submit(DepthView{encoder_stream().frames[0]}), Status::kWrongSize);
  EXPECT_EQ(raw->submit(std::span(points).first(100), 0, 0), Status::kWrongSize);
  EXPECT_EQ(raw->submit(points, 0, 0), Status::kOk);
}

TEST(Encoder, RefusesFramesWhileStoppedAndCountsThemDropped) {
  const EncoderConfig config = encoder_config(encoder_stream(), kStreamCases[0], RunMode::kThreads);
  const auto encoder = make_encoder(config, false);
  const Source source(encoder_stream(), kStreamCases[0]);
  EXPECT_EQ(source.submit(*encoder, 0), Status::kStopped);
  ASSERT_TRUE(encoder->start().ok());
  EXPECT_EQ(source.submit(*encoder, 1), Status::kOk);
  encoder->stop();
  EXPECT_EQ(source.submit(*encoder, 2), Status::kStopped);
  EXPECT_EQ(source.submit(*encoder, 3, true), Status::kStopped);
  EncodedFrame frame;
  ASSERT_TRUE(encoder->next(frame));
  EXPECT_EQ(frame.slot->number, 1U);
  encoder->release(frame);
  EXPECT_FALSE(encoder->next(frame));
  const FrameTotals totals = encoder->runner().totals();
  EXPECT_EQ(totals.in, 4U);
  EXPECT_EQ(totals.ok, 1U);
  EXPECT_EQ(totals.dropped, 3U);
}

TEST(Encoder, WithoutAFreeSlotTheNewFrameIsDroppedAndCounted) {
  const auto encoder =
      make_encoder(encoder_config(encoder_stream(), kStreamCases[0], RunMode::kInline, 3));
  const Source source(encoder_stream(), kStreamCases[0]);
  for (std::uint64_t i = 0; i < 3; ++i) EXPECT_EQ(source.submit(*encoder, i), Status::kOk);
  EXPECT_EQ(source.submit(*encoder, 3), Status::kNoSlot);
  EXPECT_EQ(source.submit(*encoder, 4), Status::kNoSlot);
  EncodedFrame frame;
  ASSERT_TRUE(encoder->try_next(frame));
  EXPECT_EQ(frame.slot->number, 0U);  // the oldest is kept, the new one was dropped
  encoder->release(frame);
  EXPECT_EQ(source.submit(*encoder, 5), Status::kOk);
  std::vector<std::uint64_t> numbers;
  for (const Coded& coded : take_all(*encoder)) numbers.push_back(coded.number);
  EXPECT_EQ(numbers, (std::vector<std::uint64_t>{1, 2, 5}));
  const FrameTotals totals = encoder->runner().totals();
  EXPECT_EQ(totals.in, 6U);
  EXPECT_EQ(totals.ok, 4U);
  EXPECT_EQ(totals.dropped, 2U);
}

TEST(Encoder, GoesOnAfterARestartAsIfNothingHadHappened) {
  for (const RunMode mode : {RunMode::kInline, RunMode::kThreads}) {
    const EncoderConfig config = encoder_config(encoder_stream(), kStreamCases[2], mode);
    const Source source(encoder_stream(), kStreamCases[2]);
    const auto straight = make_encoder(config);
    const auto expected = encode_frames(*straight, source, 0, 12);
    const auto encoder = make_encoder(config);
    auto coded = encode_frames(*encoder, source, 0, 5);
    encoder->stop();
    encoder->stop();
    ASSERT_TRUE(encoder->start().ok());
    ASSERT_TRUE(encoder->start().ok());
    for (Coded& one : encode_frames(*encoder, source, 5, 7)) coded.push_back(std::move(one));
    ASSERT_EQ(coded.size(), expected.size());
    for (std::size_t i = 0; i < coded.size(); ++i) {
      EXPECT_EQ(coded[i].number, i);
      EXPECT_EQ(coded[i].slices, expected[i].slices) << i;
    }
  }
}

// Slots are used again, so what a discarded frame shows must not be the frame before it.
TEST(Encoder, DiscardedFramesComeOutWithStatusStoppedAndNothingInThem) {
  const auto encoder =
      make_encoder(encoder_config(encoder_stream(), kStreamCases[3], RunMode::kThreads, 8));
  const Source source(encoder_stream(), kStreamCases[3]);
  ASSERT_EQ(encode_frames(*encoder, source, 0, 16).size(), 16U);
  for (std::uint64_t i = 0; i < 8; ++i) EXPECT_EQ(source.submit(*encoder, i), Status::kOk);
  encoder->stop(StopMode::kDiscard);
  std::uint64_t ok = 0, discarded = 0;
  EncodedFrame frame;
  while (encoder->try_next(frame)) {
    EXPECT_EQ(frame.slot->number, ok + discarded);
    ++(frame.status == Status::kOk ? ok : discarded);
    if (frame.status != Status::kOk) {
      EXPECT_EQ(frame.status, Status::kStopped);
      EXPECT_EQ(frame.slot->report.slices, 0U);
      EXPECT_EQ(frame.slot->report.bytes, 0U);
      EXPECT_EQ(frame.slot->counts.kept, 0U);
      EXPECT_EQ(frame.slot->packed_ns, 0);
    }
    encoder->release(frame);
  }
  EXPECT_EQ(ok + discarded, 8U);
  EXPECT_EQ(encoder->runner().totals().failed, discarded);
}

TEST(Encoder, MayBeDestroyedWhileFramesAreUnderWay) {
  const Source source(encoder_stream(), kStreamCases[2]);
  for (int round = 0; round < 20; ++round) {
    const auto encoder =
        make_encoder(encoder_config(encoder_stream(), kStreamCases[2], RunMode::kThreads, 4));
    for (int i = 0; i < round % 6; ++i) (void)source.submit(*encoder, 0);
  }
}

TEST(Encoder, KeyPacketSaysTheConfiguration) {
  const auto encoder = make_encoder(encoder_config(encoder_stream(), kStreamCases[4]));
  const auto key = key_of(*encoder, 0x12345678);
  PacketHeader header;
  ASSERT_EQ(open_packet(key, header), Status::kOk);
  EXPECT_TRUE(header.key);
  EXPECT_EQ(header.frame, 0x345678U);
  EXPECT_EQ(header.key_hash, encoder->tables().key_hash());
  StreamConfig config;
  ASSERT_EQ(read_key_body(std::span(key).subspan(kPacketHeaderBytes), config), Status::kOk);
  EXPECT_EQ(config, encoder->config().stream);
  std::vector<std::uint8_t> exact(key.size()), short_by_one(key.size() - 1);
  EXPECT_EQ(encoder->key_packet(1, 2, exact), key.size());
  EXPECT_EQ(encoder->key_packet(1, 2, short_by_one), 0U);
}

TEST(Encoder, StampsAtBothEndsOfTimeWrapInsteadOfOverflowing) {
  EncoderConfig config = encoder_config(encoder_stream(), kStreamCases[0]);
  config.stream.epoch_ns = 1000;
  const auto encoder = make_encoder(config);
  constexpr std::int64_t kLowest = std::numeric_limits<std::int64_t>::min();
  ASSERT_EQ(encoder->submit(DepthView{encoder_stream().frames[0], 0, kLowest}), Status::kOk);
  const auto coded = take_all(*encoder);
  PacketHeader slice, key;
  ASSERT_EQ(open_packet(coded.at(0).slices.at(0), slice), Status::kOk);
  EXPECT_EQ(slice.stamp_offset, (std::uint64_t{1} << 48U) - 1000);
  std::vector<std::uint8_t> packet(kPacketHeaderBytes + kMaxKeyBodyBytes);
  packet.resize(encoder->key_packet(0, kLowest, packet));
  ASSERT_EQ(open_packet(packet, key), Status::kOk);
  EXPECT_EQ(key.stamp_offset, slice.stamp_offset);
}

// White noise in the narrowest image whose blocks outnumber the slices of a frame: the only way
// for a frame to fail here.
TEST(Encoder, AFrameOfTooManySlicesFailsIsCountedAndTheNextGoesOn) {
  PLANECAST_NEED_SPEED();
  EncoderConfig config;
  Intrinsics in;
  in.fx = in.fy = 8000;
  config.stream.camera = *quantise(in, 257, 16384);
  config.stream.noise = {NoiseModel::Kind::kTof, 5'000'000};
  config.stages.slice_bytes = kMinSliceBytes;
  config.runner = {.slots = 1, .mode = RunMode::kInline};
  const auto encoder = make_encoder(config);
  std::vector<std::uint16_t> noise(config.stream.camera.pixels());
  Pcg32 random(3, 5);
  for (std::uint16_t& d : noise) d = static_cast<std::uint16_t>(1 + random.below(65535));
  ASSERT_EQ(encoder->submit(DepthView{noise, 0, 0}), Status::kOk);
  EncodedFrame failed;
  ASSERT_TRUE(encoder->try_next(failed));
  EXPECT_EQ(failed.status, Status::kTooLarge);
  EXPECT_EQ(failed.slot->report.slices, 0U);
  EXPECT_EQ(failed.slot->counts.kept, 0U);
  encoder->release(failed);

  noise.assign(noise.size(), 0);
  noise[5] = 777;
  ASSERT_EQ(encoder->submit(DepthView{noise, 1, 0}), Status::kOk);
  const auto coded = take_all(*encoder);
  ASSERT_EQ(coded.size(), 1U);
  EXPECT_EQ(coded[0].status, Status::kOk);
  EXPECT_EQ(coded[0].number, 1U);
  EXPECT_EQ(coded[0].counts.kept, 1U);
  const FrameTotals totals = encoder->runner().totals();
  EXPECT_EQ(totals.in, 2U);
  EXPECT_EQ(totals.failed, 1U);
  EXPECT_EQ(totals.ok, 1U);
}

}  // namespace
}  // namespace planecast
