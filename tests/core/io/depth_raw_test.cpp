#include "core/io/depth_raw.hpp"

#include <gtest/gtest.h>

#include "tests/core/io/io_test_support.hpp"

namespace planecast {
namespace {

using test::TempFolder;

TEST(DepthRaw, RoundTripsAndIsLittleEndian) {
  const TempFolder folder;
  const DepthImage image{3, 2, {0, 1, 256, 0x1234, 65535, 7}};
  ASSERT_TRUE(write_depth_raw(folder / "a.raw", image).ok());
  EXPECT_EQ(test::file_content(folder / "a.raw").substr(4, 4), std::string("\x00\x01\x34\x12", 4));
  const auto read = read_depth_raw(folder / "a.raw", 3, 2);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->depth, image.depth);
  EXPECT_EQ(read->width, 3U);
}

TEST(DepthRaw, EveryWrongSizeSaysExpectedAndFound) {
  const TempFolder folder;
  const std::string content(12, 'a');
  test::for_every_truncation(folder, "cut.raw", content,
                             [](const std::filesystem::path& path, std::size_t length) {
                               const auto image = read_depth_raw(path, 3, 2);
                               EXPECT_REFUSED(image, path, "expected 12 bytes");
                               EXPECT_REFUSED(image, path, "found " + std::to_string(length));
                             });
  const auto longer = folder.file("a.raw", content + "b");
  EXPECT_REFUSED(read_depth_raw(longer, 3, 2), longer, "found 13");
}

TEST(DepthRaw, RefusesSizesOfZeroAndBeyondTheLimit) {
  const TempFolder folder;
  const auto path = folder.file("a.raw", "");
  for (const auto& [width, height] :
       {std::pair{0U, 4U}, {4U, 0U}, {16385U, 1U}, {1U, 4294967295U}}) {
    const auto image = read_depth_raw(path, width, height);
    ASSERT_FALSE(image.ok());
    EXPECT_EQ(image.error().status, Status::kUsage);
    EXPECT_NE(image.error().message.find("--size"), std::string::npos);
  }
}

}  // namespace
}  // namespace planecast
