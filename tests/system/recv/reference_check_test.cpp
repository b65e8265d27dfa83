// The check of received frames must hold for what the codec promises, and must not for anything
// less.
#include "apps/common/reference_check.hpp"

#include "core/io/depth_png.hpp"
#include "core/io/ply.hpp"
#include "tests/system/recv/own_folder.hpp"
#include "tests/system/recv/small_stream.hpp"

namespace planecast {
namespace {

using test::decode;
using test::OwnFolder;
using test::SmallStream;
using test::wall_frame;
using test::wall_options;

constexpr std::uint64_t kFrames = 3;

/// The wall as a folder of PNG files, and the reference that loads it.
ReferenceCheck load_wall(const std::string& tolerance, bool given) {
  const OwnFolder folder;
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    const auto done = write_depth_png(folder / (std::to_string(i) + ".png"), wall_frame(i).depth);
    EXPECT_TRUE(done.ok());
  }
  CodecOptions options = wall_options(tolerance);
  if (given) options.given.insert("tolerance");
  auto loaded = ReferenceCheck::load(folder.text(), options);
  EXPECT_TRUE(loaded.ok()) << loaded.error().message;
  return std::move(*loaded);
}

using test::list_frame;

/// Lists of points as PLY files, the last of them of fewer, and the reference that loads them.
ReferenceCheck load_lists(const CodecOptions& options) {
  const OwnFolder folder;
  for (std::uint64_t i = 0; i < kFrames; ++i) {
    const auto done = write_ply(folder / (std::to_string(i) + ".ply"),
                                list_frame(i, i + 1 < kFrames ? 1500 : 1000).cloud);
    EXPECT_TRUE(done.ok());
  }
  auto loaded = ReferenceCheck::load(folder.text(), options);
  EXPECT_TRUE(loaded.ok()) << loaded.error().message;
  return std::move(*loaded);
}

/// Codes list `number` and compares it with the reference's `against`.
FrameCheck check_list(const ReferenceCheck& reference, const CodecOptions& options,
                      std::uint64_t number, std::uint64_t against) {
  test::SmallStream stream(options, list_frame(0));
  const auto decoder = test::list_decoder(stream);
  decode(*decoder, stream, list_frame(number));
  return reference.check(against, *decoder);
}

/// Codes frame `number` at `tolerance` and compares it with the reference's frame `against`.
FrameCheck check(const ReferenceCheck& reference, const std::string& tolerance,
                 std::uint64_t number, std::uint64_t against) {
  SmallStream stream(tolerance);
  auto decoder = std::move(Decoder::create({{test::kWidth, test::kHeight}}).value());
  decode(*decoder, stream, wall_frame(number));
  return reference.check(against, *decoder);
}

}  // namespace

TEST(ReferenceCheck, HoldsAtEveryToleranceAndUsesTheBound) {
  for (const char* tolerance : {"5mm", "2sigma", "surfaces:3"}) {
    const ReferenceCheck reference = load_wall(tolerance, true);
    ASSERT_EQ(reference.frames(), kFrames);
    const FrameCheck found = check(reference, tolerance, 1, 1);
    EXPECT_TRUE(found.holds()) << tolerance << " " << found.max_ratio;
    EXPECT_GT(found.max_ratio, 0.3) << tolerance;
    EXPECT_GT(found.expected, test::kWidth * test::kHeight * 9 / 10) << tolerance;
  }
}

TEST(ReferenceCheck, LosslessMeansEqual) {
  const ReferenceCheck reference = load_wall("0", true);
  const FrameCheck found = check(reference, "0", 2, 2);
  EXPECT_TRUE(found.holds());
  EXPECT_EQ(found.max_ratio, 0.0);
  EXPECT_LT(found.max_error_m, 1e-6);  // float32 of the coordinates
  EXPECT_FALSE(check(reference, "5mm", 2, 2).holds());
}

TEST(ReferenceCheck, FrameNumbersCountModuloTheInput) {
  const ReferenceCheck reference = load_wall("5mm", true);
  EXPECT_TRUE(check(reference, "5mm", 1, 1 + 4 * kFrames).holds());
}

TEST(ReferenceCheck, AnotherFrameIsNotTheOriginal) {
  const ReferenceCheck reference = load_wall("5mm", true);
  const FrameCheck found = check(reference, "5mm", 1, 2);
  EXPECT_FALSE(found.holds());
  EXPECT_GT(found.missing, 0U);
  EXPECT_GT(found.invented, 0U);
}

TEST(ReferenceCheck, TheStreamsOwnBoundHoldsWhereNoneIsGiven) {
  const ReferenceCheck told = load_wall("1mm", true);
  const ReferenceCheck untold = load_wall("1mm", false);
  EXPECT_GT(check(told, "10mm", 0, 0).max_ratio, 1.0);
  EXPECT_LE(check(untold, "10mm", 0, 0).max_ratio, 1.0);
}

TEST(ReferenceCheck, ListsHoldAtEveryToleranceAndUseTheBound) {
  for (const char* tolerance : {"0", "5mm", "2sigma", "surfaces"}) {
    const CodecOptions options = test::list_options(tolerance);
    const ReferenceCheck reference = load_lists(options);
    const FrameCheck found = check_list(reference, options, 1, 1);
    EXPECT_TRUE(found.holds()) << tolerance << " " << found.max_ratio;
    EXPECT_EQ(found.expected, 1500U) << tolerance;
    EXPECT_EQ(found.dropped, 0U) << tolerance;
    const bool bounded = tolerance[0] == '5' || tolerance[0] == '2';
    EXPECT_EQ(found.max_ratio > 0.3, bounded) << tolerance << " " << found.max_ratio;
  }
}

TEST(ReferenceCheck, AnotherListIsNotTheOriginal) {
  for (const char* tolerance : {"0", "5mm"}) {
    const CodecOptions options = test::list_options(tolerance);
    const ReferenceCheck reference = load_lists(options);
    EXPECT_GT(check_list(reference, options, 1, 0).max_ratio, 1.0) << tolerance;
    const FrameCheck more = check_list(reference, options, 1, 2);
    EXPECT_FALSE(more.holds());
    EXPECT_EQ(more.invented, 500U) << tolerance;
  }
}

TEST(ReferenceCheck, PointsThatAListMayDropAreCountedAsDropped) {
  CodecOptions options = test::list_options("surfaces");
  options.off_surface = OffSurface::kDrop;
  const ReferenceCheck reference = load_lists(options);
  const FrameCheck found = check_list(reference, options, 1, 1);
  EXPECT_TRUE(found.holds());
  EXPECT_GT(found.dropped, 50U);
  EXPECT_EQ(found.missing, 0U);
}

TEST(ReferenceCheck, AStreamOfAnotherSizeIsNotComparable) {
  const ReferenceCheck reference = load_wall("5mm", true);
  auto decoder = std::move(Decoder::create({{640, 480}}).value());
  EXPECT_FALSE(reference.check(0, *decoder).comparable);  // no key packet yet
  SmallStream stream("5mm");
  stream.setup.encoder.stream.camera.unit_pm *= 2;
  stream.codec = std::move(FrameCodec::create(stream.setup, 1190).value());
  decode(*decoder, stream, wall_frame(0));
  EXPECT_FALSE(reference.check(0, *decoder).comparable);
}

}  // namespace planecast
