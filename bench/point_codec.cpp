// The point codec on clouds in files, beside Draco (kd-tree, level 10) at the
// same error:
//   point_codec bench/point_codec.list       a Markdown table: bits, errors,
//   times point_codec scaling                      time and memory from 10^4 to
//   10^7 points
// LIST names clouds, their units [m] and Draco's quantisation bits. d1 is the
// mean of the two nearest-point RMSEs; ours is the widest tolerance whose d1 is
// not above Draco's. Times are CPU time of one thread, the least of five runs,
// per point.
#include <fmt/core.h>

#include <algorithm>
#include <cmath>
#include <ctime>
#include <fstream>
#include <functional>
#include <random>
#include <sstream>

#include "bench/baselines/point_baselines.hpp"
#include "bench/point_run.hpp"
#include "core/metrics/distance.hpp"

namespace {

using namespace planecast;
using bench::PointRun;

double cpu_seconds() {
  timespec now{};
  clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
  return static_cast<double>(now.tv_sec) + static_cast<double>(now.tv_nsec) * 1e-9;
}

double least_seconds(const std::function<void()>& work) {
  double least = 1e9;
  for (int run = 0; run < 5; ++run) {
    const double start = cpu_seconds();
    work();
    least = std::min(least, cpu_seconds() - start);
  }
  return least;
}

struct Row {
  double bits = 0, d1 = 0, max = 0, encode_us = 0, decode_us = 0;
};

Row measured(const std::vector<Point3f>& points, const std::vector<Point3f>& decoded,
             std::size_t bytes) {
  const CloudDistance distance = cloud_distance(points, decoded, {.point_to_plane = false});
  return {static_cast<double>(bytes) * 8 / static_cast<double>(points.size()), distance.d1 * 1e3,
          distance.hausdorff * 1e3};
}

Row draco(const std::vector<Point3f>& points, int bits) {
  const auto codec = baselines::draco_points(true, 10, bits);
  baselines::Bytes bytes = codec->encode(points);
  Row row = measured(points, codec->decode(bytes), bytes.size());
  const double per_point = 1e6 / static_cast<double>(points.size());
  row.encode_us = per_point * least_seconds([&] { bytes = codec->encode(points); });
  row.decode_us = per_point * least_seconds([&] { (void)codec->decode(bytes); });
  return row;
}

[[noreturn]] void fail(const std::string& what) {
  fmt::print(stderr, "point_codec: {}\n", what);
  std::exit(1);
}

void must(Status status, const char* what) {
  if (status != Status::kOk) fail(fmt::format("{}: {}", what, to_string(status)));
}

std::unique_ptr<PointRun> opened(const std::string& path, double units, double tolerance) {
  auto run = PointRun::open(path, units, tolerance);
  if (!run.ok()) fail(run.error().message);
  return std::move(*run);
}

Row ours(PointRun& run, std::size_t slice_bytes) {
  must(run.pack(slice_bytes), "pack");
  must(run.unpack(), "unpack");
  return measured(run.points(), run.decoded(), run.report().bytes);
}

// The widest tolerance whose d1 is not above `d1_mm`, to a hundredth.
double tolerance_for(const std::string& path, double units, double d1_mm) {
  double low = 0, high = d1_mm * 4e-3, guess = d1_mm * 1.75e-3;
  for (int i = 0; i < 7 && high - low > 0.01 * low; ++i) {
    const auto run = opened(path, units, guess);
    const double d1 = ours(*run, kFileSliceBytes).d1;
    (d1 <= d1_mm ? low : high) = guess;
    guess =
        std::clamp(guess * d1_mm / d1 * 0.998, low + (high - low) / 64, high - (high - low) / 64);
  }
  return low;
}

void print_row(const std::string& name, const std::string& path, double units, int bits) {
  const Row peer = draco(opened(path, units, 0.01)->points(), bits);
  const double tolerance = tolerance_for(path, units, peer.d1);
  const auto run = opened(path, units, tolerance);
  const Row wire = ours(*run, 1200);
  Row file = ours(*run, kFileSliceBytes);
  const double per_point = 1e6 / static_cast<double>(run->points().size());
  file.encode_us = per_point * least_seconds([&] { must(run->pack(kFileSliceBytes), "pack"); });
  file.decode_us = per_point * least_seconds([&] { must(run->unpack(), "unpack"); });
  fmt::print(
      "| {} | {} | {:.2f} | {:.2f} | {:.2f} / {:.2f} | {:.2f} | {:.1f} "
      "| {:.2f} | {:.2f} | {:.3f} "
      "| {:.2f} / {:.2f} |\n",
      name, run->points().size(), peer.d1, peer.bits, peer.encode_us, peer.decode_us, file.d1,
      tolerance * 1e3, file.bits, wire.bits, file.max / (tolerance * 1e3), file.encode_us,
      file.decode_us);
  std::fflush(stdout);
}

// Walls and a floor with noise of 4 mm, 20 m x 20 m, at a bound of 10 mm.
std::vector<Point3f> rooms(std::size_t n) {
  std::mt19937 random(7);
  std::uniform_real_distribution<float> side(-10, 10);
  std::normal_distribution<float> noise(0, 0.004F);
  std::vector<Point3f> points;
  for (std::size_t i = 0; i < n; ++i) {
    const float a = side(random), b = side(random), off = noise(random);
    const auto wall = static_cast<float>(static_cast<int>(i % 5) * 4 - 8);
    points.push_back(i % 3 == 0   ? Point3f{a, b, off}
                     : i % 3 == 1 ? Point3f{a, wall + off, b / 5 + 2}
                                  : Point3f{wall + off, a, b / 5 + 2});
  }
  return points;
}

void print_scaling() {
  fmt::print(
      "| points | bit/point | encode us/point | decode us/point | arena "
      "MB |\n|---|---|---|---|---|\n");
  for (const std::size_t n : {10000U, 100000U, 1000000U, 10000000U}) {
    const auto run = PointRun::make(rooms(n), 0.01);
    const double per_point = 1e6 / static_cast<double>(n);
    const double encode =
        per_point * least_seconds([&] { must(run->pack(kFileSliceBytes), "pack"); });
    const double decode = per_point * least_seconds([&] { must(run->unpack(), "unpack"); });
    fmt::print("| {} | {:.2f} | {:.2f} | {:.2f} | {:.0f} |\n", n,
               static_cast<double>(run->report().bytes) * 8 / static_cast<double>(n), encode,
               decode, static_cast<double>(run->arena_bytes()) / 1e6);
    std::fflush(stdout);
  }
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) fail("usage: point_codec LIST | scaling");
  if (std::string(argv[1]) == "scaling") return print_scaling(), 0;
  if (!baselines::draco_available()) fail("built without Draco (Debian: libdraco-dev)");
  std::ifstream list(argv[1]);
  if (!list) fail(std::string(argv[1]) + " cannot be read");
  fmt::print(
      "| cloud | points | Draco d1 mm | bit/point | us/point | d1 mm | "
      "tolerance mm | bit/point | in slices of "
      "1200 B | largest error / bound | us/point "
      "|\n|---|---|---|---|---|---|---|---|---|---|---|\n");
  for (std::string line; std::getline(list, line);) {
    if (line.empty() || line[0] == '#') continue;
    std::istringstream words(line);
    std::string name, file;
    double units = 1;
    int bits = 0;
    if (!(words >> name >> file >> units >> bits)) fail("cannot read: " + line);
    print_row(name, bench::data_path(file), units, bits);
  }
  return 0;
}
