// One walk over a raw tile that both halves instantiate: the encoder's Io writes each decision and
// gives it back, the decoder's reads it, so the two cannot disagree (docs/wire-format.md, "Raw
// tile").
#pragma once

#include "core/base/status.hpp"
#include "core/wire/raw_syntax.hpp"

namespace planecast {

/// Walks one tile. Io: bool bit(BitModel&, bool), uint32 raw(uint32, int bits), bool failed(), and
/// kReads, true where points are written. Memory is the caller's; nothing is allocated.
template <class Io>
class RawTile {
 public:
  using Points = std::span<std::conditional_t<Io::kReads, Point3f, const Point3f>>;

  RawTile(Io& io, const CameraModel& camera, RawModels& models, std::span<RawState> states) noexcept
      : io_(io), camera_(camera), models_(models), states_(states) {}

  /// Verbatim flag and rectangle; kFieldRange when the rectangle leaves the image.
  Status head(bool& verbatim, TileRect& rect) noexcept {
    verbatim = io_.raw(verbatim ? kVerbatimTile : kModelled, 1) == kVerbatimTile;
    const int xb = position_bits(blocks_wide(camera_));
    const int yb = position_bits(blocks_high(camera_));
    rect.bx = io_.raw(rect.bx, xb);
    rect.by = io_.raw(rect.by, yb);
    rect.bw = io_.raw(rect.bw - 1, std::min(xb, 8)) + 1;
    rect.bh = io_.raw(rect.bh - 1, std::min(yb, 8)) + 1;
    const bool inside =
        rect.bx + rect.bw <= blocks_wide(camera_) && rect.by + rect.bh <= blocks_high(camera_);
    return inside ? Status::kOk : Status::kFieldRange;
  }

  /// The rays a modelled tile predicts by. kFieldRange: a number that is not finite, or no axis.
  Status rays(RawRays& rays) noexcept {
    rays.present = io_.raw(rays.present ? 1 : 0, 1) != 0;
    rays.primary = static_cast<std::uint8_t>(io_.raw(rays.primary, 2));
    if (rays.primary > 2) return Status::kFieldRange;
    if (!rays.present) return Status::kOk;
    bool finite = true;
    for (double& value : rays.slope) finite &= number(value);
    for (auto& row : rays.ratio) {
      for (double& value : row) finite &= number(value);
    }
    const std::uint32_t steps = io_.raw(static_cast<std::uint32_t>(rays.steps), 2);
    if (steps > 2) return Status::kFieldRange;
    rays.steps = static_cast<DepthSteps>(steps);
    if (rays.steps != DepthSteps::kNone) finite &= number(rays.origin) && number(rays.step);
    return finite ? Status::kOk : Status::kFieldRange;
  }

  /// All points as float bits.
  Status verbatim(const TileSpan& span, Points points, std::uint32_t& readings) noexcept {
    for (std::uint32_t v = span.v0; v < span.v1 && !io_.failed(); ++v) {
      for (std::uint32_t u = span.u0; u < span.u1; ++u) {
        Point3f point = points[std::size_t{v} * camera_.width + u];
        if (!Io::kReads && !is_reading(point)) point = hole_point();
        for (float* f : {&point.x, &point.y, &point.z}) *f = word(*f);
        const bool reading = is_reading(point);
        readings += reading ? 1 : 0;
        if constexpr (Io::kReads)
          points[std::size_t{v} * camera_.width + u] = reading ? point : hole_point();
      }
    }
    return Status::kOk;
  }

  /// All points by prediction. kBadSymbol: a residual that no encoder writes.
  Status modelled(const TileSpan& span, const RawRays& rays, Points points,
                  std::uint32_t& readings) noexcept {
    rays_ = rays;
    const std::uint32_t columns = span.u1 - span.u0;
    const std::size_t row_size = row_states((columns + 7) / 8);
    std::fill_n(states_.begin(), 2 * row_size, RawState{});
    for (auto& cost : costs_) cost[0] = rays.present ? 0U : 1U << 20U;
    for (std::uint32_t v = span.v0; v < span.v1 && !io_.failed(); ++v) {
      const std::uint32_t parity = (v - span.v0) & 1U;
      current_ = states_.data() + parity * row_size + kRowBorder;
      above_ = states_.data() + (1 - parity) * row_size + kRowBorder;
      for (std::uint32_t x = 0; x < columns; ++x) {
        const std::uint32_t u = span.u0 + x;
        auto& point = points[std::size_t{v} * camera_.width + u];
        const bool reading =
            io_.bit(models_.mask[mask_number(x)], !Io::kReads && is_reading(point));
        current_[x] = RawState{};
        if (!reading) {
          if constexpr (Io::kReads) point = hole_point();
          continue;
        }
        ++readings;
        RawState state;
        if constexpr (!Io::kReads) {
          state.at[0] = point.x;
          state.at[1] = point.y;
          state.at[2] = point.z;
        }
        if (const Status status = code_point(u, v, x, state); status != Status::kOk) return status;
        current_[x] = state;
        last_ = state;
        if constexpr (Io::kReads) point = {state.at[0], state.at[1], state.at[2]};
      }
    }
    return Status::kOk;
  }

