// How the trained starts of models lie in the program: packed, a third of what they take as tables.
// bench/pack_starts writes them from the tables (trained_tables.hpp), which say what they are; the
// library unpacks them once.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>

#include "core/wire/bit_mixer.hpp"
#include "core/wire/symbol_model.hpp"

namespace planecast {

/// Models of one kind of value, by each of three contexts; every decision mixes those of the three.
template <std::size_t Contexts, std::size_t Decisions>
struct StartModels {
  MixedModel of[3][Contexts][Decisions];
  BitMixer<3> mixers[Decisions];
};

/// Those of a value whose contexts are known.
struct StartView {
  MixedModel* of[3];
  BitMixer<3>* mixers;

  template <std::size_t Contexts, std::size_t Decisions>
  StartView(StartModels<Contexts, Decisions>& models, std::size_t a, std::size_t b,
            std::size_t c) noexcept
      : of{models.of[0][a], models.of[1][b], models.of[2][c]}, mixers(models.mixers) {}
};

/// Reads or writes a value's decision `at` as `Io` does (start_io.hpp); `want` is what to write.
template <class Io>
[[gnu::noinline]] bool code_bit(Io& io, const StartView& view, std::size_t at, bool want) noexcept {
  MixedModel* const models[3] = {view.of[0] + at, view.of[1] + at, view.of[2] + at};
  const MixedBit<3> mixed(view.mixers[at], models);
  const bool bit = io.bit_at(mixed.probability, want);
  mixed.learn(view.mixers[at], models, bit);
  return bit;
}

/// A number below 2^16 by how many bits it has and the one below the leading one: 33 decisions.
inline constexpr std::size_t kNumberDecisions = 33;
template <class Io>
[[gnu::noinline]] std::uint32_t code_number(Io& io, const StartView& view,
                                            std::uint32_t want) noexcept {
  const auto wanted = static_cast<std::uint32_t>(std::bit_width(want));
  std::uint32_t width = 0;
  while (width < 16 && code_bit(io, view, width, width < wanted)) ++width;
  if (width < 2) return width;
  const std::uint32_t rest = width - 2;
  const std::uint32_t top =
      2U + std::uint32_t{code_bit(io, view, 16 + width, (want >> rest & 1U) != 0)};
  if (rest == 0) return top;
  return top << rest | io.raw(want & ((1U << rest) - 1U), static_cast<int>(rest));
}

/// One of `bits` bits, each by those above it: 2^bits decisions.
template <class Io>
[[gnu::noinline]] std::uint32_t code_tree(Io& io, const StartView& view, int bits,
                                          std::uint32_t want) noexcept {
  std::uint32_t node = 1;
  for (int bit = bits - 1; bit >= 0; --bit)
    node = 2 * node + std::uint32_t{code_bit(io, view, node, (want >> bit & 1U) != 0)};
  return node - (1U << bits);
}

/// Starts of sixteen bits, a probability in 1/4096 above a class of what is known (0: nothing):
/// each by the one `stride` places before it, of the second of two sets by the first's.
template <class Io>
class StartWords {
 public:
  [[gnu::noinline]] explicit StartWords(Io& io) noexcept : io_(io) {
    for (auto& past : past_) past.fill(kEven);
  }

  void set_stride(std::size_t stride) noexcept { stride_ = stride; }

  /// The next start of one set.
  [[gnu::noinline]] std::uint16_t next(std::uint16_t want = 0) noexcept {
    return past_[0][at_++ & 255U] = code(before(0, stride_), before(0, 1), want);
  }
  /// The next start of each of two sets.
  [[gnu::noinline]] std::array<std::uint16_t, 2> next_of_both(
      std::array<std::uint16_t, 2> want = {}) noexcept {
    const std::uint16_t up = before(1, stride_);
    const std::uint16_t first = code(before(0, stride_), before(0, 1), want[0]);
    const std::uint16_t second = code((first & 15U) != 0 ? first : up, before(1, 1), want[1]);
    past_[0][at_ & 255U] = first;
    past_[1][at_++ & 255U] = second;
    return {first, second};
  }
  /// The next weight, which is like the one `stride` before.
  [[gnu::noinline]] std::int32_t next_weight(std::int32_t want = 0) noexcept {
    const std::int32_t near = static_cast<std::int16_t>(before(0, stride_));
    const std::int32_t away = want - near;
    const auto folded = static_cast<std::uint32_t>(away < 0 ? -2 * away - 1 : 2 * away);
    const std::uint32_t read = code_number(io_, StartView(weights_, last_, 0, phase()), folded);
    last_ = std::min<std::uint32_t>(read, 15);
    const auto half = static_cast<std::int32_t>(read + 1) >> 1;
    const std::int32_t weight = near + ((read & 1U) != 0 ? -half : half);
    past_[0][at_++ & 255U] = static_cast<std::uint16_t>(weight);
    return weight;
  }

 private:
  static constexpr std::uint16_t kEven = 0x8000;

  std::uint16_t before(std::size_t set, std::size_t places) const noexcept {
    return past_[set][(at_ - places) & 255U];
  }
  std::size_t phase() const noexcept { return at_ % stride_ & 15U; }

