// Trains the probabilities that every tile starts from and writes them to standard output:
//   train_models LIST decisions > core/wire/tile_models_trained.inc
//   train_models LIST residuals > core/wire/residual_models_trained.inc
// LIST (train_models.list) holds a command line a row: inputs and codec options. The
// decoder's models at the end of each slice are samples of what a start should be: their mean is
// the probability, their spread between slices says how soon a tile should trust itself instead.
// Symbols of residuals are counted.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <bit>
#include <cmath>
#include <fstream>
#include <iterator>
#include <sstream>
#include <vector>

#include "apps/common/command_line.hpp"
#include "apps/common/frame_codec.hpp"
#include "apps/common/frame_source.hpp"
#include "apps/common/stream_setup.hpp"
#include "bench/residual_counts.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/wire/frame_unpack.hpp"
#include "core/wire/key_packet.hpp"

namespace {

using namespace planecast;

// One context over all slices.
struct Context {
  double weight = 0, sum = 0, squares = 0, noise = 0;

  void add(double p, double seen) {
    const double w = std::min(seen, 48.0);
    weight += w;
    sum += w * p;
    squares += w * p * p;
    noise += w * p * (1 - p) / std::min(seen, 48.0);  // what counting few decisions adds
  }
  double mean() const { return weight > 0 ? (sum + 0.4) / (weight + 0.8) : 0.5; }
  // Decisions of its own after which a tile knows as much as the mean does.
  double trust() const {
    if (weight < 40) return 0;
    const double m = mean();
    const double between = squares / weight - (sum / weight) * (sum / weight) - noise / weight;
    return m * (1 - m) / std::max(between, 1e-4 * m * (1 - m)) - 1;
  }
};

using Contexts = std::vector<Context>;

// What is learnt: decisions of lossless and of bounded streams, and lossless residuals.
struct Learnt {
  Contexts decisions[2] = {Contexts(kTileModelCount), Contexts(kTileModelCount)};
  ResidualCounts residuals;

  void add(const TileUnpacker& unpacker, bool lossless) {
    const auto began =
        std::bit_cast<std::array<BitModel, kTileModelCount>>(trained_models(lossless));
    const auto ended = std::bit_cast<std::array<BitModel, kTileModelCount>>(unpacker.models());
    for (std::size_t i = 0; i < kTileModelCount; ++i) {
      const double seen = ended[i].age == detail::kMaxBitAge ? 126.0 : ended[i].age - began[i].age;
      if (seen > 0) decisions[lossless ? 0 : 1][i].add(ended[i].slow / 65536.0, seen);
    }
  }
};

std::uint16_t start_of(const Context& context) {
  constexpr double kTrusts[16] = {0, 1, 2, 3, 5, 7, 11, 14, 18, 24, 30, 38, 48, 70, 90, 120};
  const double trust = context.trust();
  int age = 0;
  while (age < 15 && kTrusts[age + 1] <= trust) ++age;
  const long p = std::clamp(std::lround(context.mean() * 4096 - 0.5), 2L, 4093L);
  return static_cast<std::uint16_t>(p << 4 | age);
}

int fail(const std::string& what) {
  fmt::print(stderr, "train_models: {}\n", what);
  return to_int(ExitCode::kFailed);
}

std::string data_folder() {
  const char* folder = std::getenv("PLANECAST_DATA");
  return folder != nullptr ? folder : "../shared/data";
}

// Adds every slice of one command line's frames.
bool learn(const std::string& line, bool lossless_only, Learnt& learnt) {
  std::istringstream words(line);
  std::vector<std::string> arguments{std::istream_iterator<std::string>(words), {}};
  std::vector<const char*> argv{"train_models"};
  for (std::string& a : arguments) {
    if (a[0] == '@') a = data_folder() + a.substr(1);
    argv.push_back(a.c_str());
  }
  CLI::App app;
  CodecOptions options;
  std::vector<std::string> inputs;
  app.add_option("inputs", inputs);
  add_codec_options(app, options);
  if (parse_command_line(app, static_cast<int>(argv.size()), argv.data(), options)) return false;
  auto source = open_source(inputs, options);
  if (!source.ok()) return fail(source.error().message), false;
  SensorFrame frame;
  auto more = (*source)->next(frame);
  if (!more.ok()) return fail(more.error().message), false;
  const auto setup = setup_stream(options, (*source)->sensor(), frame);
  if (!setup.ok()) return fail(setup.error().message), false;
  if (lossless_only && setup->encoder.stream.tolerance != ToleranceKind::kLossless) return true;
  auto codec = FrameCodec::create(*setup, options.slice_bytes - 10);
  if (!codec.ok()) return fail(codec.error().message), false;
  const StreamTables& tables = codec->encoder().tables();
  const CameraModel& camera = tables.config().camera;
  Arena measuring = Arena::measuring();
  TileUnpacker unpacker;
  unpacker.layout(measuring, camera.width);
  auto arena = Arena::map(measuring.bytes_needed());
  unpacker.layout(*arena, camera.width);
  std::vector<std::uint16_t> depth(camera.pixels());
  std::vector<std::uint8_t> labels(camera.pixels());
  for (; more.ok() && *more; more = (*source)->next(frame)) {
    const auto coded = codec->encode(*setup, frame);
    if (!coded.ok()) return fail(coded.error().message), false;
    for (const auto& packet : coded->packets) {
      TileContent content;
      if (unpacker.unpack(tables.coding(), std::span(packet).subspan(kPacketHeaderBytes),
                          {depth, labels}, content) != Status::kOk ||
          content.verbatim) {
        continue;
      }
      learnt.add(unpacker, tables.bounds().lossless());
      if (tables.bounds().lossless()) learnt.residuals.add(tables.coding(), content, depth, labels);
    }
  }
  learnt.residuals.end_input();
  return true;
}

}  // namespace

int main(int argc, char** argv) {
  const std::string what = argc == 3 ? argv[2] : "";
  if (what != "decisions" && what != "residuals")
    return fail("usage: train_models LIST decisions|residuals");
  std::ifstream list(argv[1]);
  if (!list) return fail(fmt::format("{}: cannot be read", argv[1]));
  Learnt learnt;
  for (std::string line; std::getline(list, line);) {
    if (!line.empty() && line[0] != '#' && !learn(line, what == "residuals", learnt)) return 1;
  }
  if (what == "residuals") {
    for (std::size_t i = 0; i < kResidualContexts; ++i) {
      const SymbolModel start = learnt.residuals.start(i);
      fmt::print("    {{{{{}", start.bounds[0]);
      for (int s = 1; s < 16; ++s) fmt::print(", {}", start.bounds[s]);
      fmt::print("}}}},\n");
    }
    return 0;
  }
  for (const Contexts& set : learnt.decisions) {
    fmt::print("    {{");
    for (std::size_t i = 0; i < set.size(); ++i) {
      fmt::print("{}0x{:04x}", i == 0 ? "" : (i % 14 == 0 ? ",\n     " : ", "), start_of(set[i]));
    }
    fmt::print("}},\n");
  }
  return 0;
}
