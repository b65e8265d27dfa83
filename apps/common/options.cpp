#include "apps/common/options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <functional>
#include <utility>
#include <vector>

#include "apps/common/suggestion.hpp"

namespace planecast {
namespace {

/// One option: how it is named and explained, and what its text does to the struct.
struct Spec {
  const char* name;  // without the dashes
  const char* type;
  const char* group;
  const char* help;
  std::function<Result<Done>(CodecOptions&, const std::string&)> set;
};

/// A setter that parses and assigns to a member.
template <class T, class Member>
auto into(Result<T> (*parse)(std::string_view), Member CodecOptions::*member) {
  return [=](CodecOptions& options, const std::string& text) -> Result<Done> {
    Result<T> value = parse(text);
    if (!value) return value.error();
    options.*member = std::move(*value);
    return Done{};
  };
}

template <class Member>
auto number(double least, double most, const char* example, Member CodecOptions::*member) {
  return [=](CodecOptions& options, const std::string& text) -> Result<Done> {
    const Result<double> value = parse_number(text, least, most, example);
    if (!value) return value.error();
    options.*member = *value;
    return Done{};
  };
}

/// A number that may be left to the input.
auto whole(std::uint64_t least, std::uint64_t most, const char* example,
           std::optional<std::uint32_t> CodecOptions::*member) {
  return [=](CodecOptions& options, const std::string& text) -> Result<Done> {
    const Result<std::uint64_t> value = parse_whole(text, least, most, example);
    if (!value) return value.error();
    options.*member = static_cast<std::uint32_t>(*value);
    return Done{};
  };
}

template <class Whole>
auto whole(std::uint64_t least, std::uint64_t most, const char* example,
           Whole CodecOptions::*member) {
  return [=](CodecOptions& options, const std::string& text) -> Result<Done> {
    const Result<std::uint64_t> value = parse_whole(text, least, most, example);
    if (!value) return value.error();
    options.*member = static_cast<Whole>(*value);
    return Done{};
  };
}

/// A setter for one of two words.
template <class Choice>
auto either(const char* first, Choice if_first, const char* second, Choice if_second,
            Choice CodecOptions::*member) {
  return [=](CodecOptions& options, const std::string& text) -> Result<Done> {
    if (text != first && text != second) {
      const std::vector<std::string> words = {first, second};
      return {Status::kUsage, fmt::format("'{}' is not one of: {}, {}{}", text, first, second,
                                          did_you_mean(text, words))};
    }
    options.*member = text == first ? if_first : if_second;
    return Done{};
  };
}

/// A setter for a word of at most `longest` printable characters without spaces.
auto word(std::size_t longest, const char* example, std::string CodecOptions::*member) {
  return [=](CodecOptions& options, const std::string& text) -> Result<Done> {
    bool fine = !text.empty() && text.size() <= longest;
    for (const char c : text) fine = fine && c > ' ' && c < '\x7f';
    if (!fine) {
      return {Status::kUsage,
              fmt::format("'{}' is not a word of at most {} letters, digits and signs without "
                          "spaces; write for example {}",
                          text, longest, example)};
    }
    options.*member = text;
    return Done{};
  };
}

/// --alpha in metres, or with a unit.
Result<double> alpha_of(std::string_view text) {
  constexpr std::string_view kExample = "0.1 (metres) or 10cm";
  const Result<double> metres = parse_number(text, 1e-6, 1000.0, kExample);
  return metres ? metres : parse_length(text, kExample);
}

using O = CodecOptions;
constexpr const char* kSensor = "Sensor";
constexpr const char* kQuality = "Quality";
constexpr const char* kMethod = "Method";
constexpr const char* kStream = "Stream";

std::vector<Spec> sensor_specs() {
  return {
      {"camera", "NAME|FX,FY,CX,CY[,UNIT]", kSensor,
       "The camera: a known name (kinect1, realsense-d435, ...), or focal\n"
       "lengths and centre in pixels and the metres of one depth unit\n"
       "(0.001: millimetres, the default).\n"
       "Example: --camera 383.8,383.8,321.7,236.8,0.001",
       into(parse_camera, &O::camera)},
      {"distortion", "K1,K2,P1,P2[,K3]", kSensor,
       "Lens distortion as OpenCV names it. Default: none.\n"
       "Example: --distortion=-0.05,0.06,0,0",
       into(parse_distortion, &O::distortion)},
      {"size", "WxH", kSensor, "Width and height of .raw depth images. Example: --size 320x288",
       into(parse_size, &O::size)},
      {"units", "METRES", kSensor,
       "Metres of one unit of the input. Default: what the camera or the\n"
       "format says (depth images 0.001). Example: --units 0.001",
       number(1e-12, 1000.0, "0.001", &O::units_m)},
      {"lidar", "auto|MODEL", kSensor, "LiDAR model of packet captures. Default: auto",
       word(63, "auto", &O::lidar)},
      {"range", "MIN,MAX", kSensor,
       "Readings nearer or further than this are no readings [m]; they\n"
       "are counted. Default: all are kept. Example: --range 0.2,10",
       into(parse_range, &O::range)},
      {"noise", "stereo:S|tof:S|NAME", kSensor,
       "How far readings stray: sigma = S z^2 (stereo, structured light; S\n"
       "in 1/m), sigma = S (time of flight; S in m), or a camera's name.\n"
       "Default: the camera's, or an estimate from the frame.\n"
       "Example: --noise stereo:0.003",
       into(parse_noise, &O::noise)},
  };
}

std::vector<Spec> quality_specs() {
  return {
      {"tolerance", "0|10mm|2sigma|surfaces[:K]", kQuality,
       "How far a point may move: 0 lossless; a length (um, mm, cm, m);\n"
       "a multiple of the noise; or surfaces: points within K sigma (3) of a\n"
       "surface carry no correction. Holds for every point. Default: 2sigma",
       into(parse_tolerance, &O::tolerance)},
      {"off-surface", "keep|drop", kQuality,
       "With --tolerance surfaces: points on no surface are kept within the\n"
       "same bound, or dropped and counted. Default: keep",
       either("keep", OffSurface::kKeep, "drop", OffSurface::kDrop, &O::off_surface)},
      {"outliers", "keep|drop", kQuality,
       "Points far from all neighbours: keep them, or drop and count them.\n"
       "Default: keep",
       either("keep", Outliers::kKeep, "drop", Outliers::kDrop, &O::outliers)},
  };
}

std::vector<Spec> method_specs() {
  return {
      {"method", "grid|paper", kMethod,
       "grid: on the sensor's grid; paper: as published, for comparison\n"
       "(implies --tolerance surfaces --off-surface drop --outliers drop\n"
       "--regenerate random unless told otherwise). Default: grid",
       either("grid", Method::kGrid, "paper", Method::kPaper, &O::method)},
      {"regenerate", "lattice|random", kMethod,
       "How unorganised points are laid out on a surface. Default: lattice",
       either("lattice", Regenerate::kLattice, "random", Regenerate::kRandom, &O::regenerate)},
      {"alpha", "M", kMethod, "Largest gap that an outline spans [m]. Default: 0.02",
       into(alpha_of, &O::alpha_m)},
      {"smoothness", "DEGREES", kMethod, "Largest angle between normals in one region. Default: 3",
       number(0.01, 90.0, "3", &O::smoothness_deg)},
      {"k", "N", kMethod, "Neighbours that make a normal, 3 to 128. Default: 30",
       whole(3, 128, "30", &O::k)},
      {"effort", "fast|best", kMethod,
       "Depth images in real time, or smaller at five times the time.\nDefault: fast",
       either("fast", Effort::kFast, "best", Effort::kBest, &O::effort)},
      {"budget-ms", "MS", kMethod,
       "Time a frame may take; less is done to one that would take longer.\n"
       "Default: no limit. Example: --budget-ms 20",
       number(0.1, 1e6, "20", &O::budget_ms)},
      {"seed", "N", kMethod, "Start of every random choice. Default: 1",
       whole(0, ~std::uint64_t{0}, "1", &O::seed)},
      {"threads", "inline|pipeline", kMethod,
       "Run the stages on one thread, or one thread each; the bytes are the\n"
       "same. Default: pipeline",
       either("inline", Threads::kInline, "pipeline", Threads::kPipeline, &O::threads)},
  };
}

std::vector<Spec> stream_specs() {
  return {
      {"slice-bytes", "N", kStream,
       "Largest LCM payload, 256 to 60000; small ones lose less when a\n"
       "packet is lost. Default: 1200",
       whole(256, 60000, "1200", &O::slice_bytes)},
      {"max-points", "N", kStream,
       "Most points of a frame without order; memory for them is taken at\n"
       "start, larger frames are refused and counted. Default: a quarter\n"
       "more than the first frame has",
       whole(1, kMaxFramePoints, "300000", &O::max_points)},
      {"rate", "HZ", kStream, "Frames a second. Default: the source's own. Example: --rate 30",
       number(0.001, 10000.0, "30", &O::rate_hz)},
      {"repeat", "N", kStream, "Play the input N times; 0: until stopped. Default: 1",
       whole(0, 1'000'000'000, "1", &O::repeat)},
      {"name", "NAME", kStream, "Name of this stream. Default: camera",
       word(31, "camera", &O::name)},
      {"channel", "CHANNEL", kStream, "LCM channel. Default: PLANECAST",
       word(63, "PLANECAST", &O::channel)},
      {"lcm-url", "URL", kStream,
       "Where LCM sends. Default: LCM_DEFAULT_URL, else\n"
       "udpm://239.255.76.67:7667?ttl=0 (this host only)",
       [](CodecOptions& options, const std::string& text) -> Result<Done> {
         options.lcm_url = text;  // parse_lcm_url of transport checks it, with its own mend
         return Done{};
       }},
  };
}

void add(CLI::App& app, CodecOptions& options, Spec spec) {
  const std::string flag = std::string("--") + spec.name;
  const auto set = [&options, spec, flag](const std::string& text) {
    const Result<Done> done = spec.set(options, text);
    if (!done) throw CLI::ValidationError(flag, done.error().message);
    options.given.insert(spec.name);
  };
  app.add_option_function<std::string>(flag, set, spec.help)
      ->option_text(spec.type)
      ->group(spec.group)
      ->take_last();
}

}  // namespace

void add_codec_options(CLI::App& app, CodecOptions& options) {
  app.get_formatter()->column_width(34);
  for (const auto& specs : {sensor_specs(), quality_specs(), method_specs(), stream_specs()}) {
    for (const Spec& spec : specs) add(app, options, spec);
  }
  app.add_option("--config", "Options from a file, one a line: tolerance = \"10mm\"")
      ->option_text("FILE.toml")
      ->group(kStream);
}

Result<Done> finish_codec_options(CodecOptions& options) {
  if (options.method == Method::kPaper) {
    if (!options.is_given("tolerance")) options.tolerance = {ToleranceKind::kSurfaces, 3.0};
    const bool surfaces = options.tolerance.kind == ToleranceKind::kSurfaces;
    if (!options.is_given("off-surface") && surfaces) options.off_surface = OffSurface::kDrop;
    if (!options.is_given("outliers")) options.outliers = Outliers::kDrop;
    if (!options.is_given("regenerate")) options.regenerate = Regenerate::kRandom;
  }
  if (options.method == Method::kPaper && options.tolerance.kind != ToleranceKind::kSurfaces) {
    return {Status::kUsage,
            "--method paper: codes points by the surfaces they lie on; its tolerance is "
            "surfaces[:K], not " +
                to_string(options.tolerance) + ". For a bound on every point leave --method out"};
  }
  if (options.off_surface == OffSurface::kDrop &&
      options.tolerance.kind != ToleranceKind::kSurfaces) {
    return {Status::kUsage,
            "--off-surface drop: has no meaning with --tolerance " + to_string(options.tolerance) +
                ", which keeps every point; add --tolerance surfaces or leave it out"};
  }
  if (options.distortion && !options.camera) {
    return {Status::kUsage,
            "--distortion: needs the camera it belongs to; add --camera FX,FY,CX,CY"};
  }
  const bool two_units = options.units_m && options.camera && options.camera->unit_given;
  if (two_units && *options.units_m != options.camera->intrinsics.metres_per_unit) {
    return {Status::kUsage,
            fmt::format("--units: {} differs from the {} that --camera ends in; give one of them",
                        *options.units_m, options.camera->intrinsics.metres_per_unit)};
  }
  return Done{};
}

std::optional<Intrinsics> intrinsics_of(const CodecOptions& options) {
  if (!options.camera) return std::nullopt;
  Intrinsics out = options.camera->intrinsics;
  if (options.units_m) out.metres_per_unit = *options.units_m;
  if (options.distortion) {
    out.k1 = options.distortion->k1;
    out.k2 = options.distortion->k2;
    out.p1 = options.distortion->p1;
    out.p2 = options.distortion->p2;
    out.k3 = options.distortion->k3;
  }
  return out;
}

std::optional<NoiseModel> noise_or_preset(const CodecOptions& options) {
  if (options.noise) return options.noise;
  return options.camera ? options.camera->noise : std::nullopt;
}

std::string to_string(const Tolerance& tolerance) {
  switch (tolerance.kind) {
    case ToleranceKind::kLossless:
      return "0";
    case ToleranceKind::kMetres:
      return fmt::format("{:.6g}mm", tolerance.value * 1e3);
    case ToleranceKind::kSigma:
      return fmt::format("{:g}sigma", tolerance.value);
    case ToleranceKind::kSurfaces:
      return fmt::format("surfaces:{:g}", tolerance.value);
  }
  return "0";
}

}  // namespace planecast
