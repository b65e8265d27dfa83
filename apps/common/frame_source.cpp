#include "apps/common/frame_source.hpp"

#include "core/io/depth_png.hpp"
#include "core/io/depth_raw.hpp"
#include "core/io/file_kind.hpp"
#include "core/io/file_list.hpp"
#include "core/io/point_file.hpp"
#include "core/sim/sim_room.hpp"

namespace planecast {
namespace {

class FileSource : public FrameSource {
 public:
  FileSource(std::vector<std::filesystem::path> files, std::optional<ImageSize> size)
      : files_(std::move(files)), size_(size) {}

  Result<bool> next(SensorFrame& frame) override {
    if (at_ >= files_.size()) return false;
    const std::filesystem::path& path = files_[at_];
    frame = {};
    frame.name = path.filename().string();
    frame.number = at_++;
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
        return take(read_point_file(path), frame.cloud, path);
    }
  }
  void rewind() override { at_ = 0; }
  std::optional<std::uint64_t> count() const override { return files_.size(); }

 private:
  template <class T>
  Result<bool> take(Result<T> read, T& into, const std::filesystem::path& path) {
    if (!read.ok()) return read.error();
    into = std::move(*read);
    const std::uint32_t width = into.width, height = into.height;
    if (width_ != 0 && (width != width_ || height != height_)) {
      return Error{Status::kUnreadable,
                   path.string() + ": is " + std::to_string(width) + "x" + std::to_string(height) +
                       ", but the frames before it are " + std::to_string(width_) + "x" +
                       std::to_string(height_) + "; encode one size at a time"};
    }
    width_ = width;
    height_ = height;
    return true;
  }

  std::vector<std::filesystem::path> files_;
  std::optional<ImageSize> size_;
  std::size_t at_ = 0;
  std::uint32_t width_ = 0, height_ = 0;
};

class SimSource : public FrameSource {
 public:
  SimSource(RoomSimulator simulator, std::uint64_t frames)
      : simulator_(std::move(simulator)), frames_(frames) {}

  Result<bool> next(SensorFrame& frame) override {
    if (at_ >= frames_) return false;
    frame = {};
    frame.number = at_;
    frame.name = "sim:room#" + std::to_string(at_);
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
  RoomSimulator simulator_;
  std::uint64_t frames_;
  std::uint64_t at_ = 0;
  std::vector<std::uint16_t> truth_;
};

constexpr std::uint64_t kSimFrames = 90;  // three seconds

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
  if (scene != "room") {
    return Error{Status::kUsage, input + ": no such scene; did you mean sim:room?"};
  }
  SimConfig config = default_sim_config();
  if (options.camera && !options.camera->preset.empty()) {
    if (const SensorPreset* preset = find_preset(options.camera->preset))
      config = sim_config(*preset);
  }
  config.seed = options.seed;
  if (options.rate_hz) config.rate_hz = *options.rate_hz;
  auto simulator = RoomSimulator::create(config);
  if (!simulator.ok()) return simulator.error();
  return std::unique_ptr<FrameSource>(std::make_unique<SimSource>(std::move(*simulator), frames));
}

}  // namespace

Result<std::unique_ptr<FrameSource>> open_source(const std::vector<std::string>& inputs,
                                                 const CodecOptions& options) {
  if (inputs.empty()) {
    return Error{Status::kUsage, "no input given; name a file, a folder or sim:room"};
  }
  if (inputs.front().starts_with("sim:")) {
    if (inputs.size() > 1)
      return Error{Status::kUsage, "the simulator is an input of its own; give it alone"};
    return open_simulator(inputs.front(), options);
  }
  auto files = expand_inputs(inputs);
  if (!files.ok()) return files.error();
  return std::unique_ptr<FrameSource>(
      std::make_unique<FileSource>(std::move(*files), options.size));
}

}  // namespace planecast
