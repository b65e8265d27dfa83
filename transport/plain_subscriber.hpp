// Receives whole messages of one channel on its own thread and hands their bytes on, for sources
// that are not ours (`lcm:CHANNEL`). Messages over 65 kB are fragmented by liblcm and arrive whole
// or not at all.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <string>

#include "core/base/status.hpp"
#include "transport/lcm_link.hpp"

namespace planecast {

struct PlainStatistics {
  std::uint64_t messages = 0;
  std::uint64_t bytes = 0;
  std::uint64_t bad_length = 0;  ///< empty, or of a size liblcm reports wrongly; not handed on
  std::uint64_t receive_errors = 0;
};

class PlainSubscriber {
 public:
  /// Called on the receiving thread; `message` is valid during the call; `arrived_ns` is the
  /// monotonic clock. While it runs liblcm queues up to `queue` messages and then drops the newest.
  using Callback =
      std::function<void(std::span<const std::uint8_t> message, std::int64_t arrived_ns)>;

  /// Starts the receiving thread. kUsage, kNetwork, kBadConfig (the link has a receiver already).
  static Result<std::unique_ptr<PlainSubscriber>> create(const std::string& channel,
                                                         std::shared_ptr<LcmLink> link,
                                                         Callback callback, int queue = 8);
  ~PlainSubscriber();

  /// Any thread.
  PlainStatistics statistics() const noexcept;

  /// Ends the receiving thread within 60 ms, after a callback that is running.
  void stop() noexcept;

 private:
  struct Impl;
  explicit PlainSubscriber(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace planecast
