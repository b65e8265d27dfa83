#include "apps/recv/sink_writer.hpp"

#include <filesystem>

#include "apps/recv/frame_file.hpp"

namespace planecast {

void SinkWriter::run() {
  while (const SinkFrame* frame = queue_.take()) {
    if (!options_.out_folder.empty()) write(*frame);
    if (options_.publish_name) publish(*frame);
    if (!frame->complete) {
      queue_.release(frame);
      continue;
    }
    if (last_ != nullptr) queue_.release(last_);
    last_ = frame;
  }
}

void SinkWriter::write(const SinkFrame& frame) {
  const std::filesystem::path path =
      std::filesystem::path(options_.out_folder) / frame_file_name(frame, options_.format);
  const auto done = write_frame(frame, options_.format, path);
  if (done.ok()) {
    ++written_;
    return;
  }
  ++failures_;
  if (!write_failed_) fail(done.error().message);
  write_failed_ = true;
}

void SinkWriter::publish(const SinkFrame& frame) {
  if (!publishers_.contains(frame.stream)) {
    if (const auto opened = open_publisher(frame); !opened.ok()) {
      ++failures_;
      if (!publish_failed_) fail("--publish-plain: " + opened.error().message);
      publish_failed_ = true;
      return;
    }
  }
  static_assert(sizeof(Point3f) == 3 * sizeof(float));
  const auto* xyz = reinterpret_cast<const float*>(frame.cloud.data());
  const Status status = publishers_[frame.stream]->publish(frame.stamp_ns / 1000,
                                                           {xyz, std::size_t{frame.pixels} * 3});
  if (status == Status::kOk) {
    ++published_;
    return;
  }
  ++failures_;
  if (!publish_failed_) {
    fail("--publish-plain: a cloud could not be sent (" + std::string(to_string(status)) +
         "); 'planecast doctor' checks the network");
  }
  publish_failed_ = true;
}

// A publisher a stream, made when its first frame tells its size and coordinate frame.
Result<Done> SinkWriter::open_publisher(const SinkFrame& frame) {
  std::string channel = std::string(kDrakeChannelPrefix) +
                        (options_.publish_name->empty() ? "camera" : *options_.publish_name);
  if (frame.stream != 0) channel += "_" + std::to_string(frame.stream);
  const std::size_t most = options_.full_cloud ? frame.cloud.size() : kDrakeDatagramPoints;
  auto publisher = DrakePublisher::create(channel, frame.config.frame_id.data(), most, link_);
  if (!publisher.ok()) return publisher.error();
  publishers_[frame.stream] = std::move(*publisher);
  return Done{};
}

void SinkWriter::fail(const std::string& message) {
  const std::lock_guard lock(complaints_mutex_);
  complaints_.push_back(message);
}

std::vector<std::string> SinkWriter::take_complaints() {
  const std::lock_guard lock(complaints_mutex_);
  return std::exchange(complaints_, {});
}

}  // namespace planecast
