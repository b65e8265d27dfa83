#include "apps/planecastd/frame_feed.hpp"

#include <gtest/gtest.h>

#include <string>
#include <vector>

namespace planecast {
namespace {

/// Frames of 4 x 2 whose first count is 1000 + their number; one may have another size.
class FewFrames : public FrameSource {
 public:
  explicit FewFrames(std::uint64_t frames, std::uint64_t odd = 99) : frames_(frames), odd_(odd) {}
  Result<bool> next(SensorFrame& frame) override {
    if (at_ == frames_) return false;
    frame = {};
    frame.name = "frame" + std::to_string(at_);
    frame.depth = {4, 2, std::vector<std::uint16_t>(8, 500)};
    frame.depth.depth[0] = static_cast<std::uint16_t>(1000 + at_);
    if (at_ == odd_) frame.depth = {2, 2, std::vector<std::uint16_t>(4, 500)};
    ++at_;
    return true;
  }
  void rewind() override { at_ = 0; }
  std::optional<std::uint64_t> count() const override { return frames_; }

 private:
  std::uint64_t frames_, odd_;
  std::uint64_t at_ = 0;
};

StreamSetup small_setup() {
  StreamSetup setup;
  Intrinsics intrinsics;
  intrinsics.fx = intrinsics.fy = 4;
  setup.encoder.stream.camera = quantise(intrinsics, 4, 2).value();
  return setup;
}

SensorFrame first_of(FrameSource& source) {
  SensorFrame frame;
  EXPECT_TRUE(source.next(frame).value());
  return frame;
}

/// Numbers of the frames that come, up to `most`.
std::vector<int> played(FrameFeed& feed, std::size_t most = 100) {
  std::vector<int> numbers;
  FeedFrame frame;
  while (numbers.size() < most && feed.next(frame).value()) {
    EXPECT_EQ(frame.depth.size(), 8U);
    numbers.push_back(frame.depth[0] - 1000);
  }
  return numbers;
}

using Numbers = std::vector<int>;
const auto kNever = [] { return false; };

/// Memory for `frames` frames of 4 x 2.
struct Places {
  explicit Places(std::size_t frames) : bytes(frames * 64) {
    for (std::size_t i = 0; i < frames; ++i)
      places.push_back(std::span<std::byte>(bytes).subspan(i * 64, 48));
  }
  std::vector<std::byte> bytes;
  std::vector<std::span<std::byte>> places;
};

}  // namespace

TEST(FrameFeed, PlaysEveryFrameOnceFromTheFirstOn) {
  FewFrames source(3);
  const StreamSetup setup = small_setup();
  FrameFeed feed(source, setup, first_of(source), {});
  EXPECT_EQ(played(feed), (Numbers{0, 1, 2}));
}

TEST(FrameFeed, RepeatsFromMemoryAndFromTheSourceAlike) {
  const StreamSetup setup = small_setup();
  for (const bool preload : {false, true}) {
    FewFrames source(3);
    FrameFeed feed(source, setup, first_of(source), {.repeat = 2});
    Places memory(preload ? 3 : 0);
    ASSERT_TRUE(feed.preload(memory.places, kNever).ok());
    EXPECT_EQ(played(feed), (Numbers{0, 1, 2, 0, 1, 2}));
  }
}

TEST(FrameFeed, RepeatZeroGoesOn) {
  const StreamSetup setup = small_setup();
  for (const bool preload : {false, true}) {
    FewFrames source(2);
    FrameFeed feed(source, setup, first_of(source), {.repeat = 0});
    Places memory(preload ? 2 : 0);
    ASSERT_TRUE(feed.preload(memory.places, kNever).ok());
    EXPECT_EQ(played(feed, 7), (Numbers{0, 1, 0, 1, 0, 1, 0}));
  }
}

TEST(FrameFeed, FileOfAnotherSizeIsAnErrorThatNamesIt) {
  FewFrames source(3, 1);
  const StreamSetup setup = small_setup();
  FrameFeed feed(source, setup, first_of(source), {});
  FeedFrame frame;
  ASSERT_TRUE(feed.next(frame).value());
  const auto got = feed.next(frame);
  ASSERT_FALSE(got.ok());
  EXPECT_NE(got.error().message.find("frame1"), std::string::npos) << got.error().message;
}

TEST(FrameFeed, LiveFrameOfAnotherSizeIsCountedAndPassed) {
  FewFrames source(4, 1);
  const StreamSetup setup = small_setup();
  FrameFeed feed(source, setup, first_of(source), {.repeat = 0, .live = true});
  EXPECT_EQ(played(feed), (Numbers{0, 2, 3})) << "a live source that ends, ends";
  EXPECT_EQ(feed.refused(), 1U);
  EXPECT_NE(feed.refusal().find("frame1"), std::string::npos);
}

/// Lists of 3 points, the second of 5.
class FewLists : public FrameSource {
 public:
  Result<bool> next(SensorFrame& frame) override {
    if (at_ == 3) return false;
    frame = {};
    frame.name = "list" + std::to_string(at_);
    const std::uint32_t points = at_ == 1 ? 5 : 3;
    frame.cloud.width = points;
    frame.cloud.height = 1;
    frame.cloud.points.assign(points, {static_cast<float>(at_), 1, 2});
    ++at_;
    return true;
  }
  void rewind() override { at_ = 0; }
  std::optional<std::uint64_t> count() const override { return 3; }

 private:
  std::uint64_t at_ = 0;
};

TEST(FrameFeed, AListTooLargeIsRefusedCountedAndNamesTheFigureThatWouldFit) {
  StreamSetup setup;
  setup.cloud_input = true;
  setup.encoder.stream.kind = FrameKind::kPoints;
  setup.encoder.stream.points.max_points = 4;
  for (const bool preload : {false, true}) {
    FewLists source;
    FrameFeed feed(source, setup, first_of(source), {.repeat = 2});
    Places memory(preload ? 3 : 0);
    ASSERT_TRUE(feed.preload(memory.places, kNever).ok());
    std::vector<float> numbers;
    FeedFrame frame;
    while (feed.next(frame).value()) {
      ASSERT_EQ(frame.points.size(), 3U);
      numbers.push_back(frame.points[0].x);
    }
    EXPECT_EQ(numbers, (std::vector<float>{0, 2, 0, 2})) << preload;
    EXPECT_EQ(feed.refused(), preload ? 1U : 2U);
    EXPECT_NE(feed.refusal().find("list1: has 5 points"), std::string::npos) << feed.refusal();
    EXPECT_NE(feed.refusal().find("--max-points 5"), std::string::npos) << feed.refusal();
  }
}

TEST(FrameFeed, PreloadingStopsWhenAsked) {
  FewFrames source(3);
  const StreamSetup setup = small_setup();
  FrameFeed feed(source, setup, first_of(source), {});
  Places memory(3);
  int asked = 0;
  const auto done = feed.preload(memory.places, [&asked] { return ++asked == 2; });
  ASSERT_FALSE(done.ok());
  EXPECT_EQ(done.error().status, Status::kStopped);
}

}  // namespace planecast
