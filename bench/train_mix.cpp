// Trains the probabilities that every tile of --effort best starts from, and the weights of its
// mixers:
//   train_mix LIST core/wire/mix_weights_trained.inc > core/wire/mix_models_trained.inc
// and then pack_starts core/wire.
// LIST (train_models.list) holds a command line a row: inputs and codec options.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <vector>

#include "bench/depth_training.hpp"

namespace {

using namespace planecast;
using Contexts = std::vector<bench::Context>;

// What is trained, for lossless ([0]) and for bounded streams.
struct Training {
  Contexts starts[2];
  std::vector<double> weights[2];
  std::vector<double> tiles[2];  ///< in which a weight moved
};

// Adds a tile's mixed models, in the order of their starts.
void add_mixed(const MixModels& start, const MixModels& end, Contexts& set) {
  std::size_t at = 0;
  const auto add = [&](const MixedModel& began, const MixedModel& ended) {
    const double seen = ended.seen == detail::kMostSeen ? 150.0 : ended.seen - began.seen;
    if (seen > 0) set[at].add(ended.slow / 65536.0, seen);
    ++at;
  };
  for (int c = 0; c < kAllPixelContexts; ++c) {
    for (int slot = 0; slot < kPixelSlots; ++slot) add(start.pixel[c][slot], end.pixel[c][slot]);
  }
  constexpr int kNearest = kMaskInputContexts[0], kWide = kMaskInputContexts[kWideMask];
  for (int c = 0; c < kAllMaskContexts; ++c) {
    if (c < kNearest || c >= kNearest + kWide) add(start.mask[c], end.mask[c]);
  }
}

// Adds a tile's mixers that were used.
void add_weights(const MixModels& start, const MixModels& end, Training& training, int set) {
  std::size_t at = 0;
  const auto add = [&](const auto& began, const auto& ended) {
    const bool used = !std::equal(std::begin(began.weight), std::end(began.weight), ended.weight);
    for (const std::int32_t w : ended.weight) {
      training.weights[set][at] += used ? w : 0;
      training.tiles[set][at++] += used ? 1 : 0;
    }
  };
  for (int slot = 0; slot < kPixelSlots; ++slot) {
    for (int m = 0; m < kPixelMixers; ++m)
      add(start.pixel_mixers[slot][m], end.pixel_mixers[slot][m]);
  }
  for (int m = 0; m < kMaskMixers; ++m) add(start.mask_mixers[m], end.mask_mixers[m]);
}

// A set of numbers between braces.
template <class Number>
void print_set(std::FILE* out, std::size_t count, Number number) {
  fmt::print(out, "    {{");
  for (std::size_t i = 0; i < count; ++i)
    fmt::print(out, "{}{}", i == 0 ? "" : (i % 14 == 0 ? ",\n     " : ", "), number(i));
  fmt::print(out, "}},\n");
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 3) {
    fmt::print(stderr, "usage: train_mix LIST WEIGHTS.inc > core/wire/mix_models_trained.inc\n");
    return 2;
  }
  Training training;
  for (int set = 0; set < 2; ++set) {
    training.starts[set].resize(kMixStarts);
    training.weights[set].resize(kMixWeights);
    training.tiles[set].resize(kMixWeights);
  }
  bench::DepthTraining run{.program = "train_mix", .effort = Effort::kBest};
  run.tile = [&](const CodingTables& tables, const TileUnpacker& unpacker,
                 const TileContent& content, auto, auto) {
    if (!content.mixed) return;
    const bool lossless = tables.bounds->lossless();
    const MixModels& start = trained_mix_models(lossless);
    add_mixed(start, unpacker.mix_models(), training.starts[lossless ? 0 : 1]);
    add_weights(start, unpacker.mix_models(), training, lossless ? 0 : 1);
  };
  if (const int code = bench::train_depth(argv[1], run); code != 0) return code;
  for (const Contexts& starts : training.starts) {
    print_set(stdout, starts.size(),
              [&](std::size_t i) { return fmt::format("0x{:04x}", bench::start_of(starts[i])); });
  }
  std::FILE* out = std::fopen(argv[2], "w");
  if (out != nullptr) {
    for (int set = 0; set < 2; ++set) {
      print_set(out, kMixWeights, [&](std::size_t i) {
        const double tiles = training.tiles[set][i];
        return fmt::to_string(tiles > 0 ? std::lround(training.weights[set][i] / tiles / 256) : 77);
      });
    }
  }
  if (out != nullptr && std::fclose(out) == 0) return 0;
  fmt::print(stderr, "train_mix: {}: cannot be written\n", argv[2]);
  return 1;
}
