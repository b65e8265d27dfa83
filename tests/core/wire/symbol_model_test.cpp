// Symbols of sixteen: what goes in comes out at close to its entropy, the eight lanes at a time do
// what one by one does, and no symbol ever becomes impossible.
#include "core/wire/symbol_model.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <memory>
#include <vector>

#include "core/base/random.hpp"
#include "core/predict/residual_context.hpp"
#include "core/wire/range_decoder.hpp"
#include "core/wire/range_encoder.hpp"
#include "core/wire/residual_models.hpp"

namespace planecast {
namespace {

int skewed(Pcg32& random, double chance) {
  int symbol = 0;
  while (symbol < 15 && random.uniform() > chance) ++symbol;
  return symbol;
}

// As the specification says it.
struct PlainModel {
  int age = 0;
  int bounds[17] = {};
  PlainModel() {
    for (int i = 0; i <= 16; ++i) bounds[i] = 2048 * i;
  }
  void update(int symbol) {
    const int rate = age < 2 ? 2 : age < 4 ? 3 : age < 10 ? 4 : age < 24 ? 5 : 6;
    for (int i = 1; i < 16; ++i)
      bounds[i] += (8 * i + (i > symbol ? 32640 : 0) - bounds[i]) >> rate;
    age = std::min(age + 1, 24);
  }
};

TEST(SymbolModel, DoesWhatOneByOneDoesAndKeepsEverySymbolPossible) {
  Pcg32 random(1);
  for (const double chance : {0.02, 0.3, 0.9, 1.0}) {
    SymbolModel model;
    PlainModel plain;
    for (int n = 0; n < 3000; ++n) {
      const int symbol = skewed(random, chance);
      ASSERT_EQ(model.low(symbol), static_cast<std::uint32_t>(plain.bounds[symbol]));
      ASSERT_EQ(model.high(symbol), static_cast<std::uint32_t>(plain.bounds[symbol + 1]));
      for (int s = 0; s < 16; ++s) {
        ASSERT_LT(plain.bounds[s], plain.bounds[s + 1]);
        ASSERT_EQ(model.find(plain.bounds[s]), s);
        ASSERT_EQ(model.find(plain.bounds[s + 1] - 1), s);
      }
      model.update(symbol);
      plain.update(symbol);
    }
  }
}

TEST(SymbolModel, ComesOutAsItWentInAtCloseToItsEntropy) {
  Pcg32 random(2);
  constexpr int kCount = 50'000;
  for (const double chance : {0.1, 0.5, 0.95}) {
    std::vector<int> symbols(kCount);
    double counts[16] = {}, entropy = 0;
    for (int& s : symbols) ++counts[s = skewed(random, chance)];
    for (const double c : counts) entropy -= c > 0 ? c / kCount * std::log2(c / kCount) : 0;
    std::vector<std::uint8_t> bytes(kCount);
    RangeEncoder encoder(bytes);
    SymbolModel models[2];
    for (const int s : symbols) encoder.symbol(models[0], s);
    bytes.resize(encoder.finish());
    EXPECT_LT(8.0 * static_cast<double>(bytes.size()) / kCount, entropy * 1.06 + 0.01);
    RangeDecoder decoder(bytes);
    for (const int s : symbols) ASSERT_EQ(decoder.symbol(models[1]), s);
    EXPECT_FALSE(decoder.truncated());
    EXPECT_FALSE(decoder.trailing());
  }
}

TEST(SymbolModel, AnyBytesDecodeToASymbol) {
  Pcg32 random(3);
  for (int i = 0; i < 300; ++i) {
    std::vector<std::uint8_t> bytes(random.below(60));
    for (auto& b : bytes) b = static_cast<std::uint8_t>(random.next());
    RangeDecoder decoder(bytes);
    SymbolModel model;
    for (int n = 0; n < 1000; ++n) {
      const int symbol = decoder.symbol(model);
      ASSERT_TRUE(symbol >= 0 && symbol < 16);
    }
  }
}

TEST(SymbolModel, TrainedStartsRiseAndLeaveEverySymbolRoom) {
  const auto check = [](const auto& models) {
    for (const SymbolModel& model : models) {
      ASSERT_GE(model.bounds[0], 0);
      ASSERT_LE(model.bounds[0], detail::kMaxSymbolAge);
      for (int s = 0; s < 16; ++s) ASSERT_GE(model.high(s), model.low(s) + 1);
    }
  };
  for (const bool every_count : {false, true}) {
    const auto models = std::make_unique<ResidualModels>();
    unpack_residuals(every_count, *models);
    check(models->shape);
    check(models->errors);
  }
}

TEST(SymbolPair, IsTheMeanOfItsModelsWhichBothLearn) {
  Pcg32 random(4);
  SymbolModel first, second;
  PlainModel plain[2];
  for (int n = 0; n < 3000; ++n) {
    if (n % 50 < 10) {  // apart, so that the mean is of two different ones
      const int symbol = skewed(random, 0.9);
      first.update(symbol);
      plain[0].update(symbol);
    }
    SymbolPair pair(first, second);
    const auto bound = [&](int i) { return (plain[0].bounds[i] + plain[1].bounds[i] + 1) / 2; };
    const int symbol = skewed(random, 0.2);
    for (int s = 0; s < 16; ++s) {
      ASSERT_EQ(pair.low(s), static_cast<std::uint32_t>(bound(s)));
      ASSERT_EQ(pair.high(s), static_cast<std::uint32_t>(bound(s + 1)));
      ASSERT_LT(bound(s), bound(s + 1));
      ASSERT_EQ(pair.find(bound(s)), s);
      ASSERT_EQ(pair.find(bound(s + 1) - 1), s);
    }
    pair.update(symbol);
    for (PlainModel& p : plain) p.update(symbol);
  }
}

TEST(ResidualSymbol, TellsEveryNearResidualApart) {
  for (std::int32_t residual = -kMostNear; residual <= kMostNear; ++residual) {
    const ResidualSymbol coded = residual_symbol(residual);
    ASSERT_LT(coded.symbol, kFarSymbol);
    const std::int32_t size =
        residual_base(coded.symbol) + (coded.symbol > 8 ? std::int32_t{coded.extra} : 0);
    EXPECT_EQ((coded.symbol & 1) != 0 ? size : -size, residual);
    EXPECT_LT(coded.extra, 1U << residual_bits(coded.symbol));
  }
}

}  // namespace
}  // namespace planecast
