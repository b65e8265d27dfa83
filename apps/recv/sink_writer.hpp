// The sink thread: writes frames to files, publishes them as plain clouds, and keeps the last
// complete one for the end. It may wait for the disk and the network; the receiving thread does
// not wait for it.
#pragma once

#include <atomic>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <string>
#include <vector>

#include "apps/recv/recv_options.hpp"
#include "apps/recv/sink_queue.hpp"
#include "core/base/status.hpp"
#include "transport/drake_point_cloud.hpp"

namespace planecast {

class SinkWriter {
 public:
  /// All must outlive the writer; `link` publishes plain clouds.
  SinkWriter(const RecvOptions& options, SinkQueue& queue, std::shared_ptr<LcmLink> link)
      : options_(options), queue_(queue), link_(std::move(link)) {}

  /// The sink thread: returns once the queue is closed and empty.
  void run();

  /// Any thread.
  std::uint64_t files_written() const noexcept { return written_.load(); }
  std::uint64_t clouds_published() const noexcept { return published_.load(); }
  std::uint64_t failures() const noexcept { return failures_.load(); }

  /// What went wrong since the last call, each cause once. Any thread.
  std::vector<std::string> take_complaints();

  /// After run(): the last complete frame, null when there was none.
  const SinkFrame* last_complete() const noexcept { return last_; }

 private:
  void write(const SinkFrame& frame);
  void publish(const SinkFrame& frame);
  Result<Done> open_publisher(const SinkFrame& frame);
  void fail(const std::string& message);

  const RecvOptions& options_;
  SinkQueue& queue_;
  std::shared_ptr<LcmLink> link_;
  std::map<std::uint16_t, std::unique_ptr<DrakePublisher>> publishers_;
  const SinkFrame* last_ = nullptr;
  bool write_failed_ = false, publish_failed_ = false;
  std::atomic<std::uint64_t> written_{0}, published_{0}, failures_{0};
  std::mutex complaints_mutex_;
  std::vector<std::string> complaints_;
};

}  // namespace planecast
