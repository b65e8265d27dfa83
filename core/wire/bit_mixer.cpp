#include "core/wire/bit_mixer.hpp"

namespace planecast::detail {
namespace {

std::array<MixedRate, kMostSeen + 1> make_mixed_rates() noexcept {
  std::array<MixedRate, kMostSeen + 1> rates{};
  const auto rate = [](unsigned seen) {
    return static_cast<std::uint16_t>(655360 / (10 * seen + 16));
  };
  for (unsigned seen = 0; seen <= kMostSeen; ++seen)
    rates[seen] = {rate(std::min(seen, kMostFast)), rate(seen),
                   static_cast<std::uint16_t>(std::min(seen + 1, kMostSeen)), 0};
  return rates;
}

std::array<std::int16_t, 4096> make_stretch() noexcept {
  std::array<std::int16_t, 4096> table{};
  std::int32_t x = -2047;
  for (std::uint32_t p = 0; p < 4096; ++p) {
    while (x < 2047 && squash(x) < p * 16 + 8) ++x;
    table[p] = static_cast<std::int16_t>(x);
  }
  return table;
}

std::array<std::uint16_t, 4096> make_squash() noexcept {
  std::array<std::uint16_t, 4096> table{};
  for (std::int32_t x = -2047; x <= 2047; ++x)
    table[static_cast<std::size_t>(x + 2048)] =
        static_cast<std::uint16_t>(std::clamp<std::uint32_t>(squash(x), 32, 65504));
  return table;
}

}  // namespace

const std::array<MixedRate, kMostSeen + 1> kMixedRates = make_mixed_rates();
const std::array<std::int16_t, 4096> kStretch = make_stretch();
const std::array<std::uint16_t, 4096> kSquash = make_squash();

}  // namespace planecast::detail
