// The decoder from outside: memory, limits, keys that come late, change or are foreign, slices that
// never come.
#include "core/pipeline/decoder.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <span>

#include "core/pipeline/frame_team.hpp"
#include "tests/core/pipeline/codec_bench.hpp"

namespace planecast {
namespace {

using namespace test;

constexpr DecoderConfig kSmall{{96, 72}};

const SimStream& decoder_stream() {
  static const SimStream stream = sim_stream(96, 72, 6);
  return stream;
}

/// Frames of one case with the key to read them.
struct Recording {
  std::vector<std::uint8_t> key;
  std::vector<Coded> frames;
  Source source;

  explicit Recording(const StreamCase& c, std::size_t slice_bytes = 1190, std::uint32_t session = 7)
      : source(decoder_stream(), c) {
    EncoderConfig config = encoder_config(decoder_stream(), c);
    config.stages.slice_bytes = slice_bytes;
    config.stream.session = session;
    const auto encoder = make_encoder(config);
    key = key_of(*encoder);
    frames = encode_frames(*encoder, source, 0, decoder_stream().frames.size());
  }
};

TEST(Decoder, UsesExactlyTheMemoryItToldAndRefusesOneByteLess) {
  const std::size_t bytes = Decoder::memory_bytes(kSmall);
  std::vector<std::byte> memory(bytes + 64);
  const std::size_t shift = 64 - reinterpret_cast<std::uintptr_t>(memory.data()) % 64;
  const std::span<std::byte> block(memory.data() + shift, bytes);
  auto decoder = Decoder::create(kSmall, block);
  ASSERT_TRUE(decoder.ok()) << decoder.error().message;
  EXPECT_EQ((*decoder)->memory_in_use(), bytes);
  EXPECT_EQ(make_decoder(kSmall)->memory_in_use(), bytes);

  const Recording lossless(kStreamCases[0]);
  ASSERT_EQ((*decoder)->set_key(lossless.key), Status::kOk);
  decode_frame(**decoder, lossless.frames[0]);
  EXPECT_TRUE(std::ranges::equal((*decoder)->depth(), decoder_stream().frames[0]));

  const auto refused = Decoder::create(kSmall, block.first(bytes - 1));
  ASSERT_FALSE(refused.ok());
  EXPECT_EQ(refused.error().status, Status::kOutOfArena);
  EXPECT_NE(refused.error().message.find(std::to_string(bytes)), std::string::npos);
  const std::span<std::byte> misaligned(memory.data() + shift - 8, bytes);
  EXPECT_EQ(Decoder::create(kSmall, misaligned).error().status, Status::kBadConfig);
}

TEST(Decoder, GivesLosslessFramesBackBitForBit) {
  const Recording depth(kStreamCases[0]), raw(kStreamCases[5]);
  const auto decoder = make_decoder(kSmall);
  ASSERT_EQ(decoder->set_key(depth.key), Status::kOk);
  for (std::size_t i = 0; i < depth.frames.size(); ++i) {
    decode_frame(*decoder, depth.frames[i]);
    EXPECT_TRUE(std::ranges::equal(decoder->depth(), depth.source.depth(i)));
    EXPECT_EQ(decoder->counts().points, depth.frames[i].counts.input);
    EXPECT_EQ(decoder->counts().slices, depth.frames[i].slices.size());
  }
  ASSERT_EQ(decoder->set_key(raw.key), Status::kOk);
  EXPECT_TRUE(decoder->depth().empty());
  EXPECT_TRUE(decoder->labels().empty());
  for (std::size_t i = 0; i < raw.frames.size(); ++i) {
    decode_frame(*decoder, raw.frames[i]);
    EXPECT_TRUE(same_cloud(decoder->cloud(), raw.source.cloud(i)));
  }
}

TEST(Decoder, BeforeTheFirstKeyEverythingIsAnUnknownKey) {
  const Recording recording(kStreamCases[0]);
  const auto decoder = make_decoder(kSmall);
  EXPECT_FALSE(decoder->ready());
  EXPECT_EQ(decoder->begin(), Status::kUnknownKey);
  EXPECT_EQ(decoder->add(recording.frames[0].slices[0]), Status::kUnknownKey);
  EXPECT_EQ(decoder->finish(), Status::kUnknownKey);
  EXPECT_EQ(decoder->counts().refused, 1U);
  EXPECT_EQ(decoder->counts().unknown_key, 1U);
  EXPECT_TRUE(decoder->depth().empty());
  EXPECT_TRUE(decoder->cloud().empty());
  ASSERT_EQ(decoder->set_key(recording.key), Status::kOk);
  decode_frame(*decoder, recording.frames[0]);
  EXPECT_TRUE(std::ranges::equal(decoder->depth(), decoder_stream().frames[0]));
}

TEST(Decoder, RefusesStreamsLargerThanItsMemoryAndGoesOnWithTheOldOne) {
  const Recording recording(kStreamCases[0]);
  for (const FrameLimits limits : {FrameLimits{95, 72}, FrameLimits{96, 71}, FrameLimits{200, 71},
                                   FrameLimits{1, 1}, FrameLimits{0, 0}}) {
    const auto decoder = make_decoder({limits});
    EXPECT_EQ(decoder->set_key(recording.key), Status::kFrameTooLarge);
    EXPECT_FALSE(decoder->ready());
  }
  const auto decoder = make_decoder(kSmall);
  ASSERT_EQ(decoder->set_key(recording.key), Status::kOk);
  const auto large = make_encoder(encoder_config(sim_stream(104, 72, 1), kStreamCases[0]));
  EXPECT_EQ(decoder->set_key(key_of(*large)), Status::kFrameTooLarge);
  ASSERT_TRUE(decoder->ready());
  decode_frame(*decoder, recording.frames[1]);
  EXPECT_TRUE(std::ranges::equal(decoder->depth(), decoder_stream().frames[1]));
}

TEST(Decoder, FollowsAKeyThatChangesMidStreamAndCountsTheOldOnesSlices) {
  const Recording first(kStreamCases[0]), second(kStreamCases[2], 1190, 8);
  const auto decoder = make_decoder(kSmall);
  ASSERT_EQ(decoder->set_key(first.key), Status::kOk);
  decode_frame(*decoder, first.frames[0]);
  ASSERT_EQ(decoder->set_key(second.key), Status::kOk);
  EXPECT_EQ(decoder->config().tolerance, ToleranceKind::kSigma);
  ASSERT_EQ(decoder->begin(), Status::kOk);
  for (const auto& slice : first.frames[1].slices)
    EXPECT_EQ(decoder->add(slice), Status::kUnknownKey);
  EXPECT_EQ(decoder->finish(), Status::kOk);
  EXPECT_EQ(decoder->counts().unknown_key, first.frames[1].slices.size());
  EXPECT_EQ(decoder->counts().refused, first.frames[1].slices.size());
  EXPECT_EQ(std::ranges::count(decoder->depth(), 0), 96 * 72);
  decode_frame(*decoder, second.frames[1]);
  EXPECT_EQ(decoder->counts().points, second.frames[1].counts.kept);
  // And back, with nothing left over.
  ASSERT_EQ(decoder->set_key(first.key), Status::kOk);
  decode_frame(*decoder, first.frames[2]);
  EXPECT_TRUE(std::ranges::equal(decoder->depth(), decoder_stream().frames[2]));
}

TEST(Decoder, ARepeatedKeyInTheMiddleOfAFrameChangesNothing) {
  const Recording recording(kStreamCases[0], 300);
  const auto decoder = make_decoder(kSmall);
  ASSERT_EQ(decoder->set_key(recording.key), Status::kOk);
  ASSERT_EQ(decoder->begin(), Status::kOk);
  for (const auto& slice : recording.frames[0].slices) {
    EXPECT_EQ(decoder->add(slice), Status::kOk);
    EXPECT_EQ(decoder->set_key(recording.key), Status::kOk);
  }
  EXPECT_EQ(decoder->finish(), Status::kOk);
  EXPECT_TRUE(std::ranges::equal(decoder->depth(), decoder_stream().frames[0]));
}

class DecoderLoss : public testing::TestWithParam<StreamCase> {};
INSTANTIATE_TEST_SUITE_P(Kinds, DecoderLoss, testing::ValuesIn(kStreamCases),
                         [](const auto& param) { return std::string(param.param.name); });

// What arrives must be what a whole frame would have there; what does not arrive is a hole.
TEST_P(DecoderLoss, LeavesHolesAndNothingElseWhereSlicesAreMissing) {
  const bool raw = GetParam().kind == FrameKind::kRawCloud;
  const Recording recording(GetParam(), raw ? kMinRawSliceBytes : kMinSliceBytes);
  const auto whole = make_decoder(kSmall), partial = make_decoder(kSmall);
  ASSERT_EQ(whole->set_key(recording.key), Status::kOk);
  ASSERT_EQ(partial->set_key(recording.key), Status::kOk);
  for (const Coded& frame : recording.frames) {
    ASSERT_GT(frame.slices.size(), 1U);
    decode_frame(*whole, frame);
    ASSERT_EQ(partial->begin(), Status::kOk);
    std::vector<std::uint8_t> pixels(whole->cloud().size());
    for (std::size_t i = frame.slices.size(); i-- > 0;) {  // backwards: the order is free
      if (i % 3 != 1) ASSERT_EQ(partial->add(frame.slices[i]), Status::kOk);
    }
    ASSERT_EQ(partial->finish(), Status::kOk);
    EXPECT_LT(partial->counts().points, whole->counts().points);
    std::uint32_t present = 0;
    for (std::size_t i = 0; i < whole->cloud().size(); ++i) {
      const Point3f& p = partial->cloud()[i];
      const Point3f& expected = whole->cloud()[i];
      if (std::isnan(p.z)) continue;
      ++present;
      ASSERT_TRUE(p.x == expected.x && p.y == expected.y && p.z == expected.z) << i;
    }
    EXPECT_EQ(present, partial->counts().points);
  }
}

TEST(Decoder, DamagedAndForeignPacketsAreCountedAndTheOthersGoOn) {
  const Recording recording(kStreamCases[0], 300);
  const auto decoder = make_decoder(kSmall);
  ASSERT_EQ(decoder->set_key(recording.key), Status::kOk);
  const auto& slices = recording.frames[0].slices;
  ASSERT_EQ(decoder->begin(), Status::kOk);
  auto damaged = slices[0];
  damaged.back() ^= 1U;
  EXPECT_EQ(decoder->add(damaged), Status::kBadCheck);
  EXPECT_EQ(decoder->add(std::span(slices[0]).first(10)), Status::kTruncated);
  EXPECT_EQ(decoder->add({}), Status::kTruncated);
  EXPECT_EQ(decoder->add(recording.key), Status::kFieldRange);
  EXPECT_EQ(decoder->counts().refused, 4U);
  EXPECT_EQ(decoder->counts().unknown_key, 0U);
  for (const auto& slice : slices) EXPECT_EQ(decoder->add(slice), Status::kOk);
  EXPECT_EQ(decoder->finish(), Status::kOk);
  EXPECT_EQ(decoder->counts().slices, slices.size());
  EXPECT_TRUE(std::ranges::equal(decoder->depth(), decoder_stream().frames[0]));
}

TEST(Decoder, KeysThatAreNoneAreRefusedAndTheStreamGoesOn) {
  const Recording recording(kStreamCases[0]);
  const auto decoder = make_decoder(kSmall);
  ASSERT_EQ(decoder->set_key(recording.key), Status::kOk);
  EXPECT_EQ(decoder->set_key(recording.frames[0].slices[0]), Status::kFieldRange);
  auto damaged = recording.key;
  damaged[40] ^= 1U;
  EXPECT_EQ(decoder->set_key(damaged), Status::kBadCheck);
  PacketHeader header;
  ASSERT_EQ(open_packet(recording.key, header), Status::kOk);
  header.key_hash ^= 1U;  // a good check over a hash that is not the body's
  auto lying = recording.key;
  seal_packet(header, lying);
  EXPECT_EQ(decoder->set_key(lying), Status::kBadCheck);
  decode_frame(*decoder, recording.frames[3]);
  EXPECT_TRUE(std::ranges::equal(decoder->depth(), decoder_stream().frames[3]));
}

TEST(Decoder, AFrameOfHolesAndAFrameOfOnePixelAreFrames) {
  SimStream tiny = decoder_stream();
  tiny.config.camera.width = tiny.config.camera.height = 1;
  for (const StreamCase& c : kStreamCases) {
    const auto encoder = make_encoder(encoder_config(tiny, c));
    const auto decoder = make_decoder({{1, 1}});
    ASSERT_EQ(decoder->set_key(key_of(*encoder)), Status::kOk);
    for (const std::uint16_t depth : std::initializer_list<std::uint16_t>{0, 1, 1500, 65535}) {
      const std::vector<std::uint16_t> pixel{depth};
      const Status status = c.kind == FrameKind::kDepth
                                ? encoder->submit(DepthView{pixel})
                                : encoder->submit(raw_points(tiny.config.camera, pixel), 0, 0);
      ASSERT_EQ(status, Status::kOk);
      const auto coded = take_all(*encoder);
      ASSERT_EQ(coded.size(), 1U);
      ASSERT_EQ(coded[0].status, Status::kOk) << c.name;
      ASSERT_GE(coded[0].slices.size(), 1U);
      decode_frame(*decoder, coded[0]);
      const bool kept = depth != 0 && !c.drop;
      EXPECT_EQ(decoder->counts().points, kept ? 1U : 0U) << c.name << " " << depth;
      if (c.tolerance == ToleranceKind::kLossless && c.kind == FrameKind::kDepth) {
        EXPECT_EQ(decoder->depth()[0], depth);
      }
    }
  }
}

using Slices = std::vector<std::vector<std::uint8_t>>;

SliceList list_of(const Slices& slices) {
  return {&slices, static_cast<std::uint32_t>(slices.size()),
          [](const void* self, std::uint32_t i) noexcept {
            return std::span<const std::uint8_t>((*static_cast<const Slices*>(self))[i]);
          }};
}

/// Both decode the same slices, one by one and by a team: nothing may tell them apart.
void expect_same(Decoder& alone, Decoder& shared, const Slices& slices, const char* what) {
  ASSERT_EQ(alone.begin(), Status::kOk);
  ASSERT_EQ(shared.begin(), Status::kOk);
  Status first = Status::kOk;
  for (const auto& slice : slices) {
    const Status status = slice.empty() ? Status::kOk : alone.add(slice);
    if (first == Status::kOk) first = status;
  }
  EXPECT_EQ(shared.add_all(list_of(slices)), first) << what;
  EXPECT_EQ(alone.finish(), Status::kOk);
  EXPECT_EQ(shared.finish(), Status::kOk);
  EXPECT_TRUE(std::ranges::equal(alone.depth(), shared.depth())) << what;
  EXPECT_TRUE(std::ranges::equal(alone.labels(), shared.labels())) << what;
  EXPECT_TRUE(same_cloud(alone.cloud(), shared.cloud())) << what;
  const DecodedCounts &a = alone.counts(), &b = shared.counts();
  EXPECT_EQ(a.slices, b.slices) << what;
  EXPECT_EQ(a.refused, b.refused) << what;
  EXPECT_EQ(a.unknown_key, b.unknown_key) << what;
  EXPECT_EQ(a.points, b.points) << what;
  EXPECT_EQ(a.corrections, b.corrections) << what;
  EXPECT_EQ(a.surfaces, b.surfaces) << what;
}

TEST(Decoder, ATeamDecodesAsOneThreadDoesWhateverComes) {
  FrameTeam team;
  ASSERT_EQ(team.start({.name = "unpack2"}), 0);
  for (const StreamCase& c : kStreamCases) {
    const std::size_t most = c.kind == FrameKind::kRawCloud ? 1190 : 300;
    const Recording recording(c, most), foreign(c, most, 8);
    const auto alone = make_decoder(kSmall);
    const auto shared = make_decoder({kSmall.limits, team.work()});
    ASSERT_EQ(alone->set_key(recording.key), Status::kOk);
    ASSERT_EQ(shared->set_key(recording.key), Status::kOk);
    for (const Coded& frame : std::span(recording.frames).first(kSanitized ? 2 : 6)) {
      expect_same(*alone, *shared, frame.slices, c.name);
      Slices changed = frame.slices;
      changed[changed.size() / 2].clear();
      expect_same(*alone, *shared, changed, "a slice is lost");
      changed = frame.slices;
      changed.push_back(changed.front());
      expect_same(*alone, *shared, changed, "two claim the same pixels");
      changed = frame.slices;
      changed[changed.size() / 2].back() ^= 1U;
      expect_same(*alone, *shared, changed, "a slice is spoilt");
      changed.insert(changed.begin(), foreign.frames[0].slices[0]);
      expect_same(*alone, *shared, changed, "a slice needs another key");
    }
  }
}

}  // namespace
}  // namespace planecast
