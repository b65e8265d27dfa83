#include "bench/depth_training.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
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
#include "core/wire/key_packet.hpp"

namespace planecast::bench {
namespace {

int fail(const DepthTraining& training, const std::string& what) {
  fmt::print(stderr, "{}: {}\n", training.program, what);
  return to_int(ExitCode::kFailed);
}

std::string data_folder() {
  const char* folder = std::getenv("PLANECAST_DATA");
  return folder != nullptr ? folder : "../shared/data";
}

// Decodes every slice of an input's frames.
int decode_all(const DepthTraining& training, const CodecOptions& options,
               const std::vector<std::string>& inputs) {
  auto source = open_source(inputs, options);
  if (!source.ok()) return fail(training, source.error().message);
  SensorFrame frame;
  auto more = (*source)->next(frame);
  if (!more.ok()) return fail(training, more.error().message);
  const auto setup = setup_stream(options, (*source)->sensor(), frame);
  if (!setup.ok()) return fail(training, setup.error().message);
  const bool lossless = setup->encoder.stream.tolerance == ToleranceKind::kLossless;
  if (training.lossless_only && !lossless) return 0;
  auto codec = FrameCodec::create(*setup, options.slice_bytes - 10);
  if (!codec.ok()) return fail(training, codec.error().message);
  const CodingTables tables = codec->encoder().tables().coding();
  const CameraModel& camera = tables.config->camera;
  Arena measuring = Arena::measuring();
  TileUnpacker unpacker;
  unpacker.layout(measuring, camera.width);
  auto arena = Arena::map(measuring.bytes_needed());
  unpacker.layout(*arena, camera.width);
  std::vector<std::uint16_t> depth(camera.pixels());
  std::vector<std::uint8_t> labels(camera.pixels());
  for (; more.ok() && *more; more = (*source)->next(frame)) {
    const auto coded = codec->encode(*setup, frame);
    if (!coded.ok()) return fail(training, coded.error().message);
    for (const auto& packet : coded->packets) {
      TileContent content;
      const Status status = unpacker.unpack(tables, std::span(packet).subspan(kPacketHeaderBytes),
                                            {depth, labels}, content);
      if (status != Status::kOk || content.verbatim) continue;
      training.tile(tables, unpacker, content, depth, labels);
    }
  }
  training.end_input();
  return 0;
}

int train_line(const DepthTraining& training, const std::string& line) {
  std::istringstream words(line);
  std::vector<std::string> arguments{std::istream_iterator<std::string>(words), {}};
  std::vector<const char*> argv{training.program};
  for (std::string& a : arguments) {
    if (a[0] == '@') a = data_folder() + a.substr(1);
    argv.push_back(a.c_str());
  }
  CLI::App app;
  CodecOptions options;
  std::vector<std::string> inputs;
  app.add_option("inputs", inputs);
  add_codec_options(app, options);
  if (const auto ended =
          parse_command_line(app, static_cast<int>(argv.size()), argv.data(), options)) {
    return to_int(*ended);
  }
  options.effort = training.effort;
  return decode_all(training, options, inputs);
}

}  // namespace

void Context::add(double p, double seen) {
  const double w = std::min(seen, 48.0);
  weight += w;
  sum += w * p;
  squares += w * p * p;
  noise += w * p * (1 - p) / w;  // what counting few decisions adds
}

double Context::trust() const {
  if (weight < 40) return 0;
  const double m = mean();
  const double between = squares / weight - (sum / weight) * (sum / weight) - noise / weight;
  return m * (1 - m) / std::max(between, 1e-4 * m * (1 - m)) - 1;
}

std::uint16_t start_of(const Context& context) {
  constexpr double kTrusts[16] = {0, 1, 2, 3, 5, 7, 11, 14, 18, 24, 30, 38, 48, 70, 90, 120};
  const double trust = context.trust();
  int age = 0;
  while (age < 15 && kTrusts[age + 1] <= trust) ++age;
  const long p = std::clamp(std::lround(context.mean() * 4096 - 0.5), 2L, 4093L);
  return static_cast<std::uint16_t>(p << 4 | age);
}

int train_depth(const std::string& list, const DepthTraining& training) {
  std::ifstream lines(list);
  if (!lines) return fail(training, fmt::format("{}: cannot be read", list));
  for (std::string line; std::getline(lines, line);) {
    if (line.empty() || line[0] == '#') continue;
    if (const int code = train_line(training, line); code != 0) return code;
  }
  return 0;
}

}  // namespace planecast::bench
