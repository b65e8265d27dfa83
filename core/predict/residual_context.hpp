// Lossless streams: how a level's residual (level - prediction) becomes one symbol of sixteen, and
// the context that the symbol is coded in (docs/wire-format.md, "Residuals"). Both halves share it.
#pragma once

#include <array>
#include <bit>
#include <cstdint>
#include <cstdlib>

#include "core/predict/pixel_predictor.hpp"

namespace planecast {

inline constexpr int kResidualSymbols = 16;
/// The symbol of what is further than kMostNear from its prediction, or off the levels.
inline constexpr int kFarSymbol = 15;
inline constexpr int kMostNear = 18;
/// Residual sizes count up to this in contexts.
inline constexpr int kMostEnergy = 8;

/// A residual is coded by how the levels around lie; where a sensor says every count, by the mean
/// of that and of how far off the predictions around were.
inline constexpr int kEnergyClasses = 12;
inline constexpr int kLeanClasses = 14;
inline constexpr int kRoughnessClasses = 3;
inline constexpr int kErrorContexts = kEnergyClasses * kLeanClasses * kRoughnessClasses;
inline constexpr int kShapes = 7 * 7 * 7 * 3;
inline constexpr int kShapeContexts = kShapes * 3;

namespace detail {

/// Class of the residuals around, by 2 |l| + 2 |u| + |ul| + |ur| + |ll| + |uu|: up to 3 exactly,
/// from there two a doubling.
struct EnergyTable {
  std::array<std::uint8_t, 8 * kMostEnergy + 1> of{};
  constexpr EnergyTable() {
    for (unsigned sum = 0; sum < of.size(); ++sum) {
      const int length = static_cast<int>(std::bit_width(sum));
      const int fine =
          sum < 4
              ? static_cast<int>(sum)
              : 2 * length - 2 + static_cast<int>((sum >> static_cast<unsigned>(length - 2)) & 1U);
      of[sum] = static_cast<std::uint8_t>(fine < kEnergyClasses ? fine : kEnergyClasses - 1);
    }
  }
};
inline constexpr EnergyTable kEnergy{};

/// A slope between neighbours in seven grades: -3..3 for 0, +-1, +-2 up to 3 and more levels.
struct GradeTable {
  std::array<std::int8_t, 9> of = {-3, -2, -2, -1, 0, 1, 2, 2, 3};
};
inline constexpr GradeTable kGrade{};

/// Where the shapes begin by the sizes of the residuals to the left and above, added up: none, up
/// to 2, more.
struct SizeShapeTable {
  std::array<std::int16_t, 2 * kMostEnergy + 1> of{};
  constexpr SizeShapeTable() {
    for (int sum = 1; sum <= 2 * kMostEnergy; ++sum)
      of[static_cast<std::size_t>(sum)] =
          static_cast<std::int16_t>(sum > 2 ? 2 * kShapes : kShapes);
  }
};
inline constexpr SizeShapeTable kSizeShapes{};

inline std::int32_t slope_grade(std::int32_t difference) noexcept {
  return kGrade.of[static_cast<std::size_t>(std::clamp(difference, -4, 4) + 4)];
}

/// What the levels around a pixel say of it, how far they are apart and how they slope.
struct LevelsAround {
  std::int32_t neighbour = 1;
  std::int32_t apart = 0;   ///< as activity_sum() of no half-width
  std::int32_t slopes = 0;  ///< grades of l - ul, u - ul and ur - u as digits of base seven
};

[[gnu::noinline]] inline LevelsAround levels_around_holes(const Neighbourhood& n,
                                                          std::int32_t fallback) noexcept {
  const auto slope = [](std::int32_t a, std::int32_t b) {
    return a != 0 && b != 0 ? slope_grade(a - b) : 0;
  };
  return {neighbour_prediction(n, fallback), activity_sum(n, 0),
          49 * slope(n.l(), n.ul()) + 7 * slope(n.u(), n.ul()) + slope(n.ur(), n.u())};
}

/// Where a sensor says every count its noise spans several levels, of which the median of three
/// keeps most: there a slanted mean predicts, unless the neighbours are all one or an edge is near.
[[gnu::always_inline]] inline LevelsAround levels_around(const Neighbourhood& n,
                                                         std::int32_t fallback, bool every_count,
                                                         std::int32_t last_level) noexcept {
  const std::int32_t l = n.l(), u = n.u(), ul = n.ul(), ur = n.ur();
  if (((l - 1) | (u - 1) | (ul - 1) | (ur - 1)) < 0) [[unlikely]]  // a hole
    return levels_around_holes(n, fallback);
  LevelsAround out;
  out.apart = std::abs(l - ul) + std::abs(u - ul) + std::abs(u - ur);
  out.slopes = 49 * slope_grade(l - ul) + 7 * slope_grade(u - ul) + slope_grade(ur - u);
  const std::int32_t low = lesser(l, u), high = l + u - low;
  const std::int32_t capped = lesser(l + u - ul, high);
  out.neighbour = low + capped - lesser(low, capped);
  if (every_count && out.apart >= 2 && out.apart <= 60)
    out.neighbour = std::clamp((6 * l + 5 * u + 2 * ur - 5 * ul + 4) >> 3, 1, last_level);
  return out;
}

}  // namespace detail

/// Prediction of a pixel of a lossless stream, and what its residual's context needs.
struct LosslessPrediction : PixelPrediction {
  std::int32_t apart = 0, slopes = 0;
};

/// `every_count`: the stream's levels are no lattice.
[[gnu::always_inline]] inline LosslessPrediction predict_lossless(const Neighbourhood& n,
                                                                  const PixelPlace& place,
                                                                  std::int32_t fallback,
                                                                  bool every_count) noexcept {
  const detail::LevelsAround around =
      detail::levels_around(n, fallback, every_count, place.last_level);
  return {predict_from(n, place, around.neighbour), around.apart, around.slopes};
}

/// Number of a residual's model by shape, and whether its sign is turned over before it is coded:
/// what leans down is coded as what leans up.
struct ResidualContext {
  std::uint32_t shape = 0;
  std::int32_t turned = 0;  ///< 0, or -1 to turn
  std::int32_t lean = 0;    ///< 0..13, turned
};

[[gnu::always_inline]] inline ResidualContext residual_context(
    const Neighbourhood& n, const LosslessPrediction& p) noexcept {
  const PixelPast& l = n.here.past[n.at - 1];
  const PixelPast& u = n.above.past[n.at];
  const std::int32_t left = n.l();
  const std::int32_t tilt = (p.level < left) - (p.level > left);
  const std::int32_t lean = 9 * tilt + 3 * l.lean + u.lean;
  const std::int32_t turned = lean >> 31;
  const std::int32_t shape = ((3 * p.slopes + tilt) ^ turned) - turned + kShapes / 2;
  const auto size = static_cast<std::size_t>(l.size + u.size);
  return {static_cast<std::uint32_t>(shape + detail::kSizeShapes.of[size]), turned,
          (lean ^ turned) - turned};
}

/// Number of a residual's model by the errors around.
[[gnu::always_inline]] inline std::uint32_t errors_context(const Neighbourhood& n,
                                                           const LosslessPrediction& p,
                                                           const ResidualContext& c) noexcept {
  const PixelRow &here = n.here, &above = n.above;
  const std::uint32_t energy =
      detail::kEnergy
          .of[2U * (here.past[n.at - 1].size + above.past[n.at].size) + above.past[n.at - 1].size +
              above.past[n.at + 1].size + here.past[n.at - 2].size + n.above2.past[n.at].size];
  const std::uint32_t roughness = std::uint32_t{p.apart > 1} + std::uint32_t{p.apart > 4};
  return (energy * kLeanClasses + static_cast<std::uint32_t>(c.lean)) * kRoughnessClasses +
         roughness;
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
