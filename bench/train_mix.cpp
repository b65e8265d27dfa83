// Trains the probabilities that every tile of --effort best starts from, and the weights of its mixers:
//   train_mix LIST core/wire/mix_weights_trained.inc > core/wire/mix_models_trained.inc
// LIST (train_models.list) holds a command line a row: inputs and codec options. The
// decoder's models at the end of each slice are samples of what a start should be: their mean is
// the probability, their spread between slices says how soon a tile should trust itself instead.
#include <fmt/format.h>

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

std::uint16_t start_of(const Context& context) {
  constexpr double kTrusts[16] = {0, 1, 2, 3, 5, 7, 11, 14, 18, 24, 30, 38, 48, 70, 90, 120};
  const double trust = context.trust();
  int age = 0;
  while (age < 15 && kTrusts[age + 1] <= trust) ++age;
  const long p = std::clamp(std::lround(context.mean() * 4096 - 0.5), 2L, 4093L);
  return static_cast<std::uint16_t>(p << 4 | age);
}

int fail(const std::string& what) {
  fmt::print(stderr, "train_mix: {}\n", what);
  return to_int(ExitCode::kFailed);
}

std::string data_folder() {
  const char* folder = std::getenv("PLANECAST_DATA");
  return folder != nullptr ? folder : "../shared/data";
}

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

// Adds every slice of one command line's frames.
bool learn(const std::string& line, Training& training) {
  std::istringstream words(line);
  std::vector<std::string> arguments{std::istream_iterator<std::string>(words), {}};
  std::vector<const char*> argv{"train_mix"};
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
  options.effort = Effort::kBest;
  auto source = open_source(inputs, options);
  if (!source.ok()) return fail(source.error().message), false;
  SensorFrame frame;
  auto more = (*source)->next(frame);
  if (!more.ok()) return fail(more.error().message), false;
  const auto setup = setup_stream(options, (*source)->sensor(), frame);
  if (!setup.ok()) return fail(setup.error().message), false;
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
  for (; more.ok() && *more; more = (*source)->next(frame)) {
    const auto coded = codec->encode(*setup, frame);
    if (!coded.ok()) return fail(coded.error().message), false;
    for (const auto& packet : coded->packets) {
      TileContent content;
      if (unpacker.unpack(tables.coding(), std::span(packet).subspan(kPacketHeaderBytes),
                          {depth, {}}, content) != Status::kOk ||
          content.verbatim) {
        continue;
      }
      const bool lossless = tables.bounds().lossless();
      const int set = lossless ? 0 : 1;
      if (!content.mixed) continue;
      add_mixed(trained_mix_models(lossless), unpacker.mix_models(), training.starts[set]);
      add_weights(trained_mix_models(lossless), unpacker.mix_models(), training, set);
    }
  }
  return true;
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
  if (argc != 3) return fail("usage: train_mix LIST WEIGHTS.inc > core/wire/mix_models_trained.inc");
  std::ifstream list(argv[1]);
  if (!list) return fail(fmt::format("{}: cannot be read", argv[1]));
  Training training;
  for (int set = 0; set < 2; ++set) {
    training.starts[set].resize(kMixStarts);
    training.weights[set].resize(kMixWeights);
    training.tiles[set].resize(kMixWeights);
  }
  for (std::string line; std::getline(list, line);) {
    if (!line.empty() && line[0] != '#' && !learn(line, training)) return 1;
  }
  for (const Contexts& starts : training.starts) {
    print_set(stdout, starts.size(),
              [&](std::size_t i) { return fmt::format("0x{:04x}", start_of(starts[i])); });
  }
  std::FILE* out = std::fopen(argv[2], "w");
  if (out == nullptr) return fail(fmt::format("{}: cannot be written", argv[2]));
  for (int set = 0; set < 2; ++set) {
    print_set(out, kMixWeights, [&](std::size_t i) {
      const double tiles = training.tiles[set][i];
      return fmt::to_string(tiles > 0 ? std::lround(training.weights[set][i] / tiles / 256) : 77);
    });
  }
  return std::fclose(out) == 0 ? 0 : fail(fmt::format("{}: write failed", argv[2]));
}
