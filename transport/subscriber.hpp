// Receives packets on its own thread and assembles them into frames. The LCM callback only checks
// sizes and the envelope, asks the caller's parser who the packet is, and copies it into fixed
// memory; decoding is the consumer's, on another thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/base/status.hpp"
#include "transport/assembler.hpp"
#include "transport/envelope.hpp"
#include "transport/lcm_link.hpp"

namespace planecast {

struct SubscriberConfig {
  std::string channel = "PLANECAST";
  ParseFn parse = nullptr;  ///< required
  AssemblerConfig assembly;
  /// Messages liblcm may keep unhandled before it drops the newest. Above 100 liblcm goes on
  /// allocating while the receiving thread is held up.
  std::uint16_t lcm_queue = 100;
  std::uint32_t message_bytes =
      kDefaultMessageBytes;  ///< of the warm-up; larger ones are received too
  void (*on_thread_start)(const char* name) = nullptr;  ///< called first on the receiving thread
};

class Subscriber {
 public:
  /// Bytes of frame memory a subscriber of this configuration holds.
  static std::size_t memory_bytes(const SubscriberConfig& config) noexcept;

  /// Subscribes, warms liblcm up (a burst with ttl 0 to this host, which also proves that the group
  /// can be heard), and starts the receiving thread. Takes tens of milliseconds, up to ten seconds
  /// where multicast is blocked. Memory as Assembler::create. kBadConfig, kUsage, kNetwork,
  /// kOutOfArena.
  static Result<std::unique_ptr<Subscriber>> create(const SubscriberConfig& config,
                                                    std::shared_ptr<LcmLink> link,
                                                    Arena* arena = nullptr);
  ~Subscriber();

  /// Waits for the next frame of any stream; empty after `timeout_ns`, after interrupt() and once
  /// stopped. One consuming thread, for the whole class below as well.
  FrameRef wait(std::int64_t timeout_ns) noexcept { return assembler().wait(timeout_ns); }

  /// The same without waiting, of any stream or of one.
  FrameRef take() noexcept { return assembler().take(); }
  FrameRef take(std::uint16_t stream) noexcept { return assembler().take(stream); }

  /// Counts slices whose key packet the consumer did not have.
  void count_unknown_keys(std::uint16_t stream, std::uint64_t slices) noexcept {
    assembler().count_unknown_keys(stream, slices);
  }

  /// Any thread: ends a wait().
  void interrupt() noexcept { assembler().interrupt(); }

  /// Any thread.
  ReceiverStatistics statistics() const noexcept;

  /// Ends the receiving thread within 60 ms; what was assembled can still be taken.
  void stop() noexcept;

 private:
  struct Impl;
  explicit Subscriber(std::unique_ptr<Impl> impl);
  Assembler& assembler() noexcept;
  std::unique_ptr<Impl> impl_;
};

}  // namespace planecast
