// PCD files that lie: headers, sizes, compressed data. Each is an error with a place and a mend.
#include <gtest/gtest.h>

#include <bit>

#include "core/io/file_bytes.hpp"
#include "core/io/pcd.hpp"
#include "tests/core/io/io_test_support.hpp"
#include "tests/core/io/lzf_pack.hpp"

namespace planecast {
namespace {

using test::HeaderLie;
using test::patched;
using test::TempFolder;

const std::string kGood =
    "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 2\nHEIGHT 1\n"
    "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 2\nDATA ascii\n1 2 3\n4 5 6\n";

std::string compressed_pcd(const PointCloud& cloud) {
  std::vector<std::uint8_t> by_field;
  for (const auto axis : {&Point3f::x, &Point3f::y, &Point3f::z}) {
    for (const Point3f& p : cloud.points) {
      const auto bits = std::bit_cast<std::uint32_t>(p.*axis);
      for (unsigned i = 0; i < 4; ++i) by_field.push_back(static_cast<std::uint8_t>(bits >> 8 * i));
    }
  }
  const auto packed = test::lzf_pack(by_field);
  std::string out = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
                    std::to_string(cloud.width) + "\nHEIGHT " + std::to_string(cloud.height) +
                    "\nPOINTS " + std::to_string(cloud.points.size()) +
                    "\nDATA binary_compressed\n";
  test::append_raw(out, static_cast<std::uint32_t>(packed.size()));
  test::append_raw(out, static_cast<std::uint32_t>(by_field.size()));
  out.append(packed.begin(), packed.end());
  return out;
}

TEST(PcdHostile, TheUnpatchedFileIsGood) {
  const TempFolder folder;
  EXPECT_TRUE(read_pcd(folder.file("a.pcd", kGood)).ok());
}

class PcdHeaderLies : public testing::TestWithParam<HeaderLie> {};

TEST_P(PcdHeaderLies, AreRefusedByName) {
  const TempFolder folder;
  for (const char* data : {"DATA ascii", "DATA binary", "DATA binary_compressed"}) {
    std::string content = patched(kGood, "DATA ascii", data);
    content = patched(content, GetParam().from, GetParam().to);
    const auto path = folder.file("a.pcd", content);
    EXPECT_REFUSED(read_pcd(path), path, GetParam().message);
  }
}

INSTANTIATE_TEST_SUITE_P(
    Each, PcdHeaderLies,
    testing::Values(HeaderLie{"POINTS 2", "POINTS 4000000000", "limit"},
                    HeaderLie{"POINTS 2", "POINTS 3", "is not POINTS 3"},
                    HeaderLie{"POINTS 2", "POINTS 99999999999999999999999", "64 bits"},
                    HeaderLie{"POINTS 2", "POINTS 4e9", "whole number"},
                    HeaderLie{"POINTS 2", "POINTS -2", "whole number"},
                    HeaderLie{"WIDTH 2\nHEIGHT 1", "WIDTH 16777216\nHEIGHT 16777216",
                              "is not POINTS"},
                    HeaderLie{"WIDTH 2\nHEIGHT 1", "WIDTH 4294967296\nHEIGHT 4294967296", "limit"},
                    HeaderLie{"WIDTH 2\nHEIGHT 1", "WIDTH -1\nHEIGHT -2", "line 6"},
                    HeaderLie{"WIDTH 2", "WIDTH 0", "is not POINTS 2"},
                    HeaderLie{"HEIGHT 1", "HEIGHT 0", "is not POINTS 2"},
                    HeaderLie{"WIDTH 2\nHEIGHT 1\n", "HEIGHT 2\n", "is not POINTS 2"},
                    HeaderLie{"SIZE 4 4 4", "SIZE 4 4 3", "SIZE"},
                    HeaderLie{"SIZE 4 4 4", "SIZE 4 4 2", "SIZE 2"},
                    HeaderLie{"SIZE 4 4 4", "SIZE 4 4", "SIZE has 2 entries"},
                    HeaderLie{"SIZE 4 4 4", "SIZE 4 4 0", "SIZE"},
                    HeaderLie{"SIZE 4 4 4", "SIZE 4 4 -4", "SIZE"},
                    HeaderLie{"TYPE F F F", "TYPE F F U", "TYPE U"},
                    HeaderLie{"TYPE F F F", "TYPE F F Q", "'Q'"},
                    HeaderLie{"TYPE F F F", "TYPE F F F F", "TYPE has 4"},
                    HeaderLie{"COUNT 1 1 1", "COUNT 1 1 2", "COUNT 2"},
                    HeaderLie{"COUNT 1 1 1", "COUNT 1 1 0", "COUNT"},
                    HeaderLie{"COUNT 1 1 1", "COUNT 4294967295 1 1", "COUNT"},
                    HeaderLie{"COUNT 1 1 1", "COUNT 1048576 1048576 1048576", "bytes"},
                    HeaderLie{"FIELDS x y z", "FIELDS x y w", "z is missing"},
                    HeaderLie{"FIELDS x y z", "FIELDS x x z", "more than once"},
                    HeaderLie{"FIELDS x y z", "FIELDS", "FIELDS"},
                    HeaderLie{"FIELDS x y z\n", "", "FIELDS is missing"},
                    HeaderLie{"VERSION 0.7", "VERSION 0.8", "0.8"},
                    HeaderLie{"VERSION 0.7", "VERSION", "version"},
                    HeaderLie{"VERSION 0.7", "PNG", "not known"},
                    HeaderLie{"VERSION 0.7", "VERSION 0.7\nVERSION 0.7", "twice"},
                    HeaderLie{"VIEWPOINT 0 0 0 1 0 0 0", "VIEWPOINT 0 0 0", "VIEWPOINT"},
                    HeaderLie{"VIEWPOINT 0 0 0 1 0 0 0", "VIEWPOINT 0 0 0 0 0 0 0", "VIEWPOINT"},
                    HeaderLie{"VIEWPOINT 0 0 0 1 0 0 0", "VIEWPOINT nan 0 0 1 0 0 0", "VIEWPOINT"},
                    HeaderLie{"DATA ", "DATA zip_", "zip_"}));

TEST(PcdHostile, AsciiLinesMustBeWhole) {
  const TempFolder folder;
  const auto expect = [&folder](const std::string& content, const std::string& message) {
    const auto path = folder.file("a.pcd", content);
    EXPECT_REFUSED(read_pcd(path), path, message);
  };
  expect(patched(kGood, "4 5 6\n", ""), "too short");
  expect(patched(kGood, "4 5 6\n", "          \n"), "ends after 1 points");
  expect(patched(kGood, "4 5 6", "4.25 5"), "line 12: there are 2 values");
  expect(patched(kGood, "4 5 6", "4 5 6 7"), "there are 4 values");
  expect(patched(kGood, "4 5 6", "4 five 6"), "'five'");
  expect(patched(kGood, "4 5 6", "4 5 6\n7 8 9"), "more points");
  expect(patched(kGood, "4 5 6", "4 5 1e300"), "float32");
  expect(patched(kGood, "4 5 6", "4 5 1e999"), "not a number");
}

TEST(PcdHostile, EveryTruncationOfABinaryFileIsAnError) {
  const TempFolder folder;
  ASSERT_TRUE(write_pcd(folder / "good.pcd", test::random_cloud(3, 2, 4)).ok());
  const std::string content = test::file_content(folder / "good.pcd");
  test::for_every_truncation(folder, "cut.pcd", content,
                             [](const std::filesystem::path& path, std::size_t length) {
                               SCOPED_TRACE(length);
                               EXPECT_REFUSED(read_pcd(path), path, "");
                             });
}

TEST(PcdHostile, EveryTruncationOfACompressedFileIsAnError) {
  const TempFolder folder;
  const PointCloud cloud = test::random_cloud(4, 4, 9, 0.5);
  const std::string content = compressed_pcd(cloud);
  const auto whole = read_pcd(folder.file("good.pcd", content));
  ASSERT_TRUE(whole.ok()) << whole.error().message;
  EXPECT_TRUE(test::same_points(whole->points, cloud.points));
  test::for_every_truncation(folder, "cut.pcd", content,
                             [](const std::filesystem::path& path, std::size_t length) {
                               SCOPED_TRACE(length);
                               EXPECT_REFUSED(read_pcd(path), path, "");
                             });
}

TEST(PcdHostile, EveryTruncationOfAnAsciiFileIsAnErrorUnlessItEndsInItsLastNumber) {
  const TempFolder folder;
  const std::string content = patched(kGood, "4 5 6", "4 5 6.25");
  const std::size_t last_number = content.find("6.25");
  test::for_every_truncation(folder, "cut.pcd", content,
                             [&](const std::filesystem::path& path, std::size_t length) {
                               SCOPED_TRACE(length);
                               if (length > last_number) {
                                 EXPECT_TRUE(read_pcd(path).ok());
                               } else {
                                 EXPECT_REFUSED(read_pcd(path), path, "");
                               }
                             });
}

TEST(PcdHostile, PaddingOfZerosIsAllowedOtherBytesAfterTheDataAreNot) {
  const TempFolder folder;
  const PointCloud cloud = test::random_cloud(4, 4, 9);
  ASSERT_TRUE(write_pcd(folder / "good.pcd", cloud).ok());
  for (const std::string& content :
       {test::file_content(folder / "good.pcd"), compressed_pcd(cloud)}) {
    const auto padded = folder.file("a.pcd", content + std::string(4096, '\0'));
    EXPECT_TRUE(read_pcd(padded).ok());
    const auto more = folder.file("a.pcd", content + std::string(11, '\0') + "x");
    EXPECT_REFUSED(read_pcd(more), more, "left after the data");
  }
}

TEST(PcdHostile, AnLzfBombIsRefusedBeforeMemoryIsTaken) {
  const TempFolder folder;
  const auto points = static_cast<std::uint32_t>(kMaxFilePoints);
  std::string bomb = "VERSION 0.7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH " +
                     std::to_string(points) + "\nHEIGHT 1\nDATA binary_compressed\n";
  test::append_raw(bomb, std::uint32_t{30});
  test::append_raw(bomb, points * 12U);
  const auto path = folder.file("a.pcd", bomb + std::string(30, '\xFF'));
  EXPECT_REFUSED(read_pcd(path), path, "cannot expand");
}

TEST(PcdHostile, APromiseOf32BitsAndMoreIsNotTakenModulo32Bits) {
  const TempFolder folder;
  const std::string shape =
      "VERSION 0.7\nFIELDS x y z _\nSIZE 4 4 4 1\nTYPE F F F U\nCOUNT 1 1 1 1048564\n"
      "WIDTH 4096\nHEIGHT 1\nDATA ";  // 2^32 bytes, and 2^32 + 2^13 words of two characters
  const auto binary = folder.file("a.pcd", shape + "binary\n");
  EXPECT_REFUSED(read_pcd(binary), binary, "promises data up to byte 4294967");
  const auto packed = folder.file("b.pcd", shape + "binary_compressed\n" + std::string(8, '\0'));
  EXPECT_REFUSED(read_pcd(packed), packed, "the header asks for 4294967296");
  const auto ascii = folder.file("c.pcd", shape + "ascii\n1 2 3 4\n");
  EXPECT_REFUSED(read_pcd(ascii), ascii, "too short for POINTS 4096");
}

TEST(PcdHostile, CompressedSizesThatDisagreeAreRefused) {
  const TempFolder folder;
  const std::string content = compressed_pcd(test::random_cloud(4, 1, 9));
  const std::size_t sizes = content.find("compressed\n") + 11;
  for (std::size_t byte = 0; byte < 8; ++byte) {
    for (const char value : {'\x01', '\x7F', '\xFF'}) {
      std::string changed = content;
      if (changed[sizes + byte] == value) continue;
      changed[sizes + byte] = value;
      const auto path = folder.file("a.pcd", changed);
      EXPECT_REFUSED(read_pcd(path), path, "");
    }
  }
}

TEST(PcdHostile, SeededDamageNeverCrashesTheReader) {
  const TempFolder folder;
  Pcg32 random(77);
  const std::string compressed = compressed_pcd(test::random_cloud(4, 4, 9, 0.5));
  for (int round = 0; round < 3000; ++round) {
    std::string content = round % 2 == 0 ? compressed : kGood;
    for (std::uint32_t i = 0; i <= random.below(4); ++i) {
      content[random.below(static_cast<std::uint32_t>(content.size()))] =
          static_cast<char>(random.next());
    }
    const auto cloud = read_pcd(folder.file("a.pcd", content));
    if (!cloud.ok()) continue;
    EXPECT_EQ(cloud->points.size(), std::size_t{cloud->width} * cloud->height);
  }
}

TEST(PcdHostile, MissingFilesAndFoldersAreNamed) {
  const TempFolder folder;
  const auto missing = read_pcd(folder / "none.pcd");
  ASSERT_FALSE(missing.ok());
  EXPECT_EQ(missing.error().status, Status::kNotFound);
  EXPECT_REFUSED(read_pcd(folder.path()), folder.path(), "folder");
}

}  // namespace
}  // namespace planecast
