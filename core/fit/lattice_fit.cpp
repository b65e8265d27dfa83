#include "core/fit/lattice_fit.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <vector>

#include "core/predict/level_table.hpp"

namespace planecast {
namespace {

struct DepthCount {
  std::uint32_t depth;
  std::uint32_t readings;
};

constexpr std::uint32_t kMinDistinct = 24;
constexpr double kClearSpacing = 3.0;  // counts between levels, so that rounding blurs little
constexpr double kTwoPi = 6.283185307179586;

std::vector<DepthCount> distinct_depths(std::span<const std::uint16_t> depth) {
  std::vector<std::uint32_t> histogram(65536, 0);
  for (const std::uint16_t d : depth) ++histogram[d];
  std::vector<DepthCount> out;
  for (std::uint32_t d = 1; d < 65535; ++d) {
    if (histogram[d] != 0) out.push_back({d, histogram[d]});
  }
  return out;
}

double spacing(double c, double depth) {
  return depth * depth / c;
}

// Mean phasor of C / depth over the depths where levels lie clearly apart; 1 when C is right.
std::complex<double> coherence(const std::vector<DepthCount>& depths, double c, double& weight) {
  std::complex<double> sum = 0;
  weight = 0;
  for (const DepthCount& d : depths) {
    if (spacing(c, d.depth) < kClearSpacing) continue;
    const double w = std::sqrt(static_cast<double>(d.readings));
    sum += w * std::polar(1.0, kTwoPi * c / d.depth);
    weight += w;
  }
  return weight > 0 ? sum / weight : 0;
}

// Readings that the lattice explains where its levels lie apart, and readings there are.
struct Score {
  std::uint64_t explained = 0;
  std::uint64_t of = 0;
  double share() const {
    return of == 0 ? 0.0 : static_cast<double>(explained) / static_cast<double>(of);
  }
};

Score score(const std::vector<DepthCount>& depths, const Lattice& lattice) {
  Score out;
  const double c = lattice.c_q8 / 256.0;
  for (const DepthCount& d : depths) {
    if (spacing(c, d.depth) < 1.0) continue;
    out.of += d.readings;
    const double k = c / d.depth - lattice.offset_q16 / 65536.0;
    for (int near = -1; near <= 1; ++near) {
      const auto step = static_cast<std::int64_t>(std::llround(k)) + near;
      if (step >= 1 && lattice_depth(lattice, static_cast<std::uint64_t>(step)) == d.depth) {
        out.explained += d.readings;
        break;
      }
    }
  }
  return out;
}

// For a fixed offset: the C that lies in most rounding intervals (low + depth)(k + offset) <= C <
// (high + depth)(k + offset), weighted by readings, near the guess.
double best_constant(const std::vector<DepthCount>& depths, double guess, double offset,
                     bool truncated) {
  struct Edge {
    double c;
    double change;
  };
  std::vector<Edge> edges;
  const double low = truncated ? 0.0 : -0.5;
  for (const DepthCount& d : depths) {
    if (spacing(guess, d.depth) < 1.0) continue;
    const double k = std::round(guess / (d.depth + low + 0.5) - offset);
    if (k < 1) continue;
    const double w = std::min<double>(d.readings, 50);
    edges.push_back({(d.depth + low) * (k + offset), w});
    edges.push_back({(d.depth + low + 1) * (k + offset), -w});
  }
  std::sort(edges.begin(), edges.end(), [](const Edge& a, const Edge& b) { return a.c < b.c; });
  double sum = 0, most = 0, best = guess;
  for (std::size_t i = 0; i + 1 < edges.size(); ++i) {
    sum += edges[i].change;
    if (sum > most) {
      most = sum;
      best = (edges[i].c + edges[i + 1].c) / 2;
    }
  }
  return best;
}

Lattice to_lattice(double c, double offset, bool truncated) {
  Lattice out;
  out.c_q8 = static_cast<std::uint32_t>(std::llround(c * 256));
  out.offset_q16 = static_cast<std::uint32_t>(std::llround(offset * 65536)) & 0xffffU;
  out.truncated = truncated;
  return out;
}

// Tries offsets around a guess, rounded and cut, and keeps the lattice that explains most.
Lattice refine(const std::vector<DepthCount>& depths, double c, double offset) {
  Lattice best;
  std::uint64_t most = 0;
  const auto attempt = [&](double o, bool truncated) {
    double constant = c + (o - offset) * 0.0;
    for (int i = 0; i < 3; ++i) constant = best_constant(depths, constant, o, truncated);
    const Lattice lattice = to_lattice(constant, o, truncated);
    const Score s = score(depths, lattice);
    if (s.explained > most) {
      most = s.explained;
      best = lattice;
    }
  };
  for (const bool truncated : {false, true}) {
    attempt(0.0, truncated);
    for (int i = -60; i <= 60; ++i) {
      double o = offset + i * 0.002;
      o -= std::floor(o);
      attempt(o, truncated);
    }
  }
  const double coarse = best.offset_q16 / 65536.0;
  const bool truncated = best.truncated;
  for (int i = -20; i <= 20; ++i) {
    double o = coarse + i * 0.0001;
    o -= std::floor(o);
    attempt(o, truncated);
  }
  return best;
}

}  // namespace

std::optional<Lattice> find_lattice(std::span<const std::uint16_t> depth) {
  std::vector<DepthCount> depths = distinct_depths(depth);
  if (depths.size() < kMinDistinct) return std::nullopt;
  const double farthest = depths.back().depth;
  // Far counts tell the lattice best; the most frequent of them are enough for the search.
  std::vector<DepthCount> some = depths;
  if (some.size() > 256) {
    std::nth_element(
        some.begin(), some.begin() + 256, some.end(), [](const DepthCount& a, const DepthCount& b) {
          return std::uint64_t{a.readings} * a.depth > std::uint64_t{b.readings} * b.depth;
        });
    some.resize(256);
  }
  double found = 0, found_coherence = 0;
  const double most_c = std::min(farthest * farthest / kClearSpacing, 16.0e6);
  double total = 0;
  for (const DepthCount& d : some) total += std::sqrt(static_cast<double>(d.readings));
  for (double c = farthest * 4; c < most_c; c += 0.08 * std::sqrt(kClearSpacing * c)) {
    double weight = 0;
    const double value = std::abs(coherence(some, c, weight));
    // A few far counts agree with anything; a harmonic of what was found agrees no better.
    if (weight < 0.15 * total || value < 0.6) continue;
    if (value > found_coherence + 0.1) {
      found = c;
      found_coherence = value;
    } else if (value > found_coherence && c < found * 1.05) {
      found = c;
      found_coherence = value;
    }
  }
  if (found == 0) return std::nullopt;
  double weight = 0;
  double offset = std::arg(coherence(some, found, weight)) / kTwoPi;
  if (offset < 0) offset += 1;
  const Lattice lattice = refine(depths, found, offset);
  if (!lattice.present()) return std::nullopt;
  const Score s = score(depths, lattice);
  std::uint64_t readings = 0;
  for (const DepthCount& d : depths) readings += d.readings;
  if (s.share() < 0.99 || s.of * 20 < readings) return std::nullopt;
  return lattice;
}

}  // namespace planecast
