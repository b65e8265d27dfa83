#include "apps/planecast/describe.hpp"

#include <fmt/format.h>

#include <algorithm>

#include "core/model/point_grid.hpp"
#include "core/sensor/pose_fixed.hpp"

namespace planecast {
namespace {

const char* name_of(FrameKind kind) {
  switch (kind) {
    case FrameKind::kRawCloud:
      return "raw cloud";
    case FrameKind::kPoints:
      return "points";
    case FrameKind::kDepth:
      break;
  }
  return "depth";
}

const char* name_of(ZRule rule) {
  switch (rule) {
    case ZRule::kProductInFloat:
      return "float product";
    case ZRule::kPrinted7:
      return "float product printed with 7 digits";
    case ZRule::kProductInDouble:
      break;
  }
  return "double product";
}

const char* name_of(ClockDomain clock) {
  switch (clock) {
    case ClockDomain::kMonotonic:
      return "monotonic";
    case ClockDomain::kRealtime:
      return "realtime";
    case ClockDomain::kSensor:
      return "sensor";
    case ClockDomain::kUnknown:
      break;
  }
  return "unknown";
}

Json pose_of(const PoseFixed& fixed) {
  const Pose p = to_pose(fixed);
  return {{"quaternion_wxyz", {p.qw, p.qx, p.qy, p.qz}}, {"translation_m", {p.tx, p.ty, p.tz}}};
}

Json camera_of(const CameraModel& model) {
  const Intrinsics c = to_intrinsics(model);
  return {{"width", model.width},
          {"height", model.height},
          {"fx", c.fx},
          {"fy", c.fy},
          {"cx", c.cx},
          {"cy", c.cy},
          {"distortion_k1_k2_p1_p2_k3", {c.k1, c.k2, c.p1, c.p2, c.k3}},
          {"metres_per_unit", c.metres_per_unit}};
}

Json lattice_of(const Lattice& lattice) {
  if (!lattice.present()) return nullptr;
  return {{"c_counts", lattice.c_q8 / 256.0},
          {"offset", lattice.offset_q16 / 65536.0},
          {"rounding", lattice.truncated ? "cut" : "nearest"}};
}

Json tolerance_of(const StreamConfig& config) {
  switch (config.tolerance) {
    case ToleranceKind::kLossless:
      break;
    case ToleranceKind::kMetres:
      return {{"kind", "metres"}, {"bound_m", config.tolerance_100nm * 1e-7}};
    case ToleranceKind::kSigma:
      return {{"kind", "sigma"}, {"sigmas", config.sigmas_q16 / 65536.0}};
    case ToleranceKind::kSurfaces:
      return {{"kind", "surfaces"},
              {"sigmas", config.sigmas_q16 / 65536.0},
              {"off_surface", config.drop_off_surface ? "drop" : "keep"}};
  }
  return {{"kind", "lossless"}};
}

// A coefficient of inverse depth in 1/m.
double per_metre(std::int32_t coefficient, const CameraModel& camera) {
  return coefficient / 2147483648.0 / (static_cast<double>(camera.unit_pm) * 1e-12);
}

Json surface_of(const Surface& s, const CameraModel& camera) {
  Json out = {{"wire_abc", {s.a, s.b, s.c}},
              {"inverse_depth_per_m",
               {per_metre(s.a, camera), per_metre(s.b, camera), per_metre(s.c, camera)}}};
  if (!s.curved()) return out;
  out["wire_def"] = {s.d, s.e, s.f};
  for (const std::int32_t bend : {s.d, s.e, s.f})
    out["inverse_depth_per_m"].push_back(per_metre(bend, camera));
  return out;
}

// Nine digits: all that a float32 or a Q16 number has, without the tail of a double.
std::string scalar(const Json& value) {
  if (value.is_null()) return "none";
  if (value.is_string()) return value.get<std::string>();
  return value.is_number_float() ? fmt::format("{:.9g}", value.get<double>()) : value.dump();
}

bool flat(const Json& value) {
  return std::none_of(value.begin(), value.end(),
                      [](const Json& item) { return item.is_structured(); });
}

}  // namespace

std::string hex32(std::uint32_t value) {
  return fmt::format("0x{:08x}", value);
}

Json describe(const StreamConfig& config) {
  const bool raw = config.kind == FrameKind::kRawCloud;
  Json out = {
      {"kind", name_of(config.kind)},     {"stream", config.stream},
      {"session", hex32(config.session)}, {"clock", name_of(config.clock)},
      {"epoch_ns", config.epoch_ns},      {"boot_id", hex32(config.boot_id)},
      {"period_ms", config.period_ms},    {"frame_id", std::string(config.frame_id.data())}};
  if (config.kind == FrameKind::kPoints) {
    out["max_points"] = config.points.max_points;
    out["step_m"] = grid_step_m(config.points);
    out["tolerance_steps"] = config.points.tolerance_steps;
    out["patch_unit_m"] = config.points.patch_unit_nm * 1e-9;
    out["fill"] = config.points.fill == FillMode::kRandom ? "random" : "lattice";
    out["seed"] = config.points.seed;
    out["noise"] = to_string(config.noise);
  } else if (raw) {
    out["width"] = config.camera.width;
    out["height"] = config.camera.height;
  } else {
    out["camera"] = camera_of(config.camera);
    out["z_rule"] = name_of(config.z_rule);
    out["lattice"] = lattice_of(config.lattice);
    out["noise"] = to_string(config.noise);
  }
  out["tolerance"] = tolerance_of(config);
  out["effort"] = config.effort_best ? "best" : "fast";
  out["pose"] = pose_of(config.pose);
  if (config.kind == FrameKind::kPoints) {
    out["origin_m"] = {static_cast<double>(config.axes.t_um[0]) / 1e6,
                       static_cast<double>(config.axes.t_um[1]) / 1e6,
                       static_cast<double>(config.axes.t_um[2]) / 1e6};
  } else if (!raw) {
    out["cloud_from_optical"] = pose_of(config.axes);
    out["mirror_y"] = config.mirror_y;
  }
  return out;
}

Json describe(const PacketHeader& header, const TileContent& tile, const CameraModel& camera,
              std::size_t bytes) {
  const TileSpan span = tile_span(camera, tile.rect);
  Json out = {{"slice", header.slice},
              {"slice_count", header.slice_count},
              {"bytes", bytes},
              {"key_hash", hex32(header.key_hash)},
              {"tile_blocks_x_y_w_h", {tile.rect.bx, tile.rect.by, tile.rect.bw, tile.rect.bh}},
              {"tile_pixels_u0_v0_u1_v1", {span.u0, span.v0, span.u1, span.v1}},
              {"points", tile.points},
              {"corrections", tile.corrections},
              {"verbatim", tile.verbatim},
              {"runs", tile.runs},
              {"surfaces", Json::array()}};
  for (std::uint32_t i = 0; i < tile.surfaces; ++i)
    out["surfaces"].push_back(surface_of(tile.surface[i], camera));
  return out;
}

Json describe(const PacketHeader& header, const ListContent& content, std::size_t bytes) {
  return {{"slice", header.slice},
          {"slice_count", header.slice_count},
          {"bytes", bytes},
          {"key_hash", hex32(header.key_hash)},
          {"holds", content.what},
          {"points", content.points},
          {"surfaces", content.surfaces}};
}

std::string readable(const Json& value, int indent) {
  std::string out;
  const std::string space(static_cast<std::size_t>(indent), ' ');
  std::size_t number = 0;
  for (const auto& [key, item] : value.items()) {
    if (!out.empty()) out += '\n';
    const std::string label = value.is_array() ? fmt::format("[{}]", number++) : key + ":";
    if (item.is_array() && flat(item)) {
      std::string joined;
      for (const Json& part : item) joined += (joined.empty() ? "" : ", ") + scalar(part);
      out += space + label + " " + (joined.empty() ? "none" : joined);
    } else if (item.is_structured()) {
      out += space + label + "\n" + readable(item, indent + 2);
    } else {
      out += space + label + " " + scalar(item);
    }
  }
  return out;
}

}  // namespace planecast
