// The paper's evaluation on one cloud: its method step by step, the sweep of its Figure 5, and the
// systems of its Table 3 on the same points.
//   paper CLASS NAME INPUT [codec options] [--sweep] [--compare] >> rows.json
// One JSON object a row on standard output; bench/paper.sh runs the clouds at hand and
// bench/paper_report.py writes docs/paper-results.md.
#include <fmt/core.h>

#include <CLI/CLI.hpp>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "apps/common/command_line.hpp"
#include "apps/common/frame_codec.hpp"
#include "apps/common/frame_source.hpp"
#include "bench/baselines/point_baselines.hpp"
#include "bench/paper_steps.hpp"
#include "bench/pcl_chain.hpp"
#include "core/metrics/compression.hpp"
#include "core/metrics/distance.hpp"

namespace {

using namespace planecast;
using namespace planecast::bench;
using baselines::PointList;
using Json = nlohmann::ordered_json;

constexpr double kSweep_deg[] = {1, 2, 3, 4, 6, 8, 12, 16, 20};

struct Arguments {
  std::string kind, name;
  std::vector<std::string> inputs;
  bool sweep = false, compare = false, pcl = false;
};

struct Cloud {
  PointList points;
  std::uint64_t file_bytes = 0;
};

// Points of a depth image through its camera; of a cloud, its finite ones.
Cloud read_cloud(const Arguments& arguments, const CodecOptions& options) {
  auto source = open_source(arguments.inputs, options);
  if (!source.ok()) throw std::runtime_error(source.error().message);
  SensorFrame frame;
  const auto more = (*source)->next(frame);
  if (!more.ok()) throw std::runtime_error(more.error().message);
  Cloud cloud;
  const std::filesystem::path file(arguments.inputs[0]);
  cloud.file_bytes = std::filesystem::is_regular_file(file) ? std::filesystem::file_size(file)
                                                            : frame.depth.depth.size() * 2;
  auto camera = (*source)->sensor().intrinsics;
  if (!camera) camera = intrinsics_of(options);
  if (frame.depth.width > 0 && !camera) throw std::runtime_error("a depth image without camera");
  for (std::size_t i = 0; i < frame.depth.depth.size(); ++i) {
    if (frame.depth.depth[i] == 0) continue;
    const double z = frame.depth.depth[i] * camera->metres_per_unit;
    const double u = static_cast<double>(i % frame.depth.width);
    const double v = static_cast<double>(i / frame.depth.width);
    cloud.points.push_back({static_cast<float>((u - camera->cx) / camera->fx * z),
                            static_cast<float>((v - camera->cy) / camera->fy * z),
                            static_cast<float>(z)});
  }
  for (const Point3f& p : frame.cloud.points) {
    if (std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z)) cloud.points.push_back(p);
  }
  if (cloud.points.empty()) throw std::runtime_error(arguments.name + ": has no points");
  return cloud;
}

// What every row says of the cloud that comes back.
void add_distances(Json& row, const Cloud& cloud, const PointList& decoded) {
  DistanceOptions fast;
  fast.point_to_plane = false;
  const CloudDistance far = cloud_distance(cloud.points, decoded, fast);
  row["points_out"] = decoded.size();
  row["points_dropped"] = cloud.points.size() - std::min(cloud.points.size(), decoded.size());
  row["d1_ab_mm"] = far.d1_ab * 1e3;
  row["d1_ba_mm"] = far.d1_ba * 1e3;
  row["d1_mm"] = far.d1 * 1e3;
  row["max_mm"] = far.hausdorff * 1e3;
}

void add_sizes(Json& row, const Cloud& cloud, std::size_t bytes) {
  row["bytes"] = bytes;
  row["bits_per_point"] = bits_per_point(bytes, cloud.points.size());
  row["ratio_percent"] = ratio_percent(bytes, cloud.points.size());
  row["ratio_file_percent"] =
      100 * (1 - static_cast<double>(bytes) / static_cast<double>(cloud.file_bytes));
}

Json head(const char* row, const Arguments& arguments, const Cloud& cloud) {
  return {{"row", row},
          {"class", arguments.kind},
          {"cloud", arguments.name},
          {"points_in", cloud.points.size()},
          {"file_bytes", cloud.file_bytes}};
}

Json chain_row(const char* name, const Arguments& arguments, const Cloud& cloud,
               const ChainResult& chain) {
  Json row = head(name, arguments, cloud);
  const PaperBytes paper = paper_bytes(chain);
  add_sizes(row, cloud, chain.bytes);
  row["text_bytes"] = paper.text();
  row["hull3_bytes"] = paper.hull3;
  row["hull2_bytes"] = paper.hull2;
  row["coefficient_bytes"] = paper.coefficients;
  row["float32_bytes"] = paper.float32;
  row["filtered"] = chain.filtered;
  row["in_regions"] = chain.in_regions;
  row["in_planes"] = chain.in_planes;
  row["hull_points"] = chain.hull_points;
  row["clusters"] = chain.clusters;
  row["regions"] = chain.regions;
  row["planes"] = chain.planes;
  row["intra_mm"] = chain.intra_mm;
  row["inter_mm"] = chain.inter_mm;
  row["encode_ms"] = chain.encode_ms;
  row["decode_ms"] = chain.decode_ms;
  add_distances(row, cloud, chain.random_cloud);
  return row;
}

