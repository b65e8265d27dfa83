// What the receiver makes of frames beside the decoder: options, file names, hand-over, pictures.
#include <gtest/gtest.h>

#include <cstring>
#include <thread>

#include "apps/recv/caption.hpp"
#include "apps/recv/frame_file.hpp"
#include "apps/recv/recv_options.hpp"
#include "apps/recv/result_picture.hpp"
#include "apps/recv/sink_queue.hpp"
#include "core/io/depth_png.hpp"
#include "core/io/ply.hpp"
#include "core/io/point_file.hpp"
#include "tests/system/recv/own_folder.hpp"
#include "tests/system/recv/small_stream.hpp"

namespace planecast {
namespace {

using test::OwnFolder;

SinkFrame named(const char* frame_id) {
  SinkFrame frame;
  std::strncpy(frame.config.frame_id.data(), frame_id, kMaxFrameIdBytes);
  frame.frame = 12;
  frame.complete = true;
  return frame;
}

}  // namespace

TEST(RecvOptions, ContradictionsAreRefusedBeforeAnythingIsOpened) {
  RecvOptions options;
  EXPECT_TRUE(check_recv_options(options).ok());
  options.full_cloud = true;
  EXPECT_FALSE(check_recv_options(options).ok());
  options = {};
  options.last_file = "frame.tiff";
  EXPECT_NE(check_recv_options(options).error().message.find(".ply"), std::string::npos);
  options = {};
  options.picture_file = "picture.jpg";
  EXPECT_FALSE(check_recv_options(options).ok());
}

TEST(RecvOptions, AnyFrameOfTheLargestSizeFitsTheAssembler) {
  for (const ImageSize size : {ImageSize{1, 1}, ImageSize{640, 480}, ImageSize{4096, 4096}}) {
    RecvOptions options;
    options.max_size = size;
    const SubscriberConfig config = subscriber_for(options, {});
    EXPECT_GE(config.assembly.max_frame_bytes, 2U * size.width * size.height);
    EXPECT_EQ(config.assembly.output_frames, 1U);
    options.frames = 10;
    EXPECT_EQ(subscriber_for(options, {}).assembly.output_frames, 8U);
    options.streams = 1;
    EXPECT_EQ(subscriber_for(options, {}).assembly.output_frames, 32U);
  }
}

TEST(FrameFile, NamesTellStreamSenderAndNumber) {
  SinkFrame frame = named("camera");
  EXPECT_EQ(frame_file_name(frame, FrameFormat::kPly), "camera-000012.ply");
  frame.stream = 3;
  frame.sender = 2;
  frame.complete = false;
  EXPECT_EQ(frame_file_name(frame, FrameFormat::kPng), "camera_3.2-000012.partial.png");
}

TEST(FrameFile, NamesFromTheNetworkStayInTheFolder) {
  EXPECT_EQ(frame_file_name(named("../../etc/x y"), FrameFormat::kPcd), "_._.._etc_x_y-000012.pcd");
  EXPECT_EQ(frame_file_name(named(""), FrameFormat::kBin), "stream-000012.bin");
}

TEST(SinkQueue, CarriesCopiesAndDropsWhenFull) {
  test::SmallStream stream("0");
  auto decoder = std::move(Decoder::create({{test::kWidth, test::kHeight}}).value());
  test::decode(*decoder, stream, test::wall_frame(0));
  auto queue = std::move(SinkQueue::create(2, test::kWidth * test::kHeight).value());
  SinkFrame who;
  who.frame = 1;
  EXPECT_TRUE(queue->offer(*decoder, who));
  who.frame = 2;
  EXPECT_TRUE(queue->offer(*decoder, who));
  EXPECT_FALSE(queue->offer(*decoder, who)) << "both slots are taken";
  const SinkFrame* first = queue->take();
  ASSERT_NE(first, nullptr);
  EXPECT_EQ(first->frame, 1U);
  const auto depth = decoder->depth();
  EXPECT_TRUE(std::equal(depth.begin(), depth.end(), first->depth.begin()));
  queue->release(first);
  who.frame = 3;
  EXPECT_TRUE(queue->offer(*decoder, who));
  queue->close();
  EXPECT_EQ(queue->take()->frame, 2U);
  EXPECT_EQ(queue->take()->frame, 3U);
  EXPECT_EQ(queue->take(), nullptr);
}

TEST(FrameFile, WhatIsWrittenReadsBack) {
  test::SmallStream stream("0");
  auto decoder = std::move(Decoder::create({{test::kWidth, test::kHeight}}).value());
  const SensorFrame original = test::wall_frame(0);
  test::decode(*decoder, stream, original);
  auto queue = std::move(SinkQueue::create(1, test::kWidth * test::kHeight).value());
  ASSERT_TRUE(queue->offer(*decoder, {}));
  const SinkFrame* frame = queue->take();
  const OwnFolder folder;
  ASSERT_TRUE(write_frame(*frame, FrameFormat::kPng, folder / "a.png").ok());
  EXPECT_EQ(read_depth_png(folder / "a.png")->depth, original.depth.depth);
  ASSERT_TRUE(write_frame(*frame, FrameFormat::kPly, folder / "a.ply").ok());
  const auto& depth = original.depth.depth;
  EXPECT_EQ(read_ply(folder / "a.ply")->points.size(),
            depth.size() - static_cast<std::size_t>(std::count(depth.begin(), depth.end(), 0)));
  EXPECT_FALSE(write_frame(*frame, FrameFormat::kPcd, folder / "none" + "/a.pcd").ok());
}

TEST(FrameFile, ListsGoThroughTheQueueAndReadBackWithTheirZero) {
  const CodecOptions options = test::list_options("0");
  SensorFrame original = test::list_frame(0);
  original.cloud.origin_x = 4e5;
  test::SmallStream stream(options, original);
  const auto decoder = test::list_decoder(stream);
  test::decode(*decoder, stream, original);
  auto queue = std::move(SinkQueue::create(1, 2000).value());
  ASSERT_TRUE(queue->offer(*decoder, {}));
  const SinkFrame* frame = queue->take();
  ASSERT_TRUE(frame->list());
  EXPECT_EQ(frame->pixels, 1500U);
  const OwnFolder folder;
  for (const FrameFormat format : {FrameFormat::kPly, FrameFormat::kPcd}) {
    const auto path = folder / ("a." + std::string(extension(format)));
    ASSERT_TRUE(write_frame(*frame, format, path).ok());
    const auto back = read_point_file(path);
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->points.size(), 1500U);
    double sum = 0;
    for (const Point3f& p : back->points) sum += back->origin_x + p.x - 4e5;
    EXPECT_NEAR(sum / 1500, 1, 0.05);
  }
  EXPECT_FALSE(write_frame(*frame, FrameFormat::kPng, folder / "a.png").ok());
}

