#include "tests/golden/golden_cases.hpp"

#include <bit>
#include <cmath>
#include <utility>

#include "core/base/bytes.hpp"
#include "core/base/random.hpp"
#include "core/sim/sim_room.hpp"
#include "core/wire/frame_pack.hpp"
#include "tests/golden/golden_files.hpp"
#include "tests/golden/integer_scene.hpp"

namespace planecast::test {
namespace {

constexpr std::size_t kWireSlice = 1190;

struct Input {
  const char* file;
  std::uint32_t width, height;
  std::uint64_t frame;
};
constexpr Input kInputs[] = {{"room_160x120_a.u16", 160, 120, 0},
                             {"room_160x120_b.u16", 160, 120, 12},
                             {"room_64x48.u16", 64, 48, 40},
                             {"room_17x9.u16", 17, 9, 70}};

SimConfig room_sensor(std::uint32_t width, std::uint32_t height) {
  SimConfig sim = default_sim_config();
  const double scale = width / 640.0;
  sim.width = width;
  sim.height = height;
  sim.intrinsics.fx *= scale;
  sim.intrinsics.fy *= scale;
  sim.intrinsics.cx = width / 2.0;
  sim.intrinsics.cy = height / 2.0;
  return sim;
}

// A stream of the simulated sensor, without lattice.
StreamConfig room_config(std::uint32_t width, std::uint32_t height) {
  const SimConfig sim = room_sensor(width, height);
  StreamConfig out;
  out.stream = 1;
  out.session = 0x5e551011;
  out.epoch_ns = 1'700'000'000'000'000'000;
  out.clock = ClockDomain::kRealtime;
  out.camera = *quantise(sim.intrinsics, width, height);
  out.noise = sim.noise;
  out.frame_id = {'c', 'a', 'm', 'e', 'r', 'a'};
  return out;
}

Lattice room_lattice(std::uint32_t width, std::uint32_t height) {
  const SimConfig sim = room_sensor(width, height);
  const double c =
      sim.intrinsics.fx * sim.baseline_m * sim.steps_per_pixel / sim.intrinsics.metres_per_unit;
  return {static_cast<std::uint32_t>(std::llround(c * 256)), 0, false};
}

void set_bound(StreamConfig& config, ToleranceKind kind, std::uint32_t value) {
  config.tolerance = kind;
  (kind == ToleranceKind::kMetres ? config.tolerance_100nm : config.sigmas_q16) = value;
}

// Every kind of float: a camera's points, zeros of both signs, denormals, ends of the range, holes.
std::vector<Point3f> odd_cloud(std::uint32_t count) {
  Pcg32 random(99);
  std::vector<Point3f> out(count);
  for (std::uint32_t i = 0; i < count; ++i) {
    const auto any = [&] { return std::bit_cast<float>(random.next()); };
    out[i] = i % 3 == 0 ? Point3f{any(), any(), any()} : Point3f{-0.0F, 1e-44F, any()};
    if (i % 17 == 0) out[i].z = std::bit_cast<float>(0x7fc12345U);
  }
  return out;
}

std::vector<Point3f> pinhole_cloud(const std::vector<std::uint16_t>& depth, std::uint32_t width) {
  std::vector<Point3f> out(depth.size());
  for (std::uint32_t i = 0; i < depth.size(); ++i) {
    const auto u = static_cast<float>(i % width), v = static_cast<float>(i / width);
    const float z = static_cast<float>(depth[i]) * 0.00100013F;
    const float hole = std::bit_cast<float>(0x7fc00000U);
    out[i] = depth[i] == 0 ? Point3f{hole, hole, hole}
                           : Point3f{(u / 64 - 0.5F) * z, (v / 64 - 0.4F) * z, z};
  }
  return out;
}

PoseFixed odd_pose() {
  PoseFixed out;
  out.q_q30 = {536870912, -536870912, 536870912, -536870912};
  out.t_um = {1'234'567, -89'000, 42};
  return out;
}

using Images = std::vector<std::vector<std::uint16_t>>;

void add_contracts(const Images& in, std::vector<GoldenCase>& out) {
  const StreamConfig base = room_config(160, 120);
  GoldenCase c{"lossless_160x120", base, kFileSliceBytes, {in[0], in[1]}, {}};
  c.config.lattice = room_lattice(160, 120);
  out.push_back(c);
  c = {"lossless_slices_160x120", base, kWireSlice, {in[0]}, {}};
  out.push_back(c);
  c = {"metres_160x120", base, kWireSlice, {in[0], in[1]}, {}};
  set_bound(c.config, ToleranceKind::kMetres, 100'000);
  out.push_back(c);
  c = {"sigma_160x120", base, kWireSlice, {in[0], in[1]}, {}};
  c.config.lattice = room_lattice(160, 120);
  set_bound(c.config, ToleranceKind::kSigma, 5U << 16U);  // some lattice steps
  out.push_back(c);
  c.name = "surfaces_keep_160x120";
  c.slice_bytes = kFileSliceBytes;
  set_bound(c.config, ToleranceKind::kSurfaces, 3U << 16U);
  out.push_back(c);
  c.name = "surfaces_drop_160x120";
  c.slice_bytes = kWireSlice;
  c.config.drop_off_surface = true;
  out.push_back(c);
}

// Every contract at a size whose points can be read one by one, and VGA.
void add_scenes(std::vector<GoldenCase>& out) {
  const auto add = [&](const char* name, std::uint32_t width, std::uint32_t height) {
    GoldenCase c{name, room_config(width, height), kWireSlice, {}, {}};
    c.config.lattice = {300'000U << 8U, 0, false};
    c.dump = width < 100;
    const auto scene = c.dump ? integer_wall : integer_room;
    c.depth.push_back(scene(width, height, c.config.lattice, width));
    return &out.emplace_back(std::move(c));
  };
  add("lossless_24x16", 24, 16);
  set_bound(add("sigma_24x16", 24, 16)->config, ToleranceKind::kSigma, 2U << 16U);
  set_bound(add("surfaces_keep_40x24", 40, 24)->config, ToleranceKind::kSurfaces, 1U << 16U);
  GoldenCase* drop = add("surfaces_drop_40x24", 40, 24);
  set_bound(drop->config, ToleranceKind::kSurfaces, 1U << 16U);
  drop->config.drop_off_surface = true;
  GoldenCase* curved = add("curved_160x120", 160, 120);
  set_bound(curved->config, ToleranceKind::kSigma, 2U << 16U);
  curved->depth = {integer_dome(160, 120, curved->config.lattice, 160)};
  set_bound(add("sigma_640x480", 640, 480)->config, ToleranceKind::kSigma, 2U << 16U);
  drop = add("surfaces_drop_640x480", 640, 480);
  set_bound(drop->config, ToleranceKind::kSurfaces, 2U << 16U);
  drop->config.drop_off_surface = true;
}

// Several models mixed, under every contract.
void add_best(const Images& in, std::vector<GoldenCase>& out) {
  GoldenCase c{"best_lossless_160x120", room_config(160, 120), kWireSlice, {in[0]}, {}};
  c.config.effort_best = true;
  c.config.lattice = room_lattice(160, 120);
  out.push_back(c);
  c.name = "best_sigma_160x120";
  set_bound(c.config, ToleranceKind::kSigma, 2U << 16U);
  out.push_back(c);
  c.name = "best_surfaces_keep_160x120";
  c.slice_bytes = kFileSliceBytes;
  set_bound(c.config, ToleranceKind::kSurfaces, 3U << 16U);
  out.push_back(c);
  c = {"best_metres_64x48", room_config(64, 48), kWireSlice, {in[2]}, {}};
  c.config.effort_best = true;
  set_bound(c.config, ToleranceKind::kMetres, 100'000);
  out.push_back(c);
  c = {"best_lossless_24x16", room_config(24, 16), kWireSlice, {}, {}};
  c.config.effort_best = true;
  c.config.lattice = {300'000U << 8U, 0, false};
  c.depth.push_back(integer_wall(24, 16, c.config.lattice, 24));
  out.push_back(c);
  c.name = "best_metres_24x16";
  set_bound(c.config, ToleranceKind::kMetres, 100'000);
  out.push_back(c);
}

void add_sensors(const Images& in, std::vector<GoldenCase>& out) {
  GoldenCase c{"tof_64x48", room_config(64, 48), 400, {in[2]}, {}};
  c.config.noise = {NoiseModel::Kind::kTof, 4'000'000};
  c.config.camera.unit_pm = 250'000'000;
  c.config.z_rule = ZRule::kProductInFloat;
  set_bound(c.config, ToleranceKind::kSigma, 3U << 15U);
  out.push_back(c);
  c = {"lens_64x48", room_config(64, 48), kWireSlice, {in[2]}, {}};
  c.config.camera.k1_q24 = 1'677'722;  // 0.1
  c.config.camera.k2_q24 = -335'544;
  c.config.camera.p1_q24 = 16'777;
  c.config.camera.p2_q24 = -8'389;
  c.config.camera.k3_q24 = 83'886;
  c.config.z_rule = ZRule::kPrinted7;
  c.config.pose = c.config.axes = odd_pose();
  c.config.mirror_y = true;
  set_bound(c.config, ToleranceKind::kMetres, 300'000);
  out.push_back(c);
  c = {"lattice_cut_64x48", room_config(64, 48), kFileSliceBytes, {in[2]}, {}};
  c.config.lattice = {350'000U << 8U, 0x4000, true};
  for (std::size_t i = 0; i < c.depth[0].size(); ++i) {
    std::uint16_t& d = c.depth[0][i];  // one in eleven stays off the lattice
    if (d != 0 && i % 11 != 0)
      d = static_cast<std::uint16_t>(lattice_depth(c.config.lattice, 1 + 350'000U / d));
  }
  out.push_back(c);
}

void add_sizes(const Images& in, std::vector<GoldenCase>& out) {
  GoldenCase c{"metres_17x9", room_config(17, 9), kWireSlice, {in[3]}, {}};
  c.dump = true;
  set_bound(c.config, ToleranceKind::kMetres, 200'000);
  out.push_back(c);
  c = {"verbatim_17x9", room_config(17, 9), kMinSliceBytes, {in[3]}, {}};
  Pcg32 random(3);
  for (auto& d : c.depth[0]) d = static_cast<std::uint16_t>(random.next());
  out.push_back(c);
  for (const bool lossless : {false, true}) {
    c = {lossless ? "runs_lossless_64x48" : "runs_64x48",
         room_config(64, 48),
         kWireSlice,
         {in[2]},
         {}};
    if (!lossless) set_bound(c.config, ToleranceKind::kSigma, 2U << 16U);
    c.no_time = true;
    out.push_back(c);
  }
  out.push_back({"lossless_1x1", room_config(1, 1), kWireSlice, {{65535}}, {}});
  out.push_back(
      {"holes_64x48", room_config(64, 48), kWireSlice, {Images::value_type(64 * 48)}, {}});
  c = {"wide_2100x1", room_config(2100, 1), kFileSliceBytes, {Images::value_type(2100)}, {}};
  c.surfaces = false;
  for (std::uint32_t u = 0; u < 2100; ++u)
    c.depth[0][u] = static_cast<std::uint16_t>(1000 + u / 3 + (u % 50 == 0 ? 20000 : 0));
  out.push_back(c);
}

void add_clouds(const Images& in, std::vector<GoldenCase>& out) {
  GoldenCase c{"raw_64x48", room_config(64, 48), kWireSlice, {}, {pinhole_cloud(in[2], 64)}};
  c.config.kind = FrameKind::kRawCloud;
  out.push_back(c);
  c.name = "raw_steps_64x48";
  c.slice_bytes = kFileSliceBytes;
  for (Point3f& p : c.clouds[0]) p = {p.z, p.x, -p.y};
  out.push_back(c);
  c = {"raw_bits_17x9", room_config(17, 9), kFileSliceBytes, {}, {odd_cloud(17 * 9)}};
  c.config.kind = FrameKind::kRawCloud;
  c.dump = true;
  out.push_back(c);
}

// Whole millimetres: a floor and a wall with a little noise, and points anywhere beside them.
std::vector<Point3f> integer_list(std::uint32_t count) {
  Pcg32 random(21);
  const auto mm = [](std::int64_t n) { return static_cast<float>(static_cast<double>(n) * 0.001); };
  std::vector<Point3f> out;
  for (std::uint32_t i = 0; i < count; ++i) {
    const std::int64_t u = 13 * (i % 29) + random.below(5), v = 17 * (i / 29) + random.below(5);
    const std::int64_t w = random.below(3);
    if (i % 12 == 7) {
      out.push_back({mm(random.below(400)), mm(random.below(400)), mm(100 + random.below(300))});
    } else {
      out.push_back(i % 2 == 0 ? Point3f{mm(u), mm(v), mm(w)} : Point3f{mm(w - 20), mm(v), mm(u)});
    }
  }
  return out;
}

std::vector<Point3f> odd_list(std::uint32_t count) {
  std::vector<Point3f> out;
  for (const Point3f& p : odd_cloud(4 * count)) {
    const bool finite = p.x - p.x == 0 && p.y - p.y == 0 && p.z - p.z == 0;
    if (finite && out.size() < count) out.push_back(p);
  }
  return out;
}

void add_lists(std::vector<GoldenCase>& out) {
  GoldenCase base{"points_bits", room_config(1, 1), kFileSliceBytes, {}, {odd_list(60)}};
  StreamConfig& config = base.config;
  config.kind = FrameKind::kPoints;
  config.camera = {};
  config.noise = {NoiseModel::Kind::kTof, 2'000'000};
  config.points.max_points = 800;
  config.points.patch_unit_nm = 195'313;  // alpha 0.05 m
  config.points.seed = 7;
  base.dump = true;
  out.push_back(base);
  base.clouds = {integer_list(700), integer_list(40), {}};
  base.config.axes.t_um = {691'000'000'000, 5'334'000'000'000, 0};
  base.config.points.step_pm = 1'000'000'000;
  base.name = "points_grid";
  base.dump = false;
  out.push_back(base);
  base.slice_bytes = 300;
  base.config.points.step_pm = 78'125'000;
  base.config.points.tolerance_steps = 126;
  base.name = "points_metres";
  set_bound(base.config, ToleranceKind::kMetres, 100'000);
  out.push_back(base);
  base.name = "points_sigma";
  set_bound(base.config, ToleranceKind::kSigma, 5U << 16U);
  out.push_back(base);
  base.name = "points_surfaces_keep";
  set_bound(base.config, ToleranceKind::kSurfaces, 5U << 16U);
  out.push_back(base);
  base.name = "points_paper";
  base.slice_bytes = kWireSlice;
  base.config.drop_off_surface = base.drop_outliers = true;
  base.config.points.fill = FillMode::kRandom;
  out.push_back(base);
}

}  // namespace

FrameLimits limits_of(const GoldenCase& c) {
  FrameLimits limits{c.config.camera.width, c.config.camera.height};
  limits.max_points = c.config.points.max_points;
  return limits;
}

Result<std::vector<GoldenCase>> golden_cases(const std::filesystem::path& folder) {
  Images images;
  for (const Input& input : kInputs) {
    auto counts = read_counts(folder / "inputs" / input.file, input.width * input.height);
    if (!counts.ok()) return counts.error();
    images.push_back(std::move(*counts));
  }
  std::vector<GoldenCase> out;
  add_contracts(images, out);
  add_scenes(out);
  add_best(images, out);
  add_sensors(images, out);
  add_sizes(images, out);
  add_clouds(images, out);
  add_lists(out);
  return out;
}

Result<Done> render_inputs(const std::filesystem::path& folder) {
  for (const Input& input : kInputs) {
    auto simulator = RoomSimulator::create(room_sensor(input.width, input.height));
    if (!simulator.ok()) return simulator.error();
    DepthImage image;
    std::vector<std::uint16_t> ids;
    Pose pose;
    simulator->render(input.frame, image, ids, pose);
    Bytes bytes(2 * image.depth.size());
    for (std::size_t i = 0; i < image.depth.size(); ++i)
      store_le<std::uint16_t>(&bytes[2 * i], image.depth[i]);
    auto done = write_golden_file(folder / "inputs" / input.file, bytes);
    if (!done.ok()) return done;
  }
  return Done{};
}

}  // namespace planecast::test
