#include "apps/recv/recv_options.hpp"

#include <fmt/format.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <filesystem>
#include <utility>

#include "apps/common/packet_parse.hpp"
#include "apps/common/suggestion.hpp"
#include "core/wire/key_packet.hpp"

namespace planecast {
namespace {

constexpr std::array kFormats = {
    std::pair{FrameFormat::kPly, "ply"}, std::pair{FrameFormat::kPcd, "pcd"},
    std::pair{FrameFormat::kPng, "png"}, std::pair{FrameFormat::kBin, "bin"}};
constexpr std::uint32_t kLiveDeadlineMs = 100;
// Where every frame counts a busy computer may pause us longer, at the price of latency after loss
// and of liblcm allocating while it holds more than its usual 100 messages.
constexpr std::uint32_t kPatientDeadlineMs = 1000;
constexpr std::uint16_t kPatientQueue = 1000;
// Frames that wait for a receiving thread held up: about a second of one stream.
constexpr std::uint16_t kKeptFrames = 32, kLeastKeptFrames = 8;
constexpr const char* kSinks = "Output";
constexpr const char* kReports = "Reports";
constexpr const char* kRun = "Run";

Result<FrameFormat> parse_format(std::string_view text) {
  std::vector<std::string> names;
  for (const auto& [format, name] : kFormats) {
    if (text == name) return format;
    names.emplace_back(name);
  }
  return {Status::kUsage,
          fmt::format("'{}' is not one of: ply, pcd, png, bin{}", text, did_you_mean(text, names))};
}

/// Hands text to a parser and what it gives to `member`; a refusal names the flag.
template <class T, class Member>
void add(CLI::App& app, const std::string& flag, Result<T> (*parse)(std::string_view),
         Member& member, const char* type, const char* group, const char* help) {
  const auto set = [flag, parse, &member](const std::string& text) {
    const Result<T> value = parse(text);
    if (!value) throw CLI::ValidationError(flag, value.error().message);
    member = static_cast<Member>(*value);
  };
  app.add_option_function<std::string>(flag, set, help)
      ->option_text(type)
      ->group(group)
      ->take_last();
}

void add_text(CLI::App& app, const char* flag, std::string& member, const char* type,
              const char* group, const char* help) {
  app.add_option(flag, member, help)->option_text(type)->group(group)->take_last();
}

void add_sinks(CLI::App& app, RecvOptions& options) {
  add_text(app, "--out", options.out_folder, "FOLDER", kSinks,
           "Write every frame into this folder, named by stream and number:\n"
           "camera-000012.ply. Frames that the disk is too slow for are\n"
           "dropped and counted");
  add(app, "--format", parse_format, options.format, "ply|pcd|png|bin", kSinks,
      "Files of --out; png is the depth image. Default: ply");
  add_text(app, "--last", options.last_file, "FILE", kSinks,
           "Write the last complete frame at the end (.ply .pcd .png .bin)");
  add_text(app, "--picture", options.picture_file, "FILE.png", kSinks,
           "Draw the last complete frame at the end: original depth (with\n"
           "--reference), label map, regenerated depth");
  app.add_option("--publish-plain", options.publish_name,
                 "Publish plain clouds for LCM viewers on DRAKE_POINT_CLOUD_NAME,\n"
                 "thinned to 5400 points, one datagram. Default name: camera")
      ->expected(0, 1)
      ->option_text("[NAME]")
      ->group(kSinks);
  app.add_flag("--full-cloud", options.full_cloud,
               "With --publish-plain: every point, in fragments")
      ->group(kSinks);
}

void add_reports(CLI::App& app, RecvOptions& options) {
  app.add_flag("--stats", options.stats,
               "Say more every second, and print every counter at the end")
      ->group(kReports);
  add_text(app, "--status", options.status_file, "FILE", kReports,
           "Append a line of key=value a second and stream, for scripts");
  add_text(app, "--reference", options.reference, "INPUT", kReports,
           "Compare every point with the input that planecastd plays (give its\n"
           "options as well); ends with 5 when a bound is exceeded, with 1 when\n"
           "a frame is missing or incomplete");
}

Result<std::uint64_t> parse_frames(std::string_view text) {
  return parse_whole(text, 0, 1'000'000'000'000, "300");
}
Result<std::uint64_t> parse_streams(std::string_view text) {
  return parse_whole(text, 1, kMaxStreams, "4");
}
Result<std::uint64_t> parse_deadline(std::string_view text) {
  return parse_whole(text, 1, 60'000, "100");
}
Result<double> parse_timeout(std::string_view text) {
  return parse_number(text, 0.01, 1e6, "10");
}

void add_run(CLI::App& app, RecvOptions& options) {
  add(app, "--frames", parse_frames, options.frames, "N", kRun,
      "End after N frames of all streams together, lost ones included.\n"
      "Default: run until interrupted");
  add(app, "--timeout", parse_timeout, options.timeout_s, "SECONDS", kRun,
      "End with 1 when nothing arrives for so long. Default: wait");
  add(app, "--streams", parse_streams, options.streams, "N", kRun,
      "Most streams side by side, 1 to 16; memory for all is taken at\nstart. Default: 4");
  add(app, "--max-size", parse_size, options.max_size, "WxH", kRun,
      "Largest frame; larger streams are refused. Default: 1280x1024");
  add(app, "--deadline-ms", parse_deadline, options.deadline_ms, "MS", kRun,
      "How long a frame's missing slices are waited for. Default: 100;\n"
      "1000 with --out, --frames or --reference");
}

}  // namespace

void add_recv_options(CLI::App& app, RecvOptions& options) {
  add_sinks(app, options);
  add_reports(app, options);
  add_run(app, options);
  add_realtime_options(app, options.realtime);
}

Result<Done> check_recv_options(const RecvOptions& options) {
  if (options.full_cloud && !options.publish_name) {
    return {Status::kUsage, "--full-cloud: says how --publish-plain publishes; add that as well"};
  }
  if (!options.last_file.empty()) {
    const auto format = format_of(options.last_file);
    if (!format.ok()) return {Status::kUsage, "--last: " + format.error().message};
  }
  if (!options.picture_file.empty() &&
      std::filesystem::path(options.picture_file).extension() != ".png") {
    return {Status::kUsage, "--picture: '" + options.picture_file +
                                "' must end in .png; it is the only kind of picture written"};
  }
  std::error_code ignored;
  if (!options.out_folder.empty() && std::filesystem::exists(options.out_folder, ignored) &&
      !std::filesystem::is_directory(options.out_folder, ignored)) {
    return {Status::kUsage, "--out: '" + options.out_folder +
                                "' is a file; name a folder, or use --last for one frame"};
  }
  return Done{};
}

SubscriberConfig subscriber_for(const RecvOptions& options, const CodecOptions& codec) {
  SubscriberConfig config;
  config.channel = codec.channel;
  config.parse = parse_planecast_packet;
  config.message_bytes = codec.slice_bytes;
  AssemblerConfig& assembly = config.assembly;
  assembly.frame_bits = kPacketFrameBits;
  assembly.max_streams = options.streams;
  // A depth frame stored as it is has two bytes a pixel; the smallest slices hold 200 of them.
  const std::uint64_t pixels = std::uint64_t{options.max_size.width} * options.max_size.height;
  // A list's points coded as they are have twelve; where the user says how many, they all fit.
  const std::uint64_t list = std::uint64_t{codec.max_points.value_or(0)} * 13;
  assembly.max_frame_bytes = static_cast<std::uint32_t>(
      std::clamp<std::uint64_t>(std::max(pixels * 2 + pixels / 4, list), 1U << 20U, 1U << 28U));
  assembly.max_slices = std::clamp<std::uint32_t>(assembly.max_frame_bytes / 200, 2048, 65535);
  const bool every = options.keeps_every_frame();
  assembly.output_frames =
      every ? std::max<std::uint16_t>(kKeptFrames / options.streams, kLeastKeptFrames) : 1;
  const std::uint32_t deadline_ms = options.deadline_ms != 0 ? options.deadline_ms
                                    : every                  ? kPatientDeadlineMs
                                                             : kLiveDeadlineMs;
  assembly.deadline_ns = std::int64_t{deadline_ms} * 1'000'000;
  if (every) config.lcm_queue = kPatientQueue;
  config.on_thread_start = dress_this_thread;
  return config;
}

const char* extension(FrameFormat format) noexcept {
  for (const auto& [known, name] : kFormats) {
    if (known == format) return name;
  }
  return "";
}

Result<FrameFormat> format_of(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  if (!ending.empty()) ending.erase(0, 1);
  const auto format = parse_format(ending);
  if (format.ok()) return format;
  return {Status::kUsage, "'" + path + "' must end in .ply, .pcd, .png or .bin"};
}

}  // namespace planecast