  [[gnu::noinline]] std::uint16_t code(unsigned a, unsigned b, unsigned want) noexcept {
    const std::uint32_t known =
        code_tree(io_, StartView(classes_, a & 15U, b & 15U, phase()), 4, want & 15U);
    const std::size_t half = known != 0 ? 16 : 0;
    const StartView tops(tops_, half + (a >> 12U), half + (b >> 12U), half + phase());
    // Decision 0: nothing is known, and the start even.
    if (known == 0 && code_bit(io_, tops, 0, want == kEven)) return kEven;
    const std::uint32_t top = code_tree(io_, tops, 5, want >> 11U);
    const std::uint32_t low = io_.raw(want >> 4U & 127U, 7);
    return static_cast<std::uint16_t>(top << 11U | low << 4U | known);
  }

  Io& io_;
  std::size_t stride_ = 1, at_ = 0;
  std::uint32_t last_ = 0;
  std::array<std::uint16_t, 256> past_[2];
  StartModels<16, 16> classes_;
  StartModels<32, 32> tops_;
  StartModels<16, kNumberDecisions> weights_;
};

/// A start of a symbol model as it is packed. Most come from few symbols: their shares follow from
/// the counts.
struct ResidualStart {
  std::uint8_t age_class = 0;
  std::uint16_t seen = 0;        ///< symbols counted; 0: the shares are given
  std::uint16_t least = 0;       ///< smallest share where they are given
  std::uint16_t parts[16] = {};  ///< counts, or shares beyond the smallest

  static constexpr std::array<std::uint8_t, 8> kAges = {0, 2, 6, 12, 16, 20, 24, 24};
  static constexpr std::uint32_t kShares = 32768 - 128;

  /// As bench/residual_counts.hpp has it: (count + 0.3) / (seen + 4.8) of kShares for each symbol
  /// and 8 besides, the bounds rounded.
  SymbolModel model() const noexcept {
    SymbolModel out;
    out.bounds[0] = kAges[age_class & 7U];
    const std::uint32_t all = 10U * seen + 48;
    std::uint32_t below = 0;
    for (std::uint32_t s = 1; s < 16; ++s) {
      below += parts[s - 1];
      const std::uint32_t share =
          seen != 0 ? (2 * (10 * below + 3 * s) * kShares + all) / (2 * all) : below + least * s;
      out.bounds[s] = static_cast<std::int16_t>(share + 8 * s);
    }
    return out;
  }
};

/// Starts of residuals, context by context of both sets: each by that of the other set, or by the
/// one before.
template <class Io>
class ResidualStarts {
 public:
  [[gnu::noinline]] explicit ResidualStarts(Io& io) noexcept : io_(io) {}

  /// Whether a start is known, and the start.
  struct Row {
    bool known = false;
    ResidualStart start;

    SymbolModel model() const noexcept { return known ? start.model() : SymbolModel{}; }
  };

  /// The next of a set, the first set's and the second's in turn.
  [[gnu::noinline]] Row next(bool second, const Row& want = {}) noexcept {
    const bool other = second && now_[0].known;
    Row row;
    const StartView view(known_, second, now_[second].known, other);
    row.known = code_tree(io_, view, 1, want.known) != 0;
    if (row.known) {
      row.start = code(other ? now_[0].start : last_[second], other, want.start);
      last_[second] = row.start;
    }
    now_[second] = row;
    return row;
  }

 private:
  static std::size_t width_of(std::uint32_t number) noexcept {
    return std::min<std::size_t>(static_cast<std::size_t>(std::bit_width(number)), 15);
  }

  [[gnu::noinline]] ResidualStart code(const ResidualStart& near, bool other,
                                       const ResidualStart& want) noexcept {
    ResidualStart out;
    out.age_class = static_cast<std::uint8_t>(code_tree(
        io_, StartView(ages_, other, near.age_class & 7U, width_of(near.seen)), 3, want.age_class));
    std::uint32_t left = 0;
    const StartView kind(counted_, other, near.seen != 0, width_of(near.seen));
    const bool counted = code_tree(io_, kind, 1, want.seen != 0) != 0;
    const StartView size(sizes_[counted], other, width_of(near.seen), width_of(near.least));
    if (counted) {
      left = code_number(io_, size, want.seen);
      out.seen = static_cast<std::uint16_t>(left);
    } else {
      out.least = static_cast<std::uint16_t>(code_number(io_, size, want.least));
      left = ResidualStart::kShares - std::min(16U * out.least, ResidualStart::kShares);
    }
    std::uint32_t near_left = 0;
    for (const std::uint16_t part : near.parts) near_left += part;
    for (std::size_t s = 0; s < 15 && left > 0; ++s) {
      const std::uint32_t like = std::max<std::uint32_t>(near.parts[s], 1);
      const std::uint32_t guess = left * like / std::max(near_left, like);
      const StartView view(parts_[counted], width_of(guess), s, width_of(left));
      const std::uint32_t part = std::min(code_number(io_, view, want.parts[s]), left);
      out.parts[s] = static_cast<std::uint16_t>(part);
      left -= part;
      near_left -= near.parts[s];
    }
    out.parts[15] = static_cast<std::uint16_t>(left);
    return out;
  }

  Io& io_;
  Row now_[2];
  ResidualStart last_[2];
  StartModels<2, 2> known_;
  StartModels<16, 2> counted_;
  StartModels<16, 8> ages_;
  StartModels<16, kNumberDecisions> sizes_[2], parts_[2];
};

}  // namespace planecast
