#include "core/io/depth_png.hpp"

#include <gtest/gtest.h>
#include <spng.h>

#include <memory>

#include "tests/core/io/io_test_support.hpp"

namespace planecast {
namespace {

using test::TempFolder;

DepthImage random_image(std::uint32_t width, std::uint32_t height, std::uint64_t seed) {
  Pcg32 random(seed);
  DepthImage image{width, height, {}};
  for (std::uint64_t i = 0; i < std::uint64_t{width} * height; ++i) {
    image.depth.push_back(static_cast<std::uint16_t>(random.next()));
  }
  return image;
}

// A PNG of any kind, made by libspng itself.
std::string png_of(std::uint8_t bit_depth, std::uint8_t color_type, std::size_t row_bytes,
                   std::uint8_t interlace = 0) {
  const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> context(spng_ctx_new(SPNG_CTX_ENCODER),
                                                                    &spng_ctx_free);
  spng_ihdr header{};
  header.width = 8;
  header.height = 8;
  header.bit_depth = bit_depth;
  header.color_type = color_type;
  header.interlace_method = interlace;
  spng_plte palette{};
  palette.n_entries = 256;
  spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
  EXPECT_EQ(spng_set_ihdr(context.get(), &header), 0);
  if (color_type == SPNG_COLOR_TYPE_INDEXED) {
    EXPECT_EQ(spng_set_plte(context.get(), &palette), 0);
  }
  const std::vector<std::uint8_t> pixels(row_bytes * 8, 1);
  EXPECT_EQ(spng_encode_image(context.get(), pixels.data(), pixels.size(), SPNG_FMT_PNG,
                              SPNG_ENCODE_FINALIZE),
            0);
  std::size_t length = 0;
  int code = 0;
  const std::unique_ptr<void, decltype(&std::free)> buffer(
      spng_get_png_buffer(context.get(), &length, &code), &std::free);
  EXPECT_EQ(code, 0);
  return {static_cast<const char*>(buffer.get()), length};
}

TEST(DepthPng, RoundTripsEveryValueAndShape) {
  const TempFolder folder;
  for (const auto& [width, height] : {std::pair{1U, 1U}, {7U, 3U}, {640U, 2U}, {1U, 300U}}) {
    DepthImage image = random_image(width, height, width);
    image.depth.front() = 65535;
    image.depth.back() = 0;
    const auto written = write_depth_png(folder / "a.png", image);
    ASSERT_TRUE(written.ok()) << written.error().message;
    const auto read = read_depth_png(folder / "a.png");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->width, width);
    EXPECT_EQ(read->height, height);
    EXPECT_EQ(read->depth, image.depth);
  }
}

TEST(DepthPng, StoresTheHighByteFirstAsPngDemands) {
  const TempFolder folder;
  ASSERT_TRUE(write_depth_png(folder / "a.png", {1, 1, {0x1234}}).ok());
  const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> context(spng_ctx_new(0),
                                                                    &spng_ctx_free);
  const std::string content = test::file_content(folder / "a.png");
  ASSERT_EQ(spng_set_png_buffer(context.get(), content.data(), content.size()), 0);
  std::uint8_t raw[2] = {};
  ASSERT_EQ(spng_decode_image(context.get(), raw, 2, SPNG_FMT_RAW, 0), 0);
  EXPECT_EQ(raw[0], 0x12);
  EXPECT_EQ(raw[1], 0x34);
}

TEST(DepthPng, OtherKindsAreRefusedByName) {
  const TempFolder folder;
  const auto expect = [&folder](const std::string& content, const std::string& message) {
    const auto path = folder.file("a.png", content);
    EXPECT_REFUSED(read_depth_png(path), path, message);
  };
  EXPECT_TRUE(read_depth_png(folder.file("g.png", png_of(16, SPNG_COLOR_TYPE_GRAYSCALE, 16))).ok());
  expect(png_of(8, SPNG_COLOR_TYPE_GRAYSCALE, 8), "8-bit grey,");
  expect(png_of(1, SPNG_COLOR_TYPE_GRAYSCALE, 1), "1-bit grey,");
  expect(png_of(8, SPNG_COLOR_TYPE_TRUECOLOR, 24), "8-bit RGB,");
  expect(png_of(16, SPNG_COLOR_TYPE_TRUECOLOR, 48), "16-bit RGB,");
  expect(png_of(8, SPNG_COLOR_TYPE_INDEXED, 8), "8-bit palette,");
  expect(png_of(16, SPNG_COLOR_TYPE_GRAYSCALE_ALPHA, 32), "16-bit grey with alpha,");
  expect(png_of(8, SPNG_COLOR_TYPE_TRUECOLOR_ALPHA, 32), "8-bit RGB with alpha,");
  expect("", "signature");
  expect("not a PNG at all, just text of some length", "signature");
}

TEST(DepthPng, ZeroAndHugeSidesAreRefusedBeforeMemoryIsTaken) {
  const TempFolder folder;
  const std::string good = png_of(16, SPNG_COLOR_TYPE_GRAYSCALE, 16);
  for (const std::size_t at : {16U, 20U}) {
    for (const auto& [side, message] : {std::pair{std::string("\0\0\0\0", 4), "0"},
                                        {std::string("\0\0\x40\x01", 4), "16385"},
                                        {std::string("\xFF\xFF\xFF\xFF", 4), "4294967295"}}) {
      std::string content = good;
      content.replace(at, 4, side);
      const auto path = folder.file("a.png", content);
      EXPECT_REFUSED(read_depth_png(path), path, message);
      EXPECT_REFUSED(read_depth_png(path), path, "pixels");
    }
  }
  std::string bomb = good;
  bomb.replace(16, 8, std::string("\0\0\x40\0\0\0\x40\0", 8));
  const auto path = folder.file("a.png", bomb);
  EXPECT_REFUSED(read_depth_png(path), path, "too short for 16384 x 16384");
}

TEST(DepthPng, EveryTruncationIsAnError) {
  const TempFolder folder;
  ASSERT_TRUE(write_depth_png(folder / "a.png", random_image(5, 4, 3)).ok());
  test::for_every_truncation(folder, "cut.png", test::file_content(folder / "a.png"),
                             [](const std::filesystem::path& path, std::size_t length) {
                               SCOPED_TRACE(length);
                               EXPECT_REFUSED(read_depth_png(path), path, "byte");
                             });
}

TEST(DepthPng, EveryFlippedBitIsAnError) {
  const TempFolder folder;
  ASSERT_TRUE(write_depth_png(folder / "a.png", random_image(5, 4, 3)).ok());
  const std::string content = test::file_content(folder / "a.png");
  for (std::size_t bit = 0; bit < content.size() * 8; ++bit) {
    SCOPED_TRACE(bit);
    std::string changed = content;
    changed[bit / 8] = static_cast<char>(changed[bit / 8] ^ (1 << (bit % 8)));
    const auto path = folder.file("a.png", changed);
    EXPECT_REFUSED(read_depth_png(path), path, "byte");
  }
}

TEST(DepthPng, RefusesToWriteWhatIsNotAnImage) {
  const TempFolder folder;
  for (const DepthImage& image :
       {DepthImage{}, DepthImage{2, 2, {1, 2, 3}}, DepthImage{0, 5, {}}}) {
    const auto written = write_depth_png(folder / "a.png", image);
    ASSERT_FALSE(written.ok());
    EXPECT_EQ(written.error().status, Status::kUsage);
  }
  const auto written = write_depth_png(folder / "none/a.png", random_image(2, 2, 1));
  ASSERT_FALSE(written.ok());
  EXPECT_EQ(written.error().status, Status::kWriteFailed);
}

TEST(RgbPng, RoundTripsThroughLibspng) {
  const TempFolder folder;
  const std::vector<std::uint8_t> rgb = {255, 0, 0, 0, 255, 0, 1, 2, 3, 4, 5, 6};
  ASSERT_TRUE(write_rgb_png(folder / "a.png", 2, 2, rgb).ok());
  const std::string content = test::file_content(folder / "a.png");
  const std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)> context(spng_ctx_new(0),
                                                                    &spng_ctx_free);
  ASSERT_EQ(spng_set_png_buffer(context.get(), content.data(), content.size()), 0);
  std::vector<std::uint8_t> read(12);
  ASSERT_EQ(spng_decode_image(context.get(), read.data(), read.size(), SPNG_FMT_RGB8, 0), 0);
  EXPECT_EQ(read, rgb);
  EXPECT_FALSE(write_rgb_png(folder / "a.png", 2, 3, rgb).ok());
}

}  // namespace
}  // namespace planecast
