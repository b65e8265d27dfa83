// The range coder and its adaptive probabilities: what goes in comes out, at close to its
// entropy, in any buffer, and a cut stream is noticed.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <vector>

#include "core/base/random.hpp"
#include "core/wire/point_models.hpp"
#include "core/wire/range_decoder.hpp"
#include "core/wire/range_encoder.hpp"
#include "core/wire/tile_models.hpp"

namespace planecast {
namespace {

struct Symbol {
  int raw_bits = 0;  // 0: a decision of model `model`
  std::uint32_t value = 0;
  std::uint32_t model = 0;
};

constexpr std::uint32_t kModels = 16;

std::vector<Symbol> random_symbols(Pcg32& random, std::size_t count) {
  double chance[kModels];
  for (double& c : chance) {
    c = random.uniform();
    c = random.below(2) != 0 ? c * c * c * c * c * c : c;  // some models hardly ever see a 1
  }
  std::vector<Symbol> out(count);
  for (Symbol& s : out) {
    if (random.below(5) == 0) {
      s.raw_bits = 1 + static_cast<int>(random.below(16));
      s.value = random.next() & ((1U << s.raw_bits) - 1U);
      if (random.below(3) == 0) s.value = random.below(2) != 0 ? (1U << s.raw_bits) - 1U : 0;
    } else {
      s.model = random.below(kModels);
      s.value = random.uniform() < chance[s.model] ? 1 : 0;
    }
  }
  return out;
}

std::size_t encode(const std::vector<Symbol>& symbols, RangeEncoder& coder) {
  std::vector<BitModel> models(kModels);
  for (const Symbol& s : symbols) {
    if (s.raw_bits != 0)
      coder.raw(s.value, s.raw_bits);
    else
      coder.bit(models[s.model], s.value != 0);
  }
  return coder.finish();
}

// Symbols read before the first that differs.
std::size_t matching(const std::vector<Symbol>& symbols, RangeDecoder& coder) {
  std::vector<BitModel> models(kModels);
  std::size_t count = 0;
  for (const Symbol& s : symbols) {
    const std::uint32_t value =
        s.raw_bits != 0 ? coder.raw(s.raw_bits) : (coder.bit(models[s.model]) ? 1U : 0U);
    if (value != s.value) break;
    ++count;
  }
  return count;
}

// What is written after a mark is forgotten, a carry past it too: bytes of 0xff wait for one.
TEST(RangeCoder, GoesBackAsIfNothingHadFollowed) {
  Pcg32 random(77);
  int carried = 0;
  for (int run = 0; run < 3000; ++run) {
    const auto kept = random_symbols(random, random.below(60));
    const auto dropped = random_symbols(random, 1 + random.below(60));
    std::vector<std::uint8_t> expected(400), got(400);
    RangeEncoder alone(expected), coder(got);
    std::vector<BitModel> models(kModels);
    for (const Symbol& s : kept) {
      for (RangeEncoder* c : {&alone, &coder}) {
        BitModel model = models[s.model];
        s.raw_bits != 0 ? c->raw(s.value, s.raw_bits) : c->bit(model, s.value != 0);
        if (c == &coder) models[s.model] = model;
      }
    }
    const std::vector<std::uint8_t> before = got;
    const RangeEncoder::Mark mark = coder.mark();
    // Straight to the top of the range, so that carries are common.
    for (const Symbol& s : dropped) coder.raw(random.below(4) != 0 ? 1 : s.value & 1U, 1);
    for (std::size_t i = 0; i < mark.used; ++i) carried += before[i] != got[i] ? 1 : 0;
    coder.go_back(mark);
    const std::size_t used = coder.finish();
    ASSERT_EQ(used, alone.finish());
    ASSERT_TRUE(
        std::equal(got.begin(), got.begin() + static_cast<std::ptrdiff_t>(used), expected.begin()));
  }
  EXPECT_GT(carried, 0);
}

// What no longer fits is lost, and its carries with it: bytes before the mark stay.
TEST(RangeCoder, GoesBackFromAnOverflow) {
  Pcg32 random(78);
  int overflows = 0;
  for (int run = 0; run < 3000; ++run) {
    const auto kept = random_symbols(random, random.below(60));
    std::vector<std::uint8_t> expected(400), got(400);
    RangeEncoder whole(expected);
    const std::size_t fits = encode(kept, whole);
    RangeEncoder coder({got.data(), fits + random.below(4)});
    std::vector<BitModel> models(kModels);
    for (const Symbol& s : kept)
      s.raw_bits != 0 ? coder.raw(s.value, s.raw_bits) : coder.bit(models[s.model], s.value != 0);
    ASSERT_FALSE(coder.overflow());
    const RangeEncoder::Mark mark = coder.mark();
    for (int i = 0; i < 500; ++i) coder.raw(random.below(4) != 0 ? 1 : 0, 1);
    overflows += coder.overflow() ? 1 : 0;
    coder.go_back(mark);
    ASSERT_EQ(coder.finish(), fits);
    expected.resize(fits);
    got.resize(fits);
    ASSERT_EQ(got, expected) << run;
  }
  EXPECT_EQ(overflows, 3000);
}

TEST(RangeCoder, GivesBackEveryDecisionAndLeavesNoByte) {
  for (std::uint64_t seed = 0; seed < 2000; ++seed) {
    Pcg32 random(seed);
    const auto symbols = random_symbols(random, random.below(seed % 10 == 0 ? 3000 : 60));
    std::vector<std::uint8_t> bytes(2 * symbols.size() + 16);
    RangeEncoder encoder(bytes);
    bytes.resize(encode(symbols, encoder));
    ASSERT_FALSE(encoder.overflow());
    RangeDecoder decoder(bytes);
    ASSERT_EQ(matching(symbols, decoder), symbols.size()) << seed;
    ASSERT_FALSE(decoder.truncated()) << seed;
    ASSERT_FALSE(decoder.trailing()) << seed;
  }
}

TEST(RangeCoder, SixZerosBehindAStreamAreTrailing) {
  for (std::uint64_t seed = 0; seed < 300; ++seed) {
    Pcg32 random(seed);
    const auto symbols = random_symbols(random, random.below(200));
    std::vector<std::uint8_t> bytes(2 * symbols.size() + 16);
    RangeEncoder encoder(bytes);
    bytes.resize(encode(symbols, encoder));
    bytes.resize(bytes.size() + 9);
    RangeDecoder decoder(bytes);
    ASSERT_EQ(matching(symbols, decoder), symbols.size());
    ASSERT_TRUE(decoder.trailing()) << seed;
  }
}

TEST(RangeCoder, AStreamThatWasCutIsNoticedOrEndsEarly) {
  Pcg32 random(3);
  const auto symbols = random_symbols(random, 500);
  std::vector<std::uint8_t> bytes(2000);
  RangeEncoder encoder(bytes);
  bytes.resize(encode(symbols, encoder));
  for (std::size_t cut = 0; cut + 9 <= bytes.size(); ++cut) {
    RangeDecoder decoder{std::span(bytes).first(cut)};
    const bool all = matching(symbols, decoder) == symbols.size();
    EXPECT_TRUE(!all || decoder.truncated()) << cut;
  }
}

TEST(RangeCoder, CostsCloseToTheEntropy) {
  Pcg32 random(4);
  constexpr std::size_t kCount = 200'000;
  for (const double chance : {0.5, 0.1, 0.01}) {
    std::vector<std::uint8_t> bytes(kCount);
    RangeEncoder encoder(bytes);
    BitModel model;
    for (std::size_t i = 0; i < kCount; ++i) encoder.bit(model, random.uniform() < chance);
    const double bits = 8.0 * static_cast<double>(encoder.finish()) / kCount;
    const double entropy = -chance * std::log2(chance) - (1 - chance) * std::log2(1 - chance);
    EXPECT_LT(bits, entropy * 1.06 + 0.001) << chance;
    EXPECT_GT(bits, entropy * 0.97) << chance;
  }
}

TEST(RangeCoder, AFullBufferIsToldAndNothingIsWrittenPastIt) {
  Pcg32 random(5);
  const auto symbols = random_symbols(random, 300);
  std::vector<std::uint8_t> whole(2000);
  RangeEncoder reference(whole);
  const std::size_t needed = encode(symbols, reference);
  for (std::size_t room = 0; room <= needed + 6; ++room) {
    std::vector<std::uint8_t> bytes(room + 8, 0xa5);
    RangeEncoder encoder{std::span(bytes).first(room)};
    const std::size_t used = encode(symbols, encoder);
    ASSERT_LE(used, room);
    for (std::size_t i = room; i < bytes.size(); ++i) ASSERT_EQ(bytes[i], 0xa5);
    if (room < needed) ASSERT_TRUE(encoder.overflow()) << room;
    if (room >= needed + 5) ASSERT_FALSE(encoder.overflow()) << room;
    if (!encoder.overflow())
      ASSERT_TRUE(std::equal(whole.begin(), whole.begin() + used, bytes.begin()));
  }
}

TEST(RangeCoder, RandomBytesDecodeToValuesInRange) {
  Pcg32 random(6);
  for (int i = 0; i < 500; ++i) {
    std::vector<std::uint8_t> bytes(random.below(60));
    for (auto& b : bytes) b = static_cast<std::uint8_t>(random.next());
    RangeDecoder decoder(bytes);
    BitModel model;
    for (int n = 0; n < 400; ++n) {
      const int bits = 1 + static_cast<int>(random.below(16));
      ASSERT_LT(decoder.raw(bits), 1U << bits);
      (void)decoder.bit(model);
    }
    ASSERT_TRUE(decoder.truncated());
  }
}

TEST(BitModel, ProbabilityStaysOffTheEndsAndFollowsTheDecisions) {
  for (const bool value : {false, true}) {
    BitModel model;
    for (int i = 0; i < 5000; ++i) {
      ASSERT_GE(model.probability(), 15U);
      ASSERT_LE(model.probability(), 65520U);
      model.update(value);
    }
    EXPECT_EQ(model.probability() > 32768, value);
    EXPECT_LT(value ? 65536 - model.probability() : model.probability(), 120U);
    // After a long run of one value the other makes itself felt within a few decisions.
    for (int i = 0; i < 60; ++i) model.update(!value);
    EXPECT_EQ(model.probability() > 32768, !value);
  }
}

// Whatever it starts at, no decision is without a chance.
TEST(BitModel, NoStartLeadsToAnEnd) {
  for (const bool value : {false, true}) {
    for (std::uint32_t start = 8; start < 65536; start += 16) {
      BitModel model(static_cast<std::uint16_t>(start), static_cast<std::uint8_t>(start % 127));
      for (int i = 0; i < 300; ++i) {
        model.update(value);
        ASSERT_GT(model.probability(), 0U);
        ASSERT_LT(model.probability(), 65536U);
      }
    }
  }
}

// What docs/wire-format.md says of the probabilities, by the starts there are.
TEST(BitModel, ShippedStartsStayInside) {
  const auto lowest = [](const BitModel& start) {
    std::uint32_t least = 65536;
    for (const bool value : {false, true}) {
      BitModel model = start;
      for (int i = 0; i < 3000; ++i) {
        model.update(value);
        least = std::min(least, std::min(model.probability(), 65535 - model.probability()));
      }
    }
    return least;
  };
  for (const bool lossless : {false, true}) {
    for (const BitModel& start :
         std::bit_cast<std::array<BitModel, kTileModelCount>>(trained_models(lossless)))
      ASSERT_GE(lowest(start), 32U);
  }
  const PointModels& points = trained_point_models();
  const auto* counts = reinterpret_cast<const BitModel*>(&points.single);
  for (std::size_t i = 0; i < kCountModelCount; ++i) ASSERT_GE(lowest(counts[i]), 15U);
}

TEST(BitModel, YoungModelsLearnFast) {
  BitModel model;
  EXPECT_EQ(model.probability(), 32768U);
  model.update(true);
  EXPECT_GT(model.probability(), 49000U);
  model.update(true);
  EXPECT_GT(model.probability(), 57000U);
}

}  // namespace
}  // namespace planecast