TEST(SinkQueue, AListLargerThanItsSlotsIsNotTaken) {
  const CodecOptions options = test::list_options("5mm");
  test::SmallStream stream(options, test::list_frame(0));
  const auto decoder = test::list_decoder(stream);
  test::decode(*decoder, stream, test::list_frame(0));
  auto queue = std::move(SinkQueue::create(1, 1000).value());
  EXPECT_FALSE(queue->offer(*decoder, {}));
}

TEST(ResultPicture, SameDepthIsTheSameColourAndLabelsDiffer) {
  ResultViews views;
  views.width = 64;
  views.height = 32;
  std::vector<float> z_m(64 * 32);
  std::vector<std::uint8_t> labels(z_m.size());
  for (std::size_t i = 0; i < z_m.size(); ++i) {
    z_m[i] = i % 64 < 4 ? 0.0F : 1.0F + static_cast<float>(i % 64) * 0.05F;
    labels[i] = static_cast<std::uint8_t>(i / 64 < 16 ? 1 : 2);
  }
  views.original = z_m;
  views.regenerated = z_m;
  views.labels = labels;
  const Picture picture = draw_result(views);
  ASSERT_EQ(picture.width, 3 * 64 + 2 * 2U);
  const std::uint32_t top = picture.height - 32 - text_height(1) - 12;  // first row of the images
  for (std::uint32_t x = 0; x < 64; ++x)
    EXPECT_EQ(picture.at(x, top + 5), picture.at(x + 2 * 66, top + 5)) << x;
  EXPECT_EQ(picture.at(0, top + 5), Rgb{}) << "a hole is black";
  EXPECT_EQ(picture.at(66, top + 5), Rgb{}) << "a hole has no label";
  EXPECT_FALSE(picture.at(66 + 20, top + 5) == picture.at(66 + 20, top + 25));
}

TEST(Caption, WordsLeaveInkAndStayInside) {
  Picture picture(20, 8);
  draw_text(picture, 0, 0, 1, {255, 255, 255},
            "A\x01"
            "~too long for it");
  std::size_t ink = 0;
  for (const std::uint8_t byte : picture.rgb) ink += byte != 0;
  EXPECT_GT(ink, 3 * 10U);
  EXPECT_EQ(text_width("abc", 2), 36U);
}

}  // namespace planecast