 private:
  static constexpr int kCandidates = 4;

  bool number(double& value) noexcept {
    const auto bits = std::bit_cast<std::uint64_t>(value);
    std::uint64_t read = 0;
    for (int part = 3; part >= 1; --part)
      read |= std::uint64_t{io_.raw(static_cast<std::uint32_t>(bits >> (16 * part)) & 0xffffU, 16)}
              << (16 * part);
    value = std::bit_cast<double>(read);
    return ((read >> 52U) & 0x7ffU) != 0x7ffU;
  }

  float word(float value) noexcept {
    const auto bits = std::bit_cast<std::uint32_t>(value);
    const std::uint32_t high = io_.raw(bits >> 16U, 16);
    return std::bit_cast<float>((high << 16U) | io_.raw(bits & 0xffffU, 16));
  }

  std::uint32_t mask_number(std::uint32_t x) const noexcept {
    const RawState* c = current_ + x;
    const RawState* a = above_ + x;
    const auto left = [&](int back) {
      return std::uint32_t{x >= static_cast<std::uint32_t>(back) && (c - back)->valid};
    };
    return left(1) | left(2) << 1U | std::uint32_t{(a - 1)->valid} << 2U |
           std::uint32_t{a->valid} << 3U | std::uint32_t{(a + 1)->valid} << 4U |
           std::uint32_t{(a + 2)->valid} << 5U;
  }

  const RawState& left(std::uint32_t x) const noexcept { return x > 0 ? current_[x - 1] : empty_; }

  /// Median of left, above and left + above - above-left of an integer property of the states.
  template <class Get>
  std::int64_t median(std::uint32_t x, Get&& get) const noexcept {
    const RawState& l = left(x);
    const RawState& u = above_[x];
    const RawState& ul = *(above_ + x - 1);
    if (l.valid && u.valid) {
      const std::int64_t a = get(l), b = get(u);
      if (!ul.valid) return (a + b) >> 1;
      return std::clamp(a + b - get(ul), std::min(a, b), std::max(a, b));
    }
    if (l.valid) return get(l);
    if (u.valid) return get(u);
    const RawState& ur = above_[x + 1];
    return ur.valid ? get(ur) : get(last_);
  }

  /// Codes value - predicted (both below 2^32 apart from each other) and returns value.
  std::int64_t residual(int kind, std::uint32_t x, std::int64_t predicted, std::int64_t value,
                        std::int8_t& size) noexcept {
    const int l = left(x).size[kind], u = above_[x].size[kind];
    const std::int64_t difference = value - predicted;
    const bool negative = difference < 0;
    const auto magnitude = static_cast<std::uint32_t>(negative ? -difference : difference);
    const auto length = tree(models_.size[kind][size_context(std::abs(l) + std::abs(u))],
                             static_cast<std::uint32_t>(std::bit_width(magnitude)));
    size = 0;
    if (length == 0) return predicted;
    const int sides = (l > 0) - (l < 0) + 3 * ((u > 0) - (u < 0)) + 4;
    const bool below = io_.bit(models_.sign[kind][sides], negative);
    size = static_cast<std::int8_t>(below ? -static_cast<int>(length) : static_cast<int>(length));
    const std::int64_t found = bits_below(models_.top[kind][std::min(length, 32U)],
                                          static_cast<int>(std::min(length, 32U)), magnitude);
    if (length > 32) return std::int64_t{1} << 40U;  // only in corrupt streams: never in range
    return below ? predicted - found : predicted + found;
  }

  std::uint32_t tree(BitModel* models, std::uint32_t value) noexcept {
    std::uint32_t node = 1;
    for (int i = 5; i >= 0; --i)
      node = node * 2 + (io_.bit(models[node], ((value >> i) & 1U) != 0) ? 1 : 0);
    return node - 64;
  }

  /// The bits of `magnitude` below its leading one: two with models, the rest as they are.
  std::uint32_t bits_below(BitModel* models, int length, std::uint32_t magnitude) noexcept {
    std::uint32_t found = 1;
    int rest = length - 1;
    for (int node = 1, i = 0; i < 2 && rest > 0; ++i) {
      --rest;
      const bool bit = io_.bit(models[node], ((magnitude >> rest) & 1U) != 0);
      found = found * 2 + (bit ? 1 : 0);
      node = node * 2 + (bit ? 1 : 0);
    }
    if (rest > 16) {
      found = (found << (rest - 16)) |
              io_.raw((magnitude >> 16U) & ((1U << (rest - 16)) - 1U), rest - 16);
      rest = 16;
    }
    return rest == 0 ? found : (found << rest) | io_.raw(magnitude & ((1U << rest) - 1U), rest);
  }

  static int size_context(int sum) noexcept {
    constexpr int kLimits[kSizeContexts - 1] = {0, 1, 2, 4, 6, 9, 13, 18, 24, 32, 42};
    int context = 0;
    while (context < kSizeContexts - 1 && sum > kLimits[context]) ++context;
    return context;
  }

