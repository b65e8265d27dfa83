// One connection to LCM: the only place that calls liblcm. Opening checks what liblcm does not
// (the route, the receive buffer, the file descriptor) and turns its silence into errors.
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "core/base/status.hpp"
#include "transport/lcm_url.hpp"

namespace planecast {

/// How long a receiving thread waits for a message before it looks whether it shall stop [ms], and
/// how long it rests after an error of the network.
inline constexpr std::int64_t kIdleWaitMs = 50;
inline constexpr std::chrono::milliseconds kErrorPause{10};

/// Longest channel name liblcm carries.
inline constexpr std::size_t kMaxChannelBytes = 63;

/// Channel of the messages that only prepare or examine. One name for all: every new name on the
/// network costs each liblcm that hears it an allocation.
inline constexpr const char* kWarmUpChannel = "PLANECAST_WARMUP";

/// Largest message that travels as one datagram on a channel of this name; a larger one is
/// fragmented by liblcm and lost whole with any fragment.
constexpr std::size_t max_datagram_message_bytes(std::string_view channel) noexcept {
  return 65'499 - channel.size() - 1;
}

/// kUsage unless `channel` is 1 to 63 printable characters without blanks.
Result<Done> check_channel(std::string_view channel);

class LcmLink {
 public:
  /// Called on the thread that calls handle(). `message` is valid during the call only; a message
  /// whose size liblcm reports wrongly arrives empty.
  using Handler = void (*)(void* user, std::span<const std::uint8_t> message) noexcept;

  /// Opens `url` and sends one greeting on kWarmUpChannel, so that no later publish() allocates.
  /// Over memq:// sender and receiver must share one link. kNetwork.
  static Result<std::shared_ptr<LcmLink>> open(const LcmUrl& url, bool for_receiving);

  ~LcmLink();
  LcmLink(const LcmLink&) = delete;
  LcmLink& operator=(const LcmLink&) = delete;

  const LcmUrl& url() const noexcept;

  /// Sends one message; any thread; may block in the kernel; allocates nothing over udpm.
  /// kNetwork when the kernel refuses it.
  Status publish(const char* channel, std::span<const std::uint8_t> message) noexcept;

  /// Subscribes to exactly `channel`; before the handling thread starts. liblcm keeps at most
  /// `queue` unhandled messages and drops the newest after that. kUsage, kNetwork, and kBadConfig
  /// when another receiver handles this link already.
  Result<Done> subscribe(std::string_view channel, Handler handler, void* user, int queue);

  /// Makes liblcm reach the memory it needs for `queue` unhandled messages of `message_bytes`
  /// before the real traffic starts, and proves that messages sent to the group come back: a burst
  /// of about that many bytes on kWarmUpChannel and a greeting on `channel`, all with ttl 0.
  /// Before the handling thread starts. kNetwork when nothing comes back within two seconds.
  Result<Done> warm_up(std::string_view channel, int queue, std::size_t message_bytes);

  /// Waits for one message and calls its handler: 1 handled, 0 none came, -1 failed.
  int handle(int timeout_ms) noexcept;

 private:
  struct Impl;
  explicit LcmLink(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace planecast
