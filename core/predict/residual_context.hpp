// Lossless streams: how a level's residual (level - prediction) becomes one symbol of sixteen, and
// the context that the symbol is coded in (docs/wire-format.md, "Residuals"). Both halves share it.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "core/predict/pixel_predictor.hpp"

namespace planecast {

inline constexpr int kEnergyClasses = 8;
inline constexpr int kLeanClasses = 14;
inline constexpr int kResidualContexts = kActivityClasses * kEnergyClasses * kLeanClasses;
inline constexpr int kResidualSymbols = 16;
/// The symbol of what is further than kMostNear from its prediction, or off the levels.
inline constexpr int kFarSymbol = 15;
inline constexpr int kMostNear = 18;
/// Residual sizes count up to this in contexts.
inline constexpr int kMostEnergy = 8;

namespace detail {

/// Class of the residuals around, by 2 |l| + 2 |u| + |ul| + |ur|.
struct EnergyTable {
  std::array<std::uint8_t, 6 * kMostEnergy + 1> of{};
  constexpr EnergyTable() {
    constexpr int kMost[kEnergyClasses - 1] = {0, 1, 2, 4, 7, 12, 20};
    for (int sum = 0; sum <= 6 * kMostEnergy; ++sum) {
      int c = 0;
      while (c < kEnergyClasses - 1 && (sum + 1) / 2 > kMost[c]) ++c;
      of[static_cast<std::size_t>(sum)] = static_cast<std::uint8_t>(c);
    }
  }
};
inline constexpr EnergyTable kEnergy{};

}  // namespace detail

/// Number of a residual's model, and whether its sign is turned over before it is coded: what leans
/// down is coded as what leans up.
struct ResidualContext {
  std::uint32_t model = 0;
  std::int32_t turned = 0;  ///< 0, or -1 to turn
};

[[gnu::always_inline]] inline ResidualContext residual_context(const Neighbourhood& n,
                                                               std::int32_t prediction) noexcept {
  const PixelPast& l = n.here.past[n.at - 1];
  const PixelPast& u = n.above.past[n.at];
  const std::int32_t sum = std::min(detail::activity_sum(n, 0), 255);
  const std::uint32_t activity = detail::kActivity.of[0][static_cast<std::size_t>(sum)];
  const std::uint32_t energy =
      detail::kEnergy
          .of[2U * (l.size + u.size) + n.above.past[n.at - 1].size + n.above.past[n.at + 1].size];
  const std::int32_t left = n.l();
  const std::int32_t tilt = (prediction < left) - (prediction > left);
  const std::int32_t lean = 9 * tilt + 3 * l.lean + u.lean;
  const std::int32_t turned = lean >> 31;
  return {(activity * kEnergyClasses + energy) * kLeanClasses +
              static_cast<std::uint32_t>((lean ^ turned) - turned),
          turned};
}

/// A residual as its symbol, and the bits that tell the residuals of that symbol apart.
struct ResidualSymbol {
  std::uint8_t symbol = 0;
  std::uint8_t extra = 0;  ///< in residual_bits(symbol) bits
};

/// Raw bits that follow a near symbol.
inline int residual_bits(int symbol) noexcept {
  return symbol < 9 ? 0 : (symbol - 7) >> 1;
}

/// Smallest residual of a near symbol, in size.
inline std::int32_t residual_base(int symbol) noexcept {
  constexpr std::uint8_t kBase[8] = {0, 1, 2, 3, 4, 5, 7, 11};
  return kBase[(symbol + 1) >> 1];
}

namespace detail {

/// Symbols of the residuals -kMostNear .. kMostNear: noise is what no branch could foresee.
struct ResidualTable {
  std::array<ResidualSymbol, 2 * kMostNear + 1> of{};
  constexpr ResidualTable() {
    for (int residual = -kMostNear; residual <= kMostNear; ++residual) {
      const auto size = static_cast<unsigned>(residual < 0 ? -residual : residual);
      ResidualSymbol& out = of[static_cast<std::size_t>(residual + kMostNear)];
      // One more bit for each doubling of what lies beyond 4.
      const unsigned bits = size <= 4 ? 0 : static_cast<unsigned>(std::bit_width(size - 3)) - 1;
      const unsigned range = size <= 4 ? size : 4 + bits;
      if (size != 0) out.symbol = static_cast<std::uint8_t>(2 * range - (residual < 0 ? 0 : 1));
      if (size > 4) out.extra = static_cast<std::uint8_t>(size - 3 - (1U << bits));
    }
  }
};
inline constexpr ResidualTable kResidualSymbols{};

}  // namespace detail

/// The symbol of a residual of at most kMostNear in size, turned already.
inline ResidualSymbol residual_symbol(std::int32_t residual) noexcept {
  return detail::kResidualSymbols.of[static_cast<std::size_t>(residual + kMostNear)];
}

/// Leaves what later pixels need of a pixel whose residual is known.
[[gnu::always_inline]] inline void keep_residual(PixelRow& row, std::size_t at,
                                                 const PixelPrediction& p,
                                                 std::int32_t level) noexcept {
  const auto miss = [&](std::int32_t predicted) {
    return static_cast<std::uint32_t>(std::min(std::abs(level - predicted), kMissCap));
  };
  const std::int32_t residual = level - p.level;
  row.level[at] = static_cast<std::uint16_t>(level);
  row.past[at] = {miss(p.surface) << 16U | miss(p.neighbour),
                  static_cast<std::uint8_t>(std::min(std::abs(residual), kMostEnergy)),
                  static_cast<std::int8_t>((residual > 0) - (residual < 0)), 0};
}

}  // namespace planecast