  Status code_point(std::uint32_t u, std::uint32_t v, std::uint32_t x, RawState& s) noexcept {
    const double px = static_cast<double>(u) - 0.5 * camera_.width;
    const double py = static_cast<double>(v) - 0.5 * camera_.height;
    const double scale = rays_.scale(px, py);
    const int axis = rays_.primary;
    if (rays_.steps != DepthSteps::kNone) {
      if constexpr (!Io::kReads) s.step = nearest_step(s.at[axis], scale);
      const std::int64_t predicted =
          median(x, [](const RawState& n) { return std::int64_t{n.step}; });
      const std::int64_t step = residual(kStepKind, x, predicted, s.step, s.size[kStepKind]);
      if (step > kMaxStepNumber || step < -kMaxStepNumber) return Status::kBadSymbol;
      s.step = static_cast<std::int32_t>(step);
    }
    const std::int64_t first = rays_.steps != DepthSteps::kNone
                                   ? ordered_prediction(rays_.value(s.step, scale))
                                   : median(x, [axis](const RawState& n) {
                                       return std::int64_t{ordered_bits(n.at[axis])};
                                     });
    if (const Status status = code_value(0, x, first, s, axis); status != Status::kOk)
      return status;
    for (int i = 0; i < 2; ++i) {
      if (const Status status = code_other(i, x, px, py, scale, s); status != Status::kOk)
        return status;
    }
    s.valid = true;
    return Status::kOk;
  }

  Status code_value(int kind, std::uint32_t x, std::int64_t predicted, RawState& s,
                    int axis) noexcept {
    const std::int64_t bits = residual(kind, x, predicted, ordered_bits(s.at[axis]), s.size[kind]);
    if (bits < 0 || bits > 0xffffffffLL) return Status::kBadSymbol;
    s.at[axis] = from_ordered_bits(static_cast<std::uint32_t>(bits));
    const bool finite = (std::bit_cast<std::uint32_t>(s.at[axis]) & 0x7f800000U) != 0x7f800000U;
    return finite ? Status::kOk : Status::kBadSymbol;
  }

  /// One of the two other coordinates: the candidate that did best of late predicts it.
  Status code_other(int i, std::uint32_t x, double px, double py, double scale,
                    RawState& s) noexcept {
    const int axis = kOtherCoordinates[rays_.primary][i];
    const double main = s.at[rays_.primary];
    const double ratio =
        rays_.present
            ? (rays_.ratio[i][0] * px + rays_.ratio[i][1] * py + rays_.ratio[i][2]) / scale
            : 0.0;
    const RawState& l = left(x);
    const RawState& u = above_[x];
    const RawState& ul = *(above_ + x - 1);
    double slanted = 0, mean = 0;
    if (l.valid && u.valid) {
      mean = 0.5 * (l.miss[i] + u.miss[i]);
      slanted = ul.valid ? l.miss[i] + u.miss[i] - ul.miss[i] : mean;
    } else if (l.valid || u.valid) {
      mean = slanted = l.valid ? l.miss[i] : u.miss[i];
    }
    const std::int64_t candidates[kCandidates] = {
        ordered_prediction(main * ratio), ordered_prediction(main * (ratio + mean)),
        ordered_prediction(main * (ratio + slanted)),
        median(x, [axis](const RawState& n) { return std::int64_t{ordered_bits(n.at[axis])}; })};
    int best = 0;
    for (int c = 1; c < kCandidates; ++c) {
      if (costs_[i][c] < costs_[i][best]) best = c;
    }
    const Status status = code_value(1 + i, x, candidates[best], s, axis);
    if (status != Status::kOk) return status;
    s.miss[i] = main != 0 ? s.at[axis] / main - ratio : 0.0;
    const std::int64_t bits = ordered_bits(s.at[axis]);
    for (int c = 0; c < kCandidates; ++c) {
      const std::int64_t miss = std::abs(bits - candidates[c]);
      const auto length =
          static_cast<std::uint32_t>(std::bit_width(static_cast<std::uint64_t>(miss)));
      costs_[i][c] += 32 * length - costs_[i][c] / 16;
    }
    return Status::kOk;
  }

  /// The depth step nearest to a primary coordinate; any would do, nearer ones cost less.
  std::int32_t nearest_step(float value, double scale) const noexcept {
    const double depth = value / scale;
    const double s = rays_.steps == DepthSteps::kInverse ? 1.0 / depth : depth;
    const double n = (s - rays_.origin) / rays_.step;
    constexpr auto kMost = static_cast<double>(kMaxStepNumber);
    if (!(n > -kMost)) return -static_cast<std::int32_t>(kMaxStepNumber);
    if (!(n < kMost)) return static_cast<std::int32_t>(kMaxStepNumber);
    return static_cast<std::int32_t>(n < 0 ? n - 0.5 : n + 0.5);
  }

  Io& io_;
  const CameraModel& camera_;
  RawModels& models_;
  std::span<RawState> states_;
  RawRays rays_;
  RawState last_;
  const RawState empty_;
  RawState* current_ = nullptr;
  const RawState* above_ = nullptr;
  std::uint32_t costs_[2][kCandidates] = {};  ///< of each candidate, decaying
};

}  // namespace planecast
