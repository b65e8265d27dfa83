// The golden vectors decode to what they did, the same frames give the same bytes, and spoilt
// packets end with the status that their file names.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <filesystem>
#include <map>

#include "core/base/random.hpp"
#include "tests/golden/bad_packets.hpp"
#include "tests/golden/golden_vectors.hpp"
#include "tests/support/source_folder.hpp"

namespace planecast::test {
namespace {

namespace fs = std::filesystem;

const fs::path kFolder = source_folder() / "tests" / "golden";
constexpr const char* kMend = "  (after a change of the format: target rewrite_golden)";

Bytes file(const std::string& name) {
  const auto bytes = read_golden_file(kFolder / name);
  EXPECT_TRUE(bytes.ok()) << name;
  return bytes.ok() ? *bytes : Bytes{};
}

std::string text(const std::string& name) {
  const Bytes bytes = file(name);
  return {bytes.begin(), bytes.end()};
}

const std::vector<GoldenCase>& cases() {
  static const auto all = golden_cases(kFolder);
  EXPECT_TRUE(all.ok()) << all.error().message;
  return *all;
}

// What a vector decodes to, as the lines of expected.txt; or why it does not.
std::string lines_of(const GoldenCase& c, std::span<const std::uint8_t> bytes) {
  const auto frames = decode_golden(bytes, limits_of(c));
  return frames.ok() ? expected_lines(c.name, *frames)
                     : c.name + ": " + frames.error().message + "\n";
}

TEST(Golden, VectorsDecodeToTheSameCountsAndFloats) {
  std::string found = "# case frame slices readings crc32c(counts) crc32c(cloud)\n";
  for (const GoldenCase& c : cases()) found += lines_of(c, file(c.name + ".plc"));
  EXPECT_EQ(found, text("expected.txt")) << kMend;
}

TEST(Golden, DumpsAreWhatTheirVectorsDecodeTo) {
  for (const GoldenCase& c : cases()) {
    if (!c.dump) continue;
    const auto frames = decode_golden(file(c.name + ".plc"));
    ASSERT_TRUE(frames.ok()) << c.name << ": " << frames.error().message;
    const std::string found = dump_lines(frames->front(), c.config.camera.width);
    const std::string golden = text(c.name + ".txt");
    const auto differs = std::mismatch(found.begin(), found.end(), golden.begin(), golden.end());
    EXPECT_TRUE(found == golden) << c.name << ".txt, line "
                                 << 1 + std::count(found.begin(), differs.first, '\n') << kMend;
  }
}

TEST(Golden, AFlippedByteIsSeen) {
  constexpr std::size_t kFileMinor = 5;  // of the file's version: any is read
  Pcg32 random(5);
  for (const GoldenCase& c : cases()) {
    const Bytes good = file(c.name + ".plc");
    const std::string lines = lines_of(c, good);
    const std::size_t step = 1 + good.size() / (c.config.camera.pixels() > 20'000 ? 8 : 200);
    for (std::size_t at = 0; at < good.size(); at += step) {
      if (at == kFileMinor) continue;
      Bytes spoilt = good;
      spoilt[at] ^= static_cast<std::uint8_t>(1U + random.below(255));
      EXPECT_NE(lines_of(c, spoilt), lines) << c.name << ", byte " << at;
    }
  }
}

std::vector<std::array<std::uint32_t, 3>> sorted_bits(const std::vector<Point3f>& points) {
  std::vector<std::array<std::uint32_t, 3>> out;
  const auto bits = [](float f) { return std::bit_cast<std::uint32_t>(f); };
  for (const Point3f& p : points) out.push_back({bits(p.x), bits(p.y), bits(p.z)});
  std::sort(out.begin(), out.end());
  return out;
}

TEST(Golden, LosslessListsDecodeToTheirInputsInSomeOrderAndOthersToAsManyPoints) {
  int lists = 0;
  for (const GoldenCase& c : cases()) {
    if (c.config.kind != FrameKind::kPoints) continue;
    ++lists;
    const auto frames = decode_golden(file(c.name + ".plc"));
    ASSERT_TRUE(frames.ok()) << c.name;
    ASSERT_EQ(frames->size(), c.clouds.size());
    for (std::size_t i = 0; i < frames->size(); ++i) {
      const auto& out = (*frames)[i].cloud;
      if (c.config.tolerance == ToleranceKind::kLossless)
        EXPECT_EQ(sorted_bits(out), sorted_bits(c.clouds[i])) << c.name;
      if (c.config.drop_off_surface)
        EXPECT_LE(out.size(), c.clouds[i].size()) << c.name;
      else
        EXPECT_EQ(out.size(), c.clouds[i].size()) << c.name;
    }
  }
  EXPECT_EQ(lists, 6);
}

TEST(Golden, LosslessVectorsDecodeToTheirInputs) {
  for (const GoldenCase& c : cases()) {
    if (c.config.kind == FrameKind::kPoints) continue;
    const auto frames = decode_golden(file(c.name + ".plc"));
    ASSERT_TRUE(frames.ok());
    ASSERT_EQ(frames->size(), std::max(c.depth.size(), c.clouds.size()));
    for (std::size_t i = 0; i < frames->size(); ++i) {
      const GoldenFrame& frame = (*frames)[i];
      if (c.config.kind == FrameKind::kDepth) {
        if (c.config.tolerance == ToleranceKind::kLossless)
          EXPECT_EQ(frame.depth, c.depth[i]) << c.name;
        continue;
      }
      for (std::size_t p = 0; p < frame.cloud.size(); ++p) {
        const Point3f &in = c.clouds[i][p], &out = frame.cloud[p];
        const bool reading = in.x - in.x == 0 && in.y - in.y == 0 && in.z - in.z == 0;
        if (reading)
          ASSERT_TRUE(in.x == out.x && in.y == out.y && in.z == out.z) << c.name << " " << p;
        else
          ASSERT_TRUE(out.x != out.x && out.y != out.y && out.z != out.z) << c.name << " " << p;
      }
    }
  }
}

TEST(Golden, EncodingTheSameFramesGivesTheSameBytes) {
  for (const GoldenCase& c : cases()) {
    const auto again = encode_golden(c);
    ASSERT_TRUE(again.ok()) << again.error().message;
    const Bytes golden = file(c.name + ".plc");
    EXPECT_TRUE(*again == golden) << c.name << ": " << again->size() << " bytes, golden "
                                  << golden.size() << kMend;
  }
}

TEST(Golden, EverySpoiltPacketEndsWithTheStatusInItsName) {
  const Bytes depth = file("metres_160x120.plc"), raw = file("raw_64x48.plc");
  const BadBench bench(depth, raw, file("points_metres.plc"), file("points_paper.plc"));
  std::map<std::string, int> seen;
  for (const auto& entry : fs::directory_iterator(kFolder / "bad")) {
    const std::string name = entry.path().filename().string();
    const std::size_t split = name.find("__");
    ASSERT_NE(split, std::string::npos) << name;
    const Status status = bench.decode(name.substr(split + 2), file("bad/" + name));
    EXPECT_EQ(to_string(status), name.substr(0, split)) << name << kMend;
    ++seen[name.substr(0, split)];
  }
  for (const char* status : {"kTruncated", "kBadMagic", "kUnsupportedVersion", "kReservedBits",
                             "kBadCheck", "kFieldRange", "kUnknownKey", "kBadSymbol", "kTooLarge",
                             "kTrailingBytes", "kFrameTooLarge"}) {
    EXPECT_GT(seen[status], 0) << status;
  }
}

TEST(Golden, SpoiltPacketsAreThoseThatTheProgramMakes) {
  const Bytes depth = file("metres_160x120.plc"), raw = file("raw_64x48.plc");
  const BadBench bench(depth, raw, file("points_metres.plc"), file("points_paper.plc"));
  const auto made = bad_packets(bench, file("lossless_1x1.plc"));
  ASSERT_TRUE(made.ok()) << made.error().message;
  for (const BadPacket& packet : *made)
    EXPECT_TRUE(packet.bytes == file("bad/" + packet.file_name())) << packet.file_name() << kMend;
}

TEST(Golden, VectorsCoverWhatTheyAreNamedFor) {
  const auto slices = [](const std::string& name) {
    const auto frames = decode_golden(file(name + ".plc"));
    return frames.ok() ? int{frames->front().slices} : -1;
  };
  EXPECT_EQ(slices("lossless_160x120"), 1);
  EXPECT_GT(slices("lossless_slices_160x120"), 4);
  EXPECT_EQ(slices("wide_2100x1"), 2) << "a tile has at most 256 blocks a side";
  EXPECT_EQ(slices("lossless_1x1"), 1);
  EXPECT_GT(slices("points_metres"), 1);
  EXPECT_GT(slices("points_surfaces_keep"), 1) << "patches, then points";
  std::uintmax_t bytes = 0;
  for (const auto& entry : fs::recursive_directory_iterator(kFolder))
    if (entry.is_regular_file()) bytes += entry.file_size();
  EXPECT_LT(bytes, 450'000U);
}

}  // namespace
}  // namespace planecast::test
