// Frames a second that the encoder's pipeline does, against worker threads, slots and resolution:
//   scaling INPUT... [--frames N] [codec options]
// The source waits for slots, so the pipeline is always full. With fewer threads than stages,
// neighbouring stages share one. Smaller resolutions take every second or fourth pixel of the input
// with the camera scaled along. Wall time and the CPU time of the whole process.
#include <fmt/core.h>
#include <time.h>

#include <CLI/CLI.hpp>
#include <array>
#include <memory>
#include <thread>
#include <vector>

#include "apps/common/command_line.hpp"
#include "apps/common/exit_codes.hpp"
#include "apps/common/frame_source.hpp"
#include "apps/common/stream_setup.hpp"
#include "core/pipeline/stage_runner.hpp"
#include "core/pipeline/stages.hpp"
#include "core/wire/key_packet.hpp"

namespace {

using namespace planecast;

constexpr std::uint32_t kStages = 4, kMostFrames = 40;

int fail(const Error& error) {
  fmt::print(stderr, "scaling: {}\n", error.message);
  return to_int(exit_code(error.status));
}

double seconds(clockid_t clock) {
  timespec now{};
  ::clock_gettime(clock, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

/// Neighbouring stages run one after the other by one thread.
struct Group {
  std::array<StageRef, kStages> parts{};
  std::size_t count = 0;
};

StageRef to_ref(Group& group) {
  return {"group", &group, group.parts[0].slots,
          [](void* self, void* slots, std::uint32_t handle) noexcept -> Status {
            auto& own = *static_cast<Group*>(self);
            for (std::size_t i = 0; i < own.count; ++i) {
              const StageRef& part = own.parts[i];
              const Status status = part.process(part.stage, slots, handle);
              if (status != Status::kOk) return status;
            }
            return Status::kOk;
          }};
}

// Which stages end a thread's share: pack is the longest, so it is the first to have its own.
constexpr bool kCutBehind[kStages][kStages] = {{false, false, false, true},
                                               {false, false, true, true},
                                               {false, true, true, true},
                                               {true, true, true, true}};

class Chain {
 public:
  Chain(const StreamSetup& setup, std::uint32_t threads, std::uint32_t slots)
      : config_(setup.encoder) {
    config_.runner.slots = slots;
    Arena measuring = Arena::measuring();
    lay_out(measuring, threads);
    arena_ = std::move(Arena::map(measuring.bytes_needed()).value());
    lay_out(arena_, threads);
    std::vector<std::uint8_t> body(kMaxKeyBodyBytes);
    body.resize(write_key_body(config_.stream, body));
    ok_ = tables_.build(config_.stream, key_hash(body)) == Status::kOk;
    filter_.bind(tables_, config_.stages);
    segment_.bind(tables_, config_.stages);
    fit_.bind(tables_, config_.stages);
    pack_.bind(tables_, config_.stages);
  }

  /// Frames a second of wall time and cores used; 0 where something failed.
  std::pair<double, double> run(const std::vector<std::vector<std::uint16_t>>& frames,
                                std::uint32_t count) {
    if (!ok_ || !runner_.start().ok()) return {0, 0};
    const double wall = seconds(CLOCK_MONOTONIC), cpu = seconds(CLOCK_PROCESS_CPUTIME_ID);
    std::uint32_t done = 0;
    std::thread consumer([&] {
      std::uint32_t handle = 0;
      while (runner_.pop_done(handle)) {
        done += runner_.status(handle) == Status::kOk ? 1 : 0;
        (void)runner_.release(handle);
      }
    });
    for (std::uint32_t i = 0; i < count; ++i) {
      const auto handle = runner_.claim_wait();
      if (!handle) break;
      slots_[*handle].begin(i, 0, 0);
      const auto& frame = frames[i % frames.size()];
      std::copy(frame.begin(), frame.end(), slots_[*handle].depth.begin());
      (void)runner_.submit(*handle);
    }
    runner_.stop();
    consumer.join();
    const double took = seconds(CLOCK_MONOTONIC) - wall;
    if (done != count) return {0, 0};
    return {count / took, (seconds(CLOCK_PROCESS_CPUTIME_ID) - cpu) / took};
  }

 private:
  void lay_out(Arena& arena, std::uint32_t threads) {
    const FrameLimits limits{config_.stream.camera.width, config_.stream.camera.height};
    tables_.layout(arena, limits);
    filter_.layout(arena, limits, FrameKind::kDepth);
    segment_.layout(arena, limits, FrameKind::kDepth);
    fit_.layout(arena, limits, FrameKind::kDepth);
    pack_.layout(arena, limits, FrameKind::kDepth);
    slots_ = arena.take<FrameSlot>(config_.runner.slots);
    for (std::uint32_t i = 0; i < config_.runner.slots; ++i) {
      FrameSlot measured;
      (slots_.empty() ? measured : slots_[i]).layout(arena, limits, FrameKind::kDepth);
    }
    const StageRef all[kStages] = {make_stage_ref(filter_, slots_),
                                   make_stage_ref(segment_, slots_), make_stage_ref(fit_, slots_),
                                   make_stage_ref(pack_, slots_)};
    std::vector<StageRef> refs;
    groups_ = {};
    std::size_t group = 0;
    for (std::uint32_t i = 0; i < kStages; ++i) {
      groups_[group].parts[groups_[group].count++] = all[i];
      if (kCutBehind[threads - 1][i]) refs.push_back(to_ref(groups_[group++]));
    }
    ok_ = runner_.init(arena, config_.runner, refs) == Status::kOk;
  }

  EncoderConfig config_;
  Arena arena_;
  StreamTables tables_;
  FilterStage filter_;
  SegmentStage segment_;
  FitStage fit_;
  PackStage pack_;
  std::span<FrameSlot> slots_;
  std::array<Group, kStages> groups_;
  StageRunner runner_;
  bool ok_ = false;
};

/// Every `step`-th pixel of every `step`-th row.
void thin(DepthImage& image, std::uint32_t step) {
  DepthImage out{image.width / step, image.height / step, {}};
  for (std::uint32_t v = 0; v < out.height; ++v)
    for (std::uint32_t u = 0; u < out.width; ++u)
      out.depth.push_back(image.depth[std::size_t{v} * step * image.width + u * step]);
  image = std::move(out);
}

struct Load {
  StreamSetup setup;
  std::vector<std::vector<std::uint16_t>> frames;
};

Result<Load> load(const std::vector<std::string>& inputs, CodecOptions options,
                  std::uint32_t step) {
  auto source = open_source(inputs, options);
  if (!source.ok()) return source.error();
  SourceSensor sensor = (*source)->sensor();
  const auto scale = [step](Intrinsics& camera) {
    for (double* figure : {&camera.fx, &camera.fy, &camera.cx, &camera.cy}) *figure /= step;
  };
  if (options.camera) scale(options.camera->intrinsics);
  if (sensor.intrinsics) scale(*sensor.intrinsics);
  Load out;
  SensorFrame frame;
  for (auto more = (*source)->next(frame);; more = (*source)->next(frame)) {
    if (!more.ok()) return more.error();
    if (!*more || out.frames.size() == kMostFrames) break;
    if (frame.depth.width == 0)
      return Error{Status::kUnreadable, frame.name + ": scaling wants depth images"};
    thin(frame.depth, step);
    if (out.frames.empty()) {
      auto setup = setup_stream(options, sensor, frame);
      if (!setup.ok()) return setup.error();
      out.setup = std::move(*setup);
      out.setup.encoder.stages.slice_bytes = options.slice_bytes - 10;
    }
    if (const auto done = to_depth(out.setup, frame, out.frames.emplace_back()); !done.ok())
      return done.error();
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Frames a second against threads, slots and resolution."};
  CodecOptions options;
  std::vector<std::string> inputs;
  std::uint32_t count = 60;
  app.add_option("inputs", inputs, "files, folders or sim:room[:FRAMES]");
  app.add_option("--frames", count, "frames a measurement")->check(CLI::Range(1, 100000));
  add_codec_options(app, options);
  if (const auto code = parse_command_line(app, argc, argv, options)) return to_int(*code);
  fmt::print("{:>10} {:>8} {:>6} | {:>8} {:>6}\n", "size", "threads", "slots", "frames/s", "cores");
  for (const std::uint32_t step : {1U, 2U, 4U}) {
    const auto loaded = load(inputs, options, step);
    if (!loaded.ok()) return fail(loaded.error());
    const CameraModel& camera = loaded->setup.encoder.stream.camera;
    const auto row = [&](std::uint32_t threads, std::uint32_t slots) {
      const auto [rate, cores] =
          Chain(loaded->setup, threads, slots).run(loaded->frames, count * step);
      fmt::print("{:>10} {:>8} {:>6} | {:8.1f} {:6.2f}\n",
                 fmt::format("{}x{}", camera.width, camera.height), threads, slots, rate, cores);
    };
    for (std::uint32_t threads = 1; threads <= kStages; ++threads) row(threads, 6);
    for (const std::uint32_t slots : {1U, 2U, 4U, 12U}) row(kStages, slots);
  }
  return 0;
}
