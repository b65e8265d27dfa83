#include "apps/common/frame_source.hpp"

#include <fmt/format.h>

#include <filesystem>
#include <utility>

#include "core/io/depth_png.hpp"
#include "core/io/depth_raw.hpp"
#include "core/io/file_kind.hpp"
#include "core/io/file_list.hpp"
#include "core/io/point_file.hpp"
#include "core/sim/sim_room.hpp"
#include "core/sim/sim_scan.hpp"

namespace planecast {
namespace {

constexpr double kFileRateHz = 30;
constexpr std::uint64_t kSimFrames = 90;  // three seconds

std::int64_t stamp_of(std::uint64_t number, double rate_hz) {
  return static_cast<std::int64_t>(static_cast<double>(number) * 1e9 / rate_hz);
}

class FileSource : public FrameSource {
 public:
  FileSource(std::vector<std::filesystem::path> files, std::vector<std::filesystem::path> ignored,
             const CodecOptions& options)
      : files_(std::move(files)),
        ignored_(std::move(ignored)),
        size_(options.size),
        units_m_(options.units_m),
        rate_hz_(options.rate_hz.value_or(kFileRateHz)) {}

  Result<bool> next(SensorFrame& frame) override {
    if (at_ >= files_.size()) return false;
    const std::filesystem::path& path = files_[at_++];
    frame = {};
    frame.name = path.filename().string();
    frame.number = number_++;
    frame.stamp_ns = stamp_of(frame.number, rate_hz_);
    switch (file_kind(path)) {
      case FileKind::kDepthPng:
        return take(read_depth_png(path), frame.depth, path);
      case FileKind::kDepthRaw:
        if (!size_)
          return Error{
              Status::kUsage,
              path.string() + ": raw depth has no header; give its size, e.g. --size 640x480"};
        return take(read_depth_raw(path, size_->width, size_->height), frame.depth, path);
      default:
        return take_cloud(frame, path);
    }
  }
  void rewind() override { at_ = 0; }
  std::optional<std::uint64_t> count() const override { return files_.size(); }
  SourceSensor sensor() const override { return {std::nullopt, std::nullopt, rate_hz_}; }

  std::vector<std::string> notes() const override {
    if (ignored_.empty()) return {};
    const std::string first = ignored_.front().string();
    if (ignored_.size() == 1) return {first + " is no frame and was left out"};
    return {fmt::format("{} files that are no frames were left out, {} among them", ignored_.size(),
                        first)};
  }

 private:
  Result<bool> take_cloud(SensorFrame& frame, const std::filesystem::path& path) {
    const auto taken = take(read_point_file(path), frame.cloud, path);
    if (!taken.ok()) return taken;
    frame.pose = frame.cloud.viewpoint;
    if (!units_m_ || *units_m_ == 1) return taken;
    const double unit = *units_m_;
    frame.cloud.origin_x *= unit;
    frame.cloud.origin_y *= unit;
    frame.cloud.origin_z *= unit;
    for (Point3f& p : frame.cloud.points)
      p = {static_cast<float>(p.x * unit), static_cast<float>(p.y * unit),
           static_cast<float>(p.z * unit)};
    return taken;
  }

  template <class T>
  Result<bool> take(Result<T> read, T& into, const std::filesystem::path& path) {
    if (!read.ok()) return read.error();
    const std::uint32_t width = read->width, height = read->height;
    if (height == 1) {  // a list: of as many points as it has
      into = std::move(*read);
      return true;
    }
    if (width_ != 0 && (width != width_ || height != height_)) {
      return Error{Status::kUnreadable,
                   fmt::format("{}: is {}x{}, but the frames before it are {}x{}; encode one size "
                               "at a time",
                               path.string(), width, height, width_, height_)};
    }
    into = std::move(*read);
    width_ = width;
    height_ = height;
    return true;
  }

  std::vector<std::filesystem::path> files_;
  std::vector<std::filesystem::path> ignored_;
  std::optional<ImageSize> size_;
  std::optional<double> units_m_;
  double rate_hz_;
  std::size_t at_ = 0;
  std::uint64_t number_ = 0;
  std::uint32_t width_ = 0, height_ = 0;
};

class SimSource : public FrameSource {
 public:
  SimSource(std::string name, RoomSimulator simulator, std::uint64_t frames)
      : name_(std::move(name)), simulator_(std::move(simulator)), frames_(frames) {}

  Result<bool> next(SensorFrame& frame) override {
    if (at_ >= frames_) return false;
    frame = {};
    frame.number = number_++;
    frame.stamp_ns = stamp_of(frame.number, simulator_.config().rate_hz);
    frame.name = "sim:" + name_ + "#" + std::to_string(at_);
    frame.frame_id = "camera_optical";
    simulator_.render(at_++, frame.depth, truth_, frame.pose);
    return true;
  }
  void rewind() override { at_ = 0; }
  std::optional<std::uint64_t> count() const override { return frames_; }
  SourceSensor sensor() const override {
    return {simulator_.config().intrinsics, simulator_.config().noise, simulator_.config().rate_hz};
  }

