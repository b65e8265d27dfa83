// The options that every command shares (planecast encode / decode / eval, planecastd,
// planecast-recv): one struct, one place that names, explains and checks them.
#pragma once

#include <cstdint>
#include <optional>
#include <set>
#include <string>

#include "apps/common/parse_values.hpp"
#include "core/base/status.hpp"
#include "core/sensor/noise_model.hpp"

namespace CLI {
class App;
}

namespace planecast {

enum class OffSurface : std::uint8_t { kKeep, kDrop };
enum class Outliers : std::uint8_t { kKeep, kDrop };
enum class Method : std::uint8_t { kGrid, kPaper };
enum class Regenerate : std::uint8_t { kLattice, kRandom };
enum class Effort : std::uint8_t { kFast, kBest };
enum class Threads : std::uint8_t { kInline, kPipeline };

/// Everything the shared options say, with the defaults a user gets. Unset optionals mean "not
/// told": the sensor's preset, the file or an estimate decides.
struct CodecOptions {
  // Sensor
  std::optional<CameraChoice> camera;
  std::optional<Distortion> distortion;
  std::optional<ImageSize> size;  ///< of .raw input
  std::optional<double> units_m;  ///< metres of one unit of the input
  std::string lidar = "auto";
  std::optional<RangeLimits> range;  ///< [m]
  std::optional<NoiseModel> noise;   ///< as given; see noise_or_preset()
  // Quality
  Tolerance tolerance;
  OffSurface off_surface = OffSurface::kKeep;
  Outliers outliers = Outliers::kKeep;
  // Method
  Method method = Method::kGrid;
  Regenerate regenerate = Regenerate::kLattice;
  double alpha_m = 0.02;        ///< largest gap that a hull spans [m]
  double smoothness_deg = 3.0;  ///< largest angle between normals within one region
  std::uint32_t k = 30;         ///< neighbours that make a normal
  Effort effort = Effort::kFast;
  std::optional<double> budget_ms;
  std::uint64_t seed = 1;
  // Stream
  std::uint32_t slice_bytes = 1200;
  std::optional<std::uint32_t> max_points;  ///< of a list of points; unset: from the first frame
  std::optional<double> rate_hz;            ///< unset: the source's own rate
  std::uint64_t repeat = 1;                 ///< times the input is played; 0: until stopped
  std::string name = "camera";              ///< of the stream
  std::string channel = "PLANECAST";
  std::string lcm_url;  ///< "": LCM's default (parse_lcm_url reads it so)
  Threads threads = Threads::kPipeline;

  std::set<std::string> given;  ///< names ("tolerance") that a flag, the environment or a file set

  bool is_given(const std::string& option) const { return given.contains(option); }
};

/// Adds every shared option to `app`, writing into `options`, which must outlive the parse. Call
/// parse_command_line() (command_line.hpp) to read them: it adds environment and file.
void add_codec_options(CLI::App& app, CodecOptions& options);

/// Applies what one option implies for others (--method paper) and refuses combinations that
/// contradict each other or would silently do nothing. kUsage. parse_command_line() calls it.
Result<Done> finish_codec_options(CodecOptions& options);

/// Camera figures with --distortion and --units applied; nothing when no camera was given.
std::optional<Intrinsics> intrinsics_of(const CodecOptions& options);

/// The noise model given, else the preset's; nothing when neither is known.
std::optional<NoiseModel> noise_or_preset(const CodecOptions& options);

/// The tolerance as it is written on the command line: "0", "10mm", "2sigma", "surfaces:3".
std::string to_string(const Tolerance& tolerance);

}  // namespace planecast
