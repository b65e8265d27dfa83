// Trains what every point slice starts from and writes
// core/wire/point_*_trained.inc:
//   train_points bench/train_points.list core/wire
// and then pack_starts core/wire.
// LIST names clouds, their units, tolerances [m] and slice sizes. Every
// decision of every slice is counted with its contexts: a model's start is the
// share of ones over all slices, and what it counts as seen follows from how
// much that share differs between slices.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "bench/point_run.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/point_syntax.hpp"
#include "core/wire/point_tree.hpp"
#include "core/wire/range_decoder.hpp"

namespace {

using namespace planecast;
using bench::PointRun;

// One model over all slices.
struct Tally {
  double ones = 0, all = 0;           // of the slice at hand
  double sum = 0, weight = 0;         // over the slices before
  double squares = 0, slices_of = 0;  // for the spread between slices

  void end_slice() {
    if (all == 0) return;
    const double p = ones / all;
    sum += ones;
    weight += all;
    squares += all * p * p;
    slices_of += 1;
    ones = all = 0;
  }
  double mean() const { return (sum + 0.4) / (weight + 0.8); }
  // Decisions of its own after which a slice knows as much as the mean does.
  double trust() const {
    if (weight < 4) return 0;
    const double m = mean(), p = sum / weight;
    const double noise = m * (1 - m) * slices_of / weight;
    const double between = squares / weight - p * p - noise;
    return std::min(m * (1 - m) / std::max(between, 1e-4 * m * (1 - m)) - 1, weight / 4);
  }
};

// Decodes as the unpacker does, and counts.
struct TrainIo {
  static constexpr bool kReads = true;
  RangeDecoder& coder;
  PointModels& models;
  std::vector<Tally>& occupancy;
  std::vector<Tally>& counts;

  std::uint32_t raw(std::uint32_t, int bits) noexcept { return coder.raw(bits); }
  bool bit(BitModel& model, bool) noexcept {
    const bool value = coder.bit(model);
    const auto at = &model - reinterpret_cast<BitModel*>(&models.single);
    counts[static_cast<std::size_t>(at)].all += 1;
    counts[static_cast<std::size_t>(at)].ones += value ? 1 : 0;
    return value;
  }
  bool bit_at(std::uint32_t probability, bool) noexcept { return coder.bit_at(probability); }
  void watch(MixedModel* const (&contexts)[3], bool value) noexcept {
    for (const MixedModel* context : contexts) {
      const auto at = context - reinterpret_cast<MixedModel*>(&models.occupancy);
      occupancy[static_cast<std::size_t>(at)].all += 1;
      occupancy[static_cast<std::size_t>(at)].ones += value ? 1 : 0;
    }
  }
  bool failed() const noexcept { return coder.truncated(); }
  std::uint32_t octant(std::uint32_t, unsigned) const noexcept { return 0; }
  std::uint32_t count(std::uint32_t) const noexcept { return 0; }
  Status emit(const std::array<std::uint32_t, 3>&, std::uint32_t) const noexcept {
    return Status::kOk;
  }
};

struct Training {
  std::vector<Tally> occupancy = std::vector<Tally>(kOccupancyModelCount);
  std::vector<Tally> counts = std::vector<Tally>(kCountModelCount);
  std::vector<double> weights = std::vector<double>(kPointWeightCount);
  double points = 0;

  bool add(PointRun& run, std::span<const std::uint8_t> packet) {
    RangeDecoder coder(packet.subspan(kPacketHeaderBytes));
    PointModels models = trained_point_models();
    PointMixers mixers = trained_point_mixers();
    TrainIo io{coder, models, occupancy, counts};
    if (io.raw(0, 2) != static_cast<std::uint32_t>(PointSliceKind::kCoded)) return true;
    PointHead head;
    if (point_head(io, head) != Status::kOk) return false;
    const std::uint32_t depth = io.raw(0, 6), group = io.raw(0, 2);
    PointTree<TrainIo> tree(io, models, mixers, run.levels());
    if (tree.code(depth, group, head.points, 0) != Status::kOk) return false;
    for (Tally& tally : occupancy) tally.end_slice();
    for (Tally& tally : counts) tally.end_slice();
    const auto* weight = reinterpret_cast<const std::int32_t*>(&mixers);
    for (std::size_t i = 0; i < kPointWeightCount; ++i)
      weights[i] += head.points * double(weight[i]);
    points += head.points;
    return true;
  }
};

// Trust by class, which point_models.cpp unfolds.
template <std::size_t N>
std::string starts(const std::vector<Tally>& tallies, const int (&classes)[N]) {
  std::string text;
  for (std::size_t i = 0; i < tallies.size(); ++i) {
    int kind = 0;
    while (kind + 1 < static_cast<int>(N) && classes[kind + 1] <= tallies[i].trust()) ++kind;
    const long p = std::clamp(std::lround(tallies[i].mean() * 4096 - 0.5), 2L, 4093L);
    text += fmt::format("{}{}", i == 0 ? "" : (i % 16 != 0 ? "," : ",\n"), p << 4 | kind);
  }
  return text + "\n";
}

bool write(const std::string& path, const std::string& text) {
  std::ofstream file(path);
  return static_cast<bool>(file << text);
}

int fail(const std::string& what) {
  fmt::print(stderr, "train_points: {}\n", what);
  return 1;
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) return fail("usage: train_points LIST FOLDER");
  std::ifstream list(argv[1]);
  if (!list) return fail(std::string(argv[1]) + " cannot be read");
  Training training;
  for (std::string line; std::getline(list, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string file;
    double units = 1, tolerance = 0;
    std::size_t slice_bytes = 0;
    if (!(words >> file >> units >> tolerance >> slice_bytes)) return fail("cannot read: " + line);
    auto run = PointRun::open(bench::data_path(file), units, tolerance);
    if (!run.ok()) return fail(run.error().message);
    const Status packed = (*run)->pack(slice_bytes);
    if (packed != Status::kOk) return fail(line + ": " + std::string(to_string(packed)));
    for (std::uint32_t i = 0; i < (*run)->report().slices; ++i)
      if (!training.add(**run, (*run)->packet(i))) return fail(line + ": a slice does not decode");
  }
  if (training.points == 0) return fail("no points");
  std::string weights;
  for (std::size_t i = 0; i < kPointWeightCount; ++i) {
    weights += fmt::format("{}{}", i == 0 ? "" : (i % 9 != 0 ? ", " : ",\n"),
                           std::lround(training.weights[i] / training.points));
  }
  constexpr int kSeen[16] = {0, 1, 2, 3, 4, 5, 6, 8, 10, 12, 16, 20, 26, 34, 46, 60};
  constexpr int kTrust[16] = {0, 1, 2, 3, 5, 7, 11, 14, 18, 24, 30, 38, 48, 70, 90, 120};
  const std::string folder = argv[2];
  if (!write(folder + "/point_occupancy_trained.inc", starts(training.occupancy, kSeen)) ||
      !write(folder + "/point_counts_trained.inc", starts(training.counts, kTrust)) ||
      !write(folder + "/point_weights_trained.inc", weights + "\n")) {
    return fail(folder + ": cannot write");
  }
  return 0;
}