CloudDistance distance(const PointList& a, const PointList& b) {
  DistanceOptions fast;
  fast.point_to_plane = false;
  return cloud_distance(a, b, fast);
}
double rmse_mm(const PointList& a, const PointList& b) {
  return distance(a, b).d1 * 1e3;
}

void add_kept(Json& row, const ChainResult& chain) {
  const CloudDistance kept = distance(chain.kept_cloud, chain.random_cloud);
  row["d1_kept_mm"] = kept.d1 * 1e3;
  row["kept_ab_mm"] = kept.d1_ab * 1e3;
  row["kept_ba_mm"] = kept.d1_ba * 1e3;
}

void evaluate_chain(const Arguments& arguments, const Cloud& cloud) {
  const ChainResult chain = run_chain(cloud.points, {}, true);
  Json row = chain_row("chain", arguments, cloud, chain);
  row["d1_filtered_mm"] = rmse_mm(chain.filtered_cloud, chain.random_cloud);
  add_kept(row, chain);
  Json lattice;
  add_distances(lattice, cloud, chain.lattice_cloud);
  row["lattice"] = lattice;
  fmt::print("{}\n", row.dump());
}

void sweep(const Arguments& arguments, const Cloud& cloud) {
  for (const double degrees : kSweep_deg) {
    ChainOptions options;
    options.smoothness_deg = degrees;
    const ChainResult chain = run_chain(cloud.points, options, false);
    Json row = chain_row("sweep", arguments, cloud, chain);
    row["smoothness_deg"] = degrees;
    row["d1_kept_mm"] = rmse_mm(chain.kept_cloud, chain.random_cloud);
    fmt::print("{}\n", row.dump());
  }
}

// PCL's own chain, and ours with its parameters.
void against_pcl(const Arguments& arguments, const Cloud& cloud) {
  const auto print = [&](const char* name, const ChainResult& chain) {
    Json row = chain_row(name, arguments, cloud, chain);
    add_kept(row, chain);
    fmt::print("{}\n", row.dump());
  };
  print("same", run_chain(cloud.points, pcl_options(), false));
  if (pcl_available()) {
    print("pcl", run_pcl_chain(cloud.points));
  } else {
    fmt::print("{}\n", Json{{"row", "skipped"}, {"name", "PCL's chain (libpcl-dev)"}}.dump());
  }
}

void compare(const Arguments& arguments, const Cloud& cloud) {
  std::vector<std::string> skipped;
  for (const auto& codec : baselines::point_set(skipped)) {
    Json row = head("baseline", arguments, cloud);
    row["codec"] = codec->name();
    row["setting"] = codec->setting();
    const double begin = thread_cpu_ms();
    const baselines::Bytes bytes = codec->encode(cloud.points);
    const double middle = thread_cpu_ms();
    const PointList decoded = codec->decode(bytes);
    row["encode_ms"] = middle - begin;
    row["decode_ms"] = thread_cpu_ms() - middle;
    add_sizes(row, cloud, bytes.size());
    add_distances(row, cloud, decoded);
    fmt::print("{}\n", row.dump());
  }
  for (const std::string& name : skipped)
    fmt::print("{}\n", Json{{"row", "skipped"}, {"name", name}}.dump());
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{"The paper's evaluation on one cloud."};
  CodecOptions options;
  Arguments arguments;
  app.add_option("class", arguments.kind, "high, medium, low, complex, ...");
  app.add_option("name", arguments.name, "of the cloud");
  app.add_option("inputs", arguments.inputs, "a file, or sim:room; the first frame counts");
  app.add_flag("--sweep", arguments.sweep, "also the sweep of the smoothness threshold");
  app.add_flag("--compare", arguments.compare, "also the systems that the paper compares with");
  app.add_flag("--pcl", arguments.pcl, "also the same chain by PCL, and ours with its parameters");
  add_codec_options(app, options);
  if (const auto code = parse_command_line(app, argc, argv, options)) return to_int(*code);
  try {
    const Cloud cloud = read_cloud(arguments, options);
    evaluate_chain(arguments, cloud);
    if (arguments.sweep) sweep(arguments, cloud);
    if (arguments.pcl) against_pcl(arguments, cloud);
    if (arguments.compare) compare(arguments, cloud);
  } catch (const std::exception& error) {
    fmt::print(stderr, "paper: {}: {}\n", arguments.name, error.what());
    return to_int(ExitCode::kFailed);
  }
  return 0;
}
