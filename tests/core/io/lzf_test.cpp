#include "core/io/lzf.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "tests/core/io/io_test_support.hpp"
#include "tests/core/io/lzf_pack.hpp"

namespace planecast {
namespace {

std::vector<std::uint8_t> bytes_of(std::string_view text) {
  return {text.begin(), text.end()};
}

TEST(Lzf, ExpandsWhatAPackerMadeOfSeededBytes) {
  Pcg32 random(11);
  for (const std::size_t size : {0U, 1U, 31U, 32U, 33U, 1000U, 100000U}) {
    std::vector<std::uint8_t> original(size);
    for (auto& b : original) b = static_cast<std::uint8_t>(random.below(random.below(8) + 1));
    const auto packed = test::lzf_pack(original);
    std::vector<std::uint8_t> out(size);
    std::size_t at = 0;
    EXPECT_EQ(lzf_expand(packed, out, at), Status::kOk);
    EXPECT_EQ(at, packed.size());
    EXPECT_EQ(out, original);
  }
}

TEST(Lzf, ExpandsAHandMadeOverlappingMatch) {
  // One literal 'a', then a match of length 2 + 7 + 3 = 12 at distance 1.
  const std::vector<std::uint8_t> packed = {0x00, 'a', 0xE0, 0x03, 0x00};
  std::vector<std::uint8_t> out(13);
  std::size_t at = 0;
  EXPECT_EQ(lzf_expand(packed, out, at), Status::kOk);
  EXPECT_EQ(out, bytes_of("aaaaaaaaaaaaa"));
}

TEST(Lzf, RefusesAMatchBeforeTheStart) {
  const std::vector<std::uint8_t> packed = {0x00, 'a', 0x20, 0x01};  // distance 2, one byte there
  std::vector<std::uint8_t> out(4);
  std::size_t at = 0;
  EXPECT_EQ(lzf_expand(packed, out, at), Status::kBadSymbol);
  EXPECT_EQ(at, 2U);
}

TEST(Lzf, RefusesTooMuchAndTooLittle) {
  const std::vector<std::uint8_t> packed = {0x00, 'a', 0xE0, 0x03, 0x00};
  std::size_t at = 0;
  std::vector<std::uint8_t> small(12);
  EXPECT_EQ(lzf_expand(packed, small, at), Status::kTooLarge);
  std::vector<std::uint8_t> large(14);
  EXPECT_EQ(lzf_expand(packed, large, at), Status::kTruncated);
}

TEST(Lzf, NeverLeavesItsSpansOnSeededGarbageAndCuts) {
  Pcg32 random(12);
  for (int round = 0; round < 20000; ++round) {
    std::vector<std::uint8_t> packed(random.below(40));
    for (auto& b : packed) b = static_cast<std::uint8_t>(random.next());
    std::vector<std::uint8_t> out(random.below(200));
    std::size_t at = 0;
    const Status status = lzf_expand(packed, out, at);
    EXPECT_LE(at, packed.size());
    EXPECT_TRUE(status == Status::kOk || status == Status::kTruncated ||
                status == Status::kTooLarge || status == Status::kBadSymbol);
  }
}

TEST(Lzf, NoStreamExpandsBeyondTheStatedRatio) {
  const std::vector<std::uint8_t> zeros(1 << 20);
  const auto packed = test::lzf_pack(zeros);
  EXPECT_LE(zeros.size(), packed.size() * kMaxLzfExpansion);
  EXPECT_GE(zeros.size(), packed.size() * (kMaxLzfExpansion - 2));  // the ratio is not idle either
}

}  // namespace
}  // namespace planecast
