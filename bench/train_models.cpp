// Trains the probabilities that every tile starts from and writes them to standard output:
//   train_models LIST decisions > core/wire/tile_models_trained.inc
//   train_models LIST residuals > core/wire/residual_models_trained.inc
// and then pack_starts core/wire.
// LIST (train_models.list) holds a command line a row: inputs and codec options. Symbols of
// residuals are counted, decisions taken from the decoder's models at the end of each slice.
#include <fmt/format.h>

#include <bit>
#include <string>
#include <vector>

#include "bench/depth_training.hpp"
#include "bench/residual_counts.hpp"

namespace {

using namespace planecast;
using Contexts = std::vector<bench::Context>;

// What is learnt: decisions of lossless and of bounded streams, and lossless residuals.
struct Learnt {
  Contexts decisions[2] = {Contexts(kTileModelCount), Contexts(kTileModelCount)};
  ResidualCounts residuals;

  void add(const TileUnpacker& unpacker, bool lossless) {
    const auto began =
        std::bit_cast<std::array<BitModel, kTileModelCount>>(trained_models(lossless));
    const auto ended = std::bit_cast<std::array<BitModel, kTileModelCount>>(unpacker.models());
    for (std::size_t i = 0; i < kTileModelCount; ++i) {
      const double seen =
          ended[i].age() == detail::kMaxBitAge ? 126.0 : ended[i].age() - began[i].age();
      if (seen > 0) decisions[lossless ? 0 : 1][i].add(ended[i].slow() / 65536.0, seen);
    }
  }
};

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc == 3 ? argv[2] : "";
  if (what != "decisions" && what != "residuals") {
    fmt::print(stderr, "usage: train_models LIST decisions|residuals\n");
    return 2;
  }
  Learnt learnt;
  bench::DepthTraining run{.program = "train_models", .lossless_only = what == "residuals"};
  run.tile = [&](const CodingTables& tables, const TileUnpacker& unpacker,
                 const TileContent& content, auto depth, auto labels) {
    learnt.add(unpacker, tables.bounds->lossless());
    if (tables.bounds->lossless()) learnt.residuals.add(tables, content, depth, labels);
  };
  run.end_input = [&] { learnt.residuals.end_input(); };
  if (const int code = bench::train_depth(argv[1], run); code != 0) return code;
  if (what == "residuals") {
    for (const bool every_count : {false, true}) {
      const std::vector<SymbolModel> starts = learnt.residuals.starts(every_count);
      for (std::size_t i = 0; i < starts.size(); ++i) {
        fmt::print("{}", i == 0 ? "    {{" : (i == kShapeContexts ? "     {" : "      "));
        const std::int16_t* bounds = starts[i].bounds;
        if (bounds[0] != 0) fmt::print("{{{{{}}}}}", fmt::join(bounds, bounds + 16, ", "));
        fmt::print("{}{}\n", bounds[0] == 0 ? "{}" : "",  // nothing is known
                   i + 1 == starts.size()    ? "}},"
                   : i + 1 == kShapeContexts ? "},"
                                             : ",");
      }
    }
    return 0;
  }
  for (const Contexts& set : learnt.decisions) {
    fmt::print("    {{");
    for (std::size_t i = 0; i < set.size(); ++i) {
      fmt::print("{}0x{:04x}", i == 0 ? "" : (i % 14 == 0 ? ",\n     " : ", "),
                 bench::start_of(set[i]));
    }
    fmt::print("}},\n");
  }
  return 0;
}
