#include "apps/common/stream_settle.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "core/fit/lattice_fit.hpp"

namespace planecast {
namespace {

// A noise model for a sensor nobody named: one level of its lattice, or time of flight.
NoiseModel default_noise(const StreamConfig& config, std::vector<std::string>& notes) {
  NoiseModel noise;
  if (!config.lattice.present()) {
    noise.kind = NoiseModel::Kind::kTof;
    noise.s_e9 = 5'000'000;
    notes.push_back(
        fmt::format("noise model {} assumed; name your own with --noise", to_string(noise)));
    return noise;
  }
  const double c_m =
      config.lattice.c_q8 / 256.0 * static_cast<double>(config.camera.unit_pm) * 1e-12;
  noise.kind = NoiseModel::Kind::kStereo;
  noise.s_e9 = static_cast<std::uint32_t>(std::clamp(std::round(1e9 / c_m), 1.0, 4e9));
  notes.push_back(fmt::format(
      "noise model {} from the lattice's spacing; name your own with --noise", to_string(noise)));
  return noise;
}

}  // namespace

void settle_tolerance(const CodecOptions& options, StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  const double value = options.tolerance.value;
  config.tolerance = options.tolerance.kind;
  switch (config.tolerance) {
    case ToleranceKind::kLossless:
      break;
    case ToleranceKind::kMetres:
      config.tolerance_100nm = static_cast<std::uint32_t>(std::min(value * 1e7 + 1e-3, 4.0e9));
      break;
    case ToleranceKind::kSigma:
    case ToleranceKind::kSurfaces:
      config.sigmas_q16 = static_cast<std::uint32_t>(std::llround(value * 65536));
      break;
  }
  config.drop_off_surface =
      options.off_surface == OffSurface::kDrop && config.tolerance == ToleranceKind::kSurfaces;
  setup.bound_m = config.tolerance == ToleranceKind::kMetres ? value : 0;
  setup.contract = {config.tolerance, value, {}};
}

Result<std::optional<Intrinsics>> given_camera(const CodecOptions& options, std::uint32_t width,
                                               std::uint32_t height, const std::string& name,
                                               std::vector<std::string>& notes) {
  auto camera = intrinsics_of(options);
  if (!camera || options.camera->width == 0 ||
      (options.camera->width == width && options.camera->height == height)) {
    return camera;
  }
  const CameraChoice& preset = *options.camera;
  if (std::uint64_t{width} * preset.height != std::uint64_t{height} * preset.width) {
    return Error{Status::kUsage,
                 fmt::format("{}: is {}x{}, but --camera {} stands for {}x{}; give this image's "
                             "own figures: --camera FX,FY,CX,CY",
                             name, width, height, preset.preset, preset.width, preset.height)};
  }
  const double scale = static_cast<double>(width) / preset.width;
  camera->fx *= scale;
  camera->fy *= scale;
  camera->cx = (camera->cx + 0.5) * scale - 0.5;
  camera->cy = (camera->cy + 0.5) * scale - 0.5;
  notes.push_back(fmt::format("camera {} scaled from {}x{} to {}x{}", preset.preset, preset.width,
                              preset.height, width, height));
  return camera;
}

Result<Done> settle_camera(const Intrinsics& intrinsics, std::uint32_t width, std::uint32_t height,
                           StreamConfig& config) {
  const auto camera = quantise(intrinsics, width, height);
  if (!camera.ok()) return camera.error();
  config.camera = *camera;
  return Done{};
}

void settle_lattice(const std::vector<std::uint16_t>& depth, StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  const auto lattice = find_lattice(depth);
  if (!lattice) return;
  config.lattice = *lattice;
  setup.notes.push_back(fmt::format("depth lies on a lattice: C = {:.3f} counts, offset {:.5f}{}",
                                    lattice->c_q8 / 256.0, lattice->offset_q16 / 65536.0,
                                    lattice->truncated ? ", cut" : ""));
}

void settle_noise(const CodecOptions& options, const SourceSensor& sensor, StreamSetup& setup) {
  StreamConfig& config = setup.encoder.stream;
  if (const auto given = noise_or_preset(options)) {
    config.noise = *given;
  } else if (sensor.noise) {
    config.noise = *sensor.noise;
  } else {
    std::vector<std::string> quiet;
    const bool needed =
        config.tolerance == ToleranceKind::kSigma || config.tolerance == ToleranceKind::kSurfaces;
    config.noise = default_noise(config, needed ? setup.notes : quiet);
  }
  setup.contract.noise = config.noise;
}

void settle_range(const CodecOptions& options, StreamSetup& setup) {
  if (!options.range) return;
  const double unit = static_cast<double>(setup.encoder.stream.camera.unit_pm) * 1e-12;
  StageOptions& stages = setup.encoder.stages;
  stages.range_min = static_cast<std::uint16_t>(
      std::clamp(std::ceil(options.range->min_m / unit - 1e-6), 0.0, 65535.0));
  stages.range_max = static_cast<std::uint16_t>(
      std::clamp(std::floor(options.range->max_m / unit + 1e-6), 0.0, 65535.0));
}

}  // namespace planecast
