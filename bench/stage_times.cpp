// CPU milliseconds of every stage of both halves, and of counting a cloud's points, frame by frame,
// beside the bits they reach:
//   stage_times INPUT... [codec options]
// One thread; median of 9 runs after 2 warm-ups, or with --least N, for machines that do other
// work, the least of N. The figures of docs/benchmarks.md come from here.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <vector>

#include "apps/common/command_line.hpp"
#include "apps/common/exit_codes.hpp"
#include "apps/common/frame_codec.hpp"
#include "apps/common/frame_source.hpp"
#include "apps/common/stream_setup.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/pipeline/stages.hpp"
#include "core/wire/key_packet.hpp"

namespace {

using namespace planecast;

constexpr int kRuns = 9, kWarmUps = 2;

// How often everything runs, and which of its times counts.
struct Timing {
  int runs = kRuns;
  bool least = false;
};

double pick(const Timing& timing, std::vector<double> values) {
  if (timing.least) return *std::min_element(values.begin(), values.end());
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

// The four stages without the pipeline around them, so that each can be timed alone.
struct Stages {
  explicit Stages(const StreamSetup& setup) : config(setup.encoder) {
    Arena measuring = Arena::measuring();
    layout(measuring);
    arena = std::move(*Arena::map(measuring.bytes_needed()));
    layout(arena);
    std::vector<std::uint8_t> body(kMaxKeyBodyBytes);
    body.resize(write_key_body(config.stream, body));
    (void)tables.build(config.stream, key_hash(body));
    for_each([&](auto& stage) { stage.bind(tables, config.stages); });
  }

  void layout(Arena& into) {
    const FrameLimits limits{config.stream.camera.width, config.stream.camera.height};
    tables.layout(into, limits);
    for_each([&](auto& stage) { stage.layout(into, limits, FrameKind::kDepth); });
    slot.layout(into, limits, FrameKind::kDepth);
  }

  template <class F>
  void for_each(F&& f) {
    f(filter);
    f(segment);
    f(fit);
    f(pack);
  }

  EncoderConfig config;
  Arena arena;
  StreamTables tables;
  FilterStage filter;
  SegmentStage segment;
  FitStage fit;
  PackStage pack;
  FrameSlot slot;
};

struct Row {
  std::array<double, 4> stage_ms{};
  double count_ms = 0, unpack_ms = 0, regenerate_ms = 0;
  std::size_t bytes = 0;
  std::uint32_t points = 0, surfaces = 0, slices = 0;

  double encode_ms() const {
    return count_ms + stage_ms[0] + stage_ms[1] + stage_ms[2] + stage_ms[3];
  }
  double bits() const { return points > 0 ? static_cast<double>(bytes) * 8 / points : 0; }
};

// Depth of the frame, for the stages; turning points into counts is part of encoding a cloud.
Result<Done> time_counting(const StreamSetup& setup, const SensorFrame& frame, const Timing& timing,
                           std::vector<std::uint16_t>& depth, Row& row) {
  std::vector<double> ms;
  for (int run = 0; run < timing.runs + kWarmUps; ++run) {
    const double begin = thread_cpu_ms();
    if (auto done = to_depth(setup, frame, depth); !done.ok()) return done;
    if (run >= kWarmUps) ms.push_back(thread_cpu_ms() - begin);
  }
  if (setup.cloud_input) row.count_ms = pick(timing, ms);
  return Done{};
}

void time_encoding(Stages& stages, const std::vector<std::uint16_t>& depth, const Timing& timing,
                   Row& row) {
  std::array<std::vector<double>, 4> ms;
  for (int run = 0; run < timing.runs + kWarmUps; ++run) {
    std::copy(depth.begin(), depth.end(), stages.slot.depth.begin());
    std::size_t i = 0;
    stages.for_each([&](auto& stage) {
      const double begin = thread_cpu_ms();
      if (const Status status = stage.process(stages.slot); status != Status::kOk) {
        fmt::print(stderr, "stage_times: {}: {}\n", stage.kName, to_string(status));
      }
      if (run >= kWarmUps) ms[i].push_back(thread_cpu_ms() - begin);
      ++i;
    });
  }
  for (std::size_t i = 0; i < 4; ++i) row.stage_ms[i] = pick(timing, ms[i]);
  row.bytes = stages.slot.report.bytes;
  row.points = stages.slot.counts.input - stages.slot.counts.out_of_range;
  row.surfaces = stages.slot.report.surfaces;
  row.slices = stages.slot.report.slices;
}

void time_decoding(const Stages& stages, Decoder& decoder, const Timing& timing, Row& row) {
  std::vector<double> unpack, regenerate;
  for (int run = 0; run < timing.runs + kWarmUps; ++run) {
    const double begin = thread_cpu_ms();
    (void)decoder.begin();
    for (std::uint32_t i = 0; i < row.slices; ++i) (void)decoder.add(stages.slot.slice(i));
    const double middle = thread_cpu_ms();
    (void)decoder.finish();
    if (run < kWarmUps) continue;
    unpack.push_back(middle - begin);
    regenerate.push_back(thread_cpu_ms() - middle);
  }
  row.unpack_ms = pick(timing, unpack);
  row.regenerate_ms = pick(timing, regenerate);
}

void print_row(const std::string& name, const Row& r) {
  fmt::print(
      "{:<24.24} {:6.4f} {:5} {:4} | {:6.2f} {:6.2f} {:6.2f} {:6.2f} {:6.2f} = {:6.2f} | {:6.2f} "
      "{:6.2f} = "
      "{:6.2f}\n",
      name, r.bits(), r.slices, r.surfaces, r.count_ms, r.stage_ms[0], r.stage_ms[1], r.stage_ms[2],
      r.stage_ms[3], r.encode_ms(), r.unpack_ms, r.regenerate_ms, r.unpack_ms + r.regenerate_ms);
}

int fail(const Error& error) {
  fmt::print(stderr, "stage_times: {}\n", error.message);
  return to_int(ExitCode::kFailed);
}

int run(const std::vector<std::string>& inputs, const CodecOptions& options, bool wire,
        bool no_surfaces, const Timing& timing) {
  auto source = open_source(inputs, options);
  if (!source.ok()) return fail(source.error());
  SensorFrame frame;
  auto more = (*source)->next(frame);
  if (!more.ok()) return fail(more.error());
  auto setup = setup_stream(options, (*source)->sensor(), frame);
  if (!setup.ok()) return fail(setup.error());
  for (const std::string& note : setup->notes) fmt::print(stderr, "note: {}\n", note);
  if (setup->encoder.stream.kind != FrameKind::kDepth) {
    return fail({Status::kUnreadable, "raw clouds have no stages to time"});
  }
  setup->encoder.stages.slice_bytes = wire ? options.slice_bytes - 10 : kFileSliceBytes;
  setup->encoder.stages.surfaces = !no_surfaces;
  Stages stages(*setup);
  DecoderConfig limits;
  limits.limits = {setup->encoder.stream.camera.width, setup->encoder.stream.camera.height};
  auto decoder = Decoder::create(limits);
  auto codec = FrameCodec::create(*setup, kFileSliceBytes);
  if (!decoder.ok()) return fail(decoder.error());
  if (!codec.ok()) return fail(codec.error());
  if ((*decoder)->set_key(codec->key_packet(frame)) != Status::kOk)
    return fail({Status::kFieldRange, "key"});
  fmt::print(
      "{:<24} {:>6} {:>5} {:>4} | {:>6} {:>6} {:>6} {:>6} {:>6} = {:>6} | {:>6} {:>6} = "
      "{:>6}\n",
      "frame", "bit/pt", "slice", "surf", "count", "filter", "segm.", "fit", "pack", "ms", "unpack",
      "regen", "ms");
  Row mean;
  double bits = 0;
  int frames = 0;
  std::vector<std::uint16_t> depth;
  for (; more.ok() && *more; more = (*source)->next(frame)) {
    Row row;
    if (const auto done = time_counting(*setup, frame, timing, depth, row); !done.ok())
      return fail(done.error());
    time_encoding(stages, depth, timing, row);
    time_decoding(stages, **decoder, timing, row);
    print_row(frame.name.substr(frame.name.rfind('/') + 1), row);
    mean.count_ms += row.count_ms;
    for (std::size_t i = 0; i < 4; ++i) mean.stage_ms[i] += row.stage_ms[i];
    mean.unpack_ms += row.unpack_ms;
    mean.regenerate_ms += row.regenerate_ms;
    bits += row.bits();
    ++frames;
  }
  if (!more.ok()) return fail(more.error());
  fmt::print("mean of {}: {:.4f} bit/point, encode {:.2f} ms, decode {:.2f} ms\n", frames,
             bits / frames, mean.encode_ms() / frames,
             (mean.unpack_ms + mean.regenerate_ms) / frames);
  return 0;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"CPU time of each stage, and the bits it reaches."};
  CodecOptions options;
  std::vector<std::string> inputs;
  bool wire = false, no_surfaces = false;
  int least = 0;
  app.add_option("inputs", inputs, "files, folders or sim:room[:FRAMES]");
  app.add_flag("--wire", wire, "slices of --slice-bytes instead of the file form");
  app.add_flag("--no-surfaces", no_surfaces, "neighbour prediction only");
  app.add_option("--least", least, "the least time of so many runs, not the median of 9");
  add_codec_options(app, options);
  if (const auto code = parse_command_line(app, argc, argv, options)) return to_int(*code);
  const Timing timing{least > 0 ? least : kRuns, least > 0};
  return run(inputs, options, wire, no_surfaces, timing);
}