 private:
  std::string name_;
  RoomSimulator simulator_;
  std::uint64_t frames_;
  std::uint64_t at_ = 0;
  std::uint64_t number_ = 0;
  std::vector<std::uint16_t> truth_;
};

class ScanSource : public FrameSource {
 public:
  ScanSource(ScanSimulator simulator, std::uint64_t frames)
      : simulator_(std::move(simulator)), frames_(frames) {}

  Result<bool> next(SensorFrame& frame) override {
    if (at_ >= frames_) return false;
    frame = {};
    frame.number = number_++;
    frame.stamp_ns = stamp_of(frame.number, simulator_.config().rate_hz);
    frame.name = "sim:scan#" + std::to_string(at_);
    frame.frame_id = "scanner";
    simulator_.render(at_++, frame.cloud, frame.pose);
    return true;
  }
  void rewind() override { at_ = 0; }
  std::optional<std::uint64_t> count() const override { return frames_; }
  SourceSensor sensor() const override {
    return {std::nullopt, simulator_.config().noise, simulator_.config().rate_hz};
  }

 private:
  ScanSimulator simulator_;
  std::uint64_t frames_;
  std::uint64_t at_ = 0;
  std::uint64_t number_ = 0;
};

ScanConfig scan_config_of(const CodecOptions& options) {
  ScanConfig config;
  if (options.size) {
    config.turns = options.size->width;
    config.beams = options.size->height;
  }
  if (options.noise) config.noise = *options.noise;
  config.seed = options.seed;
  if (options.rate_hz) config.rate_hz = *options.rate_hz;
  return config;
}

// The simulated sensor: a preset or figures, a size of its own, the noise named.
SimConfig sim_config_of(const CodecOptions& options) {
  SimConfig config = default_sim_config();
  const SensorPreset* preset = options.camera && !options.camera->preset.empty()
                                   ? find_preset(options.camera->preset)
                                   : nullptr;
  if (preset != nullptr) config = sim_config(*preset);
  if (options.size) {
    const double x = static_cast<double>(options.size->width) / config.width;
    const double y = static_cast<double>(options.size->height) / config.height;
    config.width = options.size->width;
    config.height = options.size->height;
    config.intrinsics.fx *= x;
    config.intrinsics.cx = (config.intrinsics.cx + 0.5) * x - 0.5;
    config.intrinsics.fy *= y;
    config.intrinsics.cy = (config.intrinsics.cy + 0.5) * y - 0.5;
  }
  if (preset == nullptr && options.camera) config.intrinsics = *intrinsics_of(options);
  if (options.noise) config.noise = *options.noise;
  config.seed = options.seed;
  if (options.rate_hz) config.rate_hz = *options.rate_hz;
  return config;
}

Result<std::unique_ptr<FrameSource>> open_simulator(const std::string& input,
                                                    const CodecOptions& options) {
  std::string scene = input.substr(4);
  std::uint64_t frames = kSimFrames;
  if (const auto colon = scene.find(':'); colon != std::string::npos) {
    const auto count = parse_whole(scene.substr(colon + 1), 1, 1'000'000, "sim:room:30");
    if (!count.ok()) return Error{Status::kUsage, input + ": " + count.error().message};
    frames = *count;
    scene.resize(colon);
  }
  if (scene == "scan") {
    auto simulator = ScanSimulator::create(scan_config_of(options));
    if (!simulator.ok()) return simulator.error();
    return std::unique_ptr<FrameSource>(
        std::make_unique<ScanSource>(std::move(*simulator), frames));
  }
  if (scene != "room" && scene != "curved") {
    return Error{Status::kUsage,
                 input +
                     ": no such scene in this version; there are sim:room, sim:curved and "
                     "sim:scan"};
  }
  auto simulator = RoomSimulator::create(sim_config_of(options),
                                         scene == "room" ? room_scene() : curved_scene());
  if (!simulator.ok()) return simulator.error();
  return std::unique_ptr<FrameSource>(
      std::make_unique<SimSource>(std::move(scene), std::move(*simulator), frames));
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_source(const std::vector<std::string>& inputs,
                                                 const CodecOptions& options) {
  if (inputs.empty()) {
    return Error{Status::kUsage, "no input given; name a file, a folder or sim:room"};
  }
  for (const std::string& input : inputs) {
    if (input.starts_with("lcm:")) {
      return Error{Status::kUsage, input +
                                       ": is a live input, which planecastd reads; name a file, "
                                       "a folder or sim:room"};
    }
    if (input.starts_with("sim:") && inputs.size() > 1)
      return Error{Status::kUsage, "the simulator is an input of its own; give it alone"};
  }
  if (inputs.front().starts_with("sim:")) return open_simulator(inputs.front(), options);
  std::vector<std::filesystem::path> ignored;
  auto files = expand_inputs(inputs, &ignored);
  if (!files.ok()) return files.error();
  return std::unique_ptr<FrameSource>(
      std::make_unique<FileSource>(std::move(*files), std::move(ignored), options));
}

}  // namespace planecast
