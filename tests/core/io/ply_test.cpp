#include "core/io/ply.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/io/io_test_support.hpp"

namespace planecast {
namespace {

using test::HeaderLie;
using test::patched;
using test::random_cloud;
using test::same_points;
using test::TempFolder;

const std::string kAscii =
    "ply\nformat ascii 1.0\ncomment made by hand\nobj_info none\nelement camera 1\n"
    "property list uchar int ids\nproperty double f\nelement vertex 2\nproperty uchar red\n"
    "property float z\nproperty double x\nproperty float y\nelement face 1\n"
    "property list uchar uint vertex_indices\nend_header\n"
    "3 7 8 9 525.5\n255 3 1 2\n0 -3 -1 -2\n3 0 1 1\n";

template <class T>
void append_value(std::string& out, T value, bool big_endian) {
  std::string bytes;
  test::append_raw(bytes, value);
  if (big_endian) std::reverse(bytes.begin(), bytes.end());
  out += bytes;
}

// The same file as kAscii in either binary order.
std::string binary_file(bool big_endian) {
  std::string out = kAscii.substr(0, kAscii.find("end_header\n") + 11);
  out = patched(out, "ascii", big_endian ? "binary_big_endian" : "binary_little_endian");
  append_value(out, std::uint8_t{3}, big_endian);
  for (const std::int32_t id : {7, 8, 9}) append_value(out, id, big_endian);
  append_value(out, 525.5, big_endian);
  for (const int sign : {1, -1}) {
    append_value(out, static_cast<std::uint8_t>(sign > 0 ? 255 : 0), big_endian);
    append_value(out, 3.0F * static_cast<float>(sign), big_endian);
    append_value(out, 1.0 * sign, big_endian);
    append_value(out, 2.0F * static_cast<float>(sign), big_endian);
  }
  append_value(out, std::uint8_t{3}, big_endian);
  for (const std::uint32_t id : {0U, 1U, 1U}) append_value(out, id, big_endian);
  return out;
}

std::vector<std::string> all_encodings() {
  return {kAscii, binary_file(false), binary_file(true)};
}

TEST(Ply, ReadsVerticesBetweenOtherElementsInAllEncodings) {
  const TempFolder folder;
  for (const std::string& content : all_encodings()) {
    const auto cloud = read_ply(folder.file("a.ply", content));
    ASSERT_TRUE(cloud.ok()) << cloud.error().message;
    EXPECT_TRUE(same_points(cloud->points, {{1, 2, 3}, {-1, -2, -3}}));
    EXPECT_EQ(cloud->width, 2U);
    EXPECT_EQ(cloud->height, 1U);
    EXPECT_EQ(cloud->dropped_fields,
              (std::vector<std::string>{"red", "element camera", "element face"}));
  }
}

TEST(Ply, EveryTruncationIsAnErrorInAllEncodings) {
  const TempFolder folder;
  for (const std::string& content : all_encodings()) {
    test::for_every_truncation(
        folder, "cut.ply", content, [&](const std::filesystem::path& path, std::size_t length) {
          SCOPED_TRACE(length);
          if (content == kAscii && length + 1 == content.size()) {
            EXPECT_TRUE(read_ply(path).ok());  // only the last line end is gone
          } else {
            EXPECT_REFUSED(read_ply(path), path, "");
          }
        });
  }
}

TEST(Ply, RoundTripsValidPointsAndCountsTheOthers) {
  const TempFolder folder;
  for (const auto& [width, height] : {std::pair{0U, 1U}, {1U, 1U}, {500U, 1U}, {32U, 24U}}) {
    const PointCloud cloud = random_cloud(width, height, width + 7U, width > 1 ? 0.3 : 0.0);
    const auto written = write_ply(folder / "a.ply", cloud);
    ASSERT_TRUE(written.ok()) << written.error().message;
    const auto valid = test::valid_points(cloud);
    EXPECT_EQ(written->points_written, valid.size());
    EXPECT_EQ(written->points_left_out, cloud.points.size() - valid.size());
    const auto read = read_ply(folder / "a.ply");
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_TRUE(same_points(read->points, valid));
    EXPECT_FALSE(read->organised());
  }
}

TEST(Ply, KeepsLargeOffsetsThroughARoundTrip) {
  const TempFolder folder;
  PointCloud cloud = random_cloud(10, 1, 3);
  for (Point3f& p : cloud.points) p.x = std::round(p.x * 1024) / 1024;  // exact after the sum
  cloud.origin_x = 5412345;
  ASSERT_TRUE(write_ply(folder / "a.ply", cloud).ok());
  const auto read = read_ply(folder / "a.ply");
  ASSERT_TRUE(read.ok()) << read.error().message;
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    EXPECT_EQ(read->points[i].x + read->origin_x, cloud.points[i].x + cloud.origin_x);
  }
}

TEST(Ply, HeaderWithWindowsLineEndsIsRead) {
  const TempFolder folder;
  std::string header =
      "ply\r\nformat binary_little_endian 1.0\r\nelement vertex 1\r\n"
      "property float x\r\nproperty float y\r\nproperty float z\r\nend_header\r\n";
  for (const float v : {1.0F, 2.0F, 3.0F}) test::append_raw(header, v);
  const auto cloud = read_ply(folder.file("a.ply", header));
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  EXPECT_TRUE(same_points(cloud->points, {{1, 2, 3}}));
}

class PlyHeaderLies : public testing::TestWithParam<HeaderLie> {};

TEST_P(PlyHeaderLies, AreRefusedByNameInAllEncodings) {
  const TempFolder folder;
  for (const std::string& content : all_encodings()) {
    const auto path = folder.file("a.ply", patched(content, GetParam().from, GetParam().to));
    EXPECT_REFUSED(read_ply(path), path, GetParam().message);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Each, PlyHeaderLies,
    testing::Values(HeaderLie{"vertex 2", "vertex 4000000000", "limit"},
                    HeaderLie{"vertex 2", "vertex 16000000", "too short"},
                    HeaderLie{"vertex 2", "vertex 1", ""},
                    HeaderLie{"vertex 2", "vertex -2", "line 8"},
                    HeaderLie{"vertex 2", "vertex 2e0", "whole number"},
                    HeaderLie{"face 1", "face 18446744073709551615", "too short"},
                    HeaderLie{"face 1", "face 99999999999999999999", "whole number"},
                    HeaderLie{"face 1", "face 2", ""},
                    HeaderLie{"face 1", "face 0", "after the last element"},
                    HeaderLie{"element vertex", "element points", "no vertex"},
                    HeaderLie{"element face", "element vertex", "two vertex"},
                    HeaderLie{"property float z", "property float w", "property z"},
                    HeaderLie{"property float z", "property list uchar float z", "property z"},
                    HeaderLie{"property float z", "property float x", "property x"},
                    HeaderLie{"property float z", "property half z", "property 'z'"},
                    HeaderLie{"property float z", "property float", "type and a name"},
                    HeaderLie{"list uchar int", "list float int", "'ids'"},
                    HeaderLie{"element camera 1\n", "", "before any element"},
                    HeaderLie{" 1.0", " 2.0", "'2.0'"}, HeaderLie{"format ", "form ", "'form'"},
                    HeaderLie{"ply\n", "plx\n", "start with 'ply'"}));

TEST(Ply, NegativeAndHugeListLengthsAreRefused) {
  const TempFolder folder;
  for (const char* length : {"-3", "3.5", "4294967295", "99999999999", "nan"}) {
    const auto path =
        folder.file("a.ply", patched(kAscii, "\n3 7 8 9", std::string("\n") + length + " 7 8 9"));
    EXPECT_REFUSED(read_ply(path), path, "list 'ids'");
  }
  std::string binary = patched(binary_file(false), "list uchar int", "list int int");
  const std::size_t data = binary.find("end_header\n") + 11;
  binary.replace(data, 1, "\xFF\xFF\xFF\xFF");
  const auto path = folder.file("a.ply", binary);
  EXPECT_REFUSED(read_ply(path), path, "list 'ids'");
}

TEST(Ply, AnElementWithoutPropertiesTakesNoTime) {
  const TempFolder folder;
  const auto path = folder.file(
      "a.ply",
      patched(kAscii, "element camera", "element nothing 18446744073709551615\nelement camera"));
  EXPECT_TRUE(read_ply(path).ok());
}

TEST(Ply, SeededDamageNeverCrashesTheReader) {
  const TempFolder folder;
  Pcg32 random(78);
  const auto files = all_encodings();
  for (int round = 0; round < 3000; ++round) {
    std::string content = files[static_cast<std::size_t>(round) % files.size()];
    for (std::uint32_t i = 0; i <= random.below(4); ++i) {
      content[random.below(static_cast<std::uint32_t>(content.size()))] =
          static_cast<char>(random.next());
    }
    const auto cloud = read_ply(folder.file("a.ply", content));
    if (!cloud.ok()) continue;
    EXPECT_EQ(cloud->points.size(), cloud->width);
  }
}

}  // namespace
}  // namespace planecast
