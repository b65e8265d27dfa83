// planecast decode: a .plc file into point files or depth images, one a frame.
#include <fmt/core.h>

#include <algorithm>
#include <array>
#include <filesystem>
#include <string>
#include <system_error>

#include "apps/common/live_line.hpp"
#include "apps/common/points_setup.hpp"
#include "apps/common/suggestion.hpp"
#include "apps/planecast/commands.hpp"
#include "apps/planecast/output_file.hpp"
#include "apps/planecast/plc_file.hpp"
#include "core/io/depth_png.hpp"
#include "core/io/depth_raw.hpp"
#include "core/io/point_file.hpp"
#include "core/sensor/pose_fixed.hpp"

namespace planecast {
namespace {

namespace fs = std::filesystem;

const std::array<std::string, 7> kFormats = {"ply", "pcd", "bin", "png", "raw", "xyz", "txt"};

// Where frames go: one file, or a folder of files of one format.
struct Target {
  fs::path path;
  bool folder = false;
  std::string format;
  bool depth() const { return format == "png" || format == "raw"; }
};

Result<std::string> check_format(std::string format) {
  if (!format.empty() && format.front() == '.') format.erase(0, 1);
  if (std::find(kFormats.begin(), kFormats.end(), format) != kFormats.end()) return format;
  return Error{Status::kUsage, "'" + format + "' is not written; choose ply, pcd, bin, png, raw, " +
                                   "xyz or txt" + did_you_mean(format, kFormats)};
}

Result<Target> find_target(const CommandArguments& arguments, std::size_t frames) {
  if (arguments.output.empty()) {
    return Error{Status::kUsage,
                 "decode: name where to write, -o OUT.ply for one frame or a folder for many"};
  }
  Target target{arguments.output, false, {}};
  std::error_code code;
  target.folder = fs::is_directory(target.path, code) || !target.path.has_filename() ||
                  !target.path.has_extension();
  std::string wanted = target.folder ? std::string("ply") : target.path.extension().string();
  if (!arguments.format.empty()) wanted = arguments.format;
  const auto format = check_format(wanted);
  if (!format.ok()) return format.error();
  target.format = *format;
  if (!target.folder && target.path.extension() != "." + target.format) {
    return Error{Status::kUsage, fmt::format("--format {}: contradicts -o {}; give one of them",
                                             target.format, arguments.output)};
  }
  if (!target.folder && frames > 1) {
    return Error{Status::kUsage,
                 fmt::format("-o {}: the file holds {} frames; name a folder for them, with "
                             "--format {}",
                             arguments.output, frames, target.format)};
  }
  if (target.folder && !fs::is_directory(target.path, code) &&
      !fs::create_directories(target.path, code) && code) {
    return Error{Status::kWriteFailed, arguments.output + ": " + code.message()};
  }
  return target;
}

PointCloud cloud_of(const Decoder& decoder) {
  const StreamConfig& config = decoder.config();
  PointCloud out;
  const bool list = config.kind == FrameKind::kPoints;
  out.width = list ? static_cast<std::uint32_t>(decoder.cloud().size()) : config.camera.width;
  out.height = list ? 1 : config.camera.height;
  if (list) set_origin(config, out);
  out.points.assign(decoder.cloud().begin(), decoder.cloud().end());
  out.viewpoint = to_pose(config.pose);
  return out;
}

Result<Done> write_frame(const Decoder& decoder, const Target& target, const fs::path& path) {
  if (!target.depth()) {
    const PointCloud cloud = cloud_of(decoder);
    return write_whole_file(path, [&](const fs::path& part) -> Result<Done> {
      const auto written = write_point_file(part, cloud);
      if (!written.ok()) return written.error();
      return Done{};
    });
  }
  if (decoder.config().kind != FrameKind::kDepth) {
    return Error{Status::kUsage,
                 path.string() + ": the stream holds float clouds, not depth; write ply or pcd"};
  }
  const CameraModel& camera = decoder.config().camera;
  const DepthImage image{
      camera.width, camera.height, {decoder.depth().begin(), decoder.depth().end()}};
  return write_whole_file(path, [&](const fs::path& part) {
    return target.format == "png" ? write_depth_png(part, image) : write_depth_raw(part, image);
  });
}

// Decodes one frame; slices that are not decodable are told and count as damage.
Result<Done> decode_frame(Decoder& decoder, const PlcFile& file, const PlcFrame& frame,
                          bool& damaged) {
  Status status = decoder.set_key(frame.key);
  if (status == Status::kOk) status = decoder.begin();
  if (status != Status::kOk) {
    return Error{status, fmt::format("{}: frame {}: key packet not usable ({})", file.path,
                                     frame.frame, to_string(status))};
  }
  for (const auto& slice : frame.slices) {
    status = decoder.add(slice);
    if (status == Status::kOk) continue;
    damaged = true;
    tell(
        {fmt::format("{}: byte {}: a slice of frame {} is not decodable ({}); holes stand in its "
                     "place",
                     file.path, slice.data() - file.bytes.data(), frame.frame, to_string(status))});
  }
  (void)decoder.finish();
  return Done{};
}

fs::path frame_path(const Target& target, const PlcFile& file, std::size_t i) {
  if (!target.folder) return target.path;
  // By place in the file: frame numbers may wrap, and streams may stand side by side.
  return target.path /
         fmt::format("{}_{:06}.{}", fs::path(file.path).stem().string(), i, target.format);
}

// The pose is part of PCD only.
void tell_lost_pose(const Decoder& decoder, const Target& target) {
  if (target.format == "pcd" || target.depth() || decoder.config().pose == PoseFixed{}) return;
  tell({"the sensor's pose is not part of ." + target.format + "; write pcd to keep it"});
}

Result<std::size_t> decode_all(const PlcFile& file, const Target& target, bool& damaged) {
  const auto limits = limits_of(file);
  if (!limits.ok()) return limits.error();
  auto decoder = Decoder::create({*limits});
  if (!decoder.ok()) return decoder.error();
  const bool show = terminal_columns(stderr) > 0;
  LiveLine line(stderr, LiveLine::Style::kReplace);
  std::size_t written = 0;
  for (std::size_t i = 0; i < file.contents.frames.size(); ++i) {
    if (file.cut_short(i)) continue;
    const auto decoded = decode_frame(**decoder, file, file.contents.frames[i], damaged);
    if (!decoded.ok()) return decoded.error();
    if (written == 0) tell_lost_pose(**decoder, target);
    const auto done = write_frame(**decoder, target, frame_path(target, file, i));
    if (!done.ok()) return done.error();
    ++written;
    if (show && line.due())
      line.print(fmt::format("{} of {} frames", written, file.contents.frames.size()));
  }
  return written;
}

}  // namespace

ExitCode run_decode(const CommandArguments& arguments, const CodecOptions& /*options*/) {
  const auto file = open_plc(arguments.inputs);
  if (!file.ok()) return complain(file.error());
  tell(file->missing());
  const auto target = find_target(arguments, file->contents.frames.size());
  if (!target.ok()) return complain(target.error());
  bool damaged = file->damaged();
  const auto written = decode_all(*file, *target, damaged);
  if (!written.ok()) return complain(written.error());
  if (*written == 0)
    return complain(
        {Status::kUnreadable, file->path + ": holds no whole frame; nothing was written"});
  fmt::print(stderr, "{}: {} frame{} written to {}\n", file->path, *written,
             *written == 1 ? "" : "s", target->path.string());
  return damaged ? ExitCode::kBadInput : ExitCode::kDone;
}

}  // namespace planecast
