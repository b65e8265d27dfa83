// Cost against work: time and memory of both halves from 80 x 60 to 1920 x 1080, and at 640 x 480
// against the number of surfaces in view. Prints the Markdown of docs/benchmarks.md:
//   scaling_cost [codec options] | bench/doc_section.py docs/benchmarks.md scaling_cost
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cmath>

#include "apps/common/command_line.hpp"
#include "bench/own_codec.hpp"
#include "core/base/random.hpp"
#include "core/sim/sim_room.hpp"

namespace {

using namespace planecast;
using namespace planecast::bench;

constexpr std::array<std::array<std::uint32_t, 2>, 7> kSizes{
    {{80, 60}, {160, 120}, {320, 240}, {640, 480}, {960, 720}, {1280, 960}, {1920, 1080}}};
constexpr int kPlates[] = {0, 1, 3, 10, 30, 60, 100, 150, 200, 250, 300};

// The default sensor with its field of view, at another resolution.
SimConfig sensor_of(std::uint32_t width, std::uint32_t height) {
  SimConfig config = default_sim_config();
  const double scale = static_cast<double>(width) / config.width;
  config.intrinsics.fx *= scale;
  config.intrinsics.fy *= scale;
  config.intrinsics.cx = (width - 1) / 2.0;
  config.intrinsics.cy = (height - 1) / 2.0;
  config.width = width;
  config.height = height;
  return config;
}

// Tilted plates in rows and columns that share the view, nothing behind them; with 0 plates a heap
// of spheres, no plane at all.
SimScene plate_scene(int plates) {
  SimScene scene;
  scene.path.centre = {0, 0, 0};
  Pcg32 random(11);
  if (plates == 0) {
    for (int i = 0; i < 400; ++i) {
      const double across = 6 * (random.uniform() - 0.5), up = 4 * (random.uniform() - 0.5);
      scene.spheres.push_back(
          {{2.5 + random.uniform(), across, up}, 0.12 + 0.2 * random.uniform()});
    }
    return scene;
  }
  const int columns = std::max(1, static_cast<int>(std::lround(std::sqrt(plates * 4.0 / 3))));
  const int rows = (plates + columns - 1) / columns;
  const double distance = 2.5, width = 5.0, height = 3.6;  // a little more than the view
  for (int i = 0; i < plates; ++i) {
    const int row = i / columns, in_row = row + 1 < rows ? columns : plates - columns * (rows - 1);
    SimBox plate;
    plate.half = {0.004, 0.5 * width / in_row, 0.5 * height / rows};
    plate.centre = {distance + 0.5 * random.uniform(), width * ((i % columns + 0.5) / in_row - 0.5),
                    height * ((row + 0.5) / rows - 0.5)};
    const double tilt = plates == 1 ? 0.3 : 0.7;
    plate.axes =
        rotation_of(turned_by(tilt * (random.uniform() - 0.5), tilt * (random.uniform() - 0.5), 0));
    scene.boxes.push_back(plate);
  }
  return scene;
}

struct Measured {
  std::uint32_t readings = 0;
  OwnResult own;
};

Measured measure(const CodecOptions& options, const SimConfig& config, SimScene scene) {
  auto simulator = RoomSimulator::create(config, std::move(scene));
  if (!simulator.ok()) throw std::runtime_error(simulator.error().message);
  SensorFrame frame;
  frame.name = "simulator";
  std::vector<std::uint16_t> truth;
  simulator->render(0, frame.depth, truth, frame.pose);
  SourceSensor sensor;
  sensor.intrinsics = config.intrinsics;
  sensor.noise = config.noise;
  Measured out;
  for (const std::uint16_t d : frame.depth.depth) out.readings += d != 0;
  out.own = run_own(options, sensor, frame, options.tolerance, true);
  return out;
}

void print_sizes(const CodecOptions& options) {
  fmt::print(
      "| size | readings | encode ms | ns/pixel | decode ms | ns/pixel | MB in memory | B/pixel |\n"
      "|---|---|---|---|---|---|---|---|\n");
  for (const auto& [width, height] : kSizes) {
    const Measured m = measure(options, sensor_of(width, height), room_scene());
    const double pixels = static_cast<double>(width) * height;
    fmt::print("| {} x {} | {} | {:.2f} | {:.1f} | {:.2f} | {:.1f} | {:.2f} | {:.1f} |\n", width,
               height, m.readings, m.own.encode_ms, m.own.encode_ms * 1e6 / pixels, m.own.decode_ms,
               m.own.decode_ms * 1e6 / pixels, static_cast<double>(m.own.memory_bytes) / 1e6,
               static_cast<double>(m.own.memory_bytes) / pixels);
  }
}

void print_surfaces(const CodecOptions& options) {
  fmt::print(
      "| plates in view | surfaces coded | readings | bytes | encode ms | decode ms |\n"
      "|---|---|---|---|---|---|\n");
  for (const int plates : kPlates) {
    const Measured m = measure(options, sensor_of(640, 480), plate_scene(plates));
    fmt::print("| {} | {} | {} | {} | {:.2f} | {:.2f} |\n", plates, m.own.surfaces, m.readings,
               m.own.bytes, m.own.encode_ms, m.own.decode_ms);
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"Time and memory against the size of the image and the surfaces in it."};
  CodecOptions options;
  add_codec_options(app, options);
  if (const auto code = parse_command_line(app, argc, argv, options)) return to_int(*code);
  try {
    fmt::print("`sim:room`'s scene at tolerance `{}`, the sensor's field of view kept:\n\n",
               to_string(options.tolerance));
    print_sizes(options);
    fmt::print("\n640 x 480, tilted plates that fill the view (0: spheres only):\n\n");
    print_surfaces(options);
  } catch (const std::exception& error) {
    fmt::print(stderr, "scaling_cost: {}\n", error.what());
    return to_int(ExitCode::kFailed);
  }
  return 0;
}
