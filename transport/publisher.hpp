// Sends whole frames over LCM from its own thread. The pipeline never waits for the network: it
// fills one of a fixed number of frame buffers, and when all are full the oldest frame not yet
// begun is dropped whole and counted.
#pragma once

#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "transport/envelope.hpp"
#include "transport/lcm_link.hpp"

namespace planecast {

struct PublisherConfig {
  std::string channel = "PLANECAST";
  std::uint32_t frames = 4;                            ///< frame buffers, 3 .. 64
  std::uint32_t max_packets = 2048;                    ///< packets a frame, key packet included
  std::uint32_t max_frame_bytes = 2U << 20U;           ///< envelopes included
  std::uint32_t message_bytes = kDefaultMessageBytes;  ///< largest LCM payload, envelope included
  std::uint32_t burst_packets = 8;                     ///< sent back to back before pausing
  std::uint32_t pace_above_packets = 48;               ///< smaller frames go out without a pause
  std::uint32_t pace_ns = 60'000;  ///< mean time a packet of a paced frame; 0: never pause
  void (*on_thread_start)(const char* name) = nullptr;  ///< called first on the sending thread
};

struct PublisherStatistics {
  std::uint64_t frames_published = 0;        ///< handed over; = sent + failed + dropped_* + queued
  std::uint64_t frames_sent = 0;             ///< every packet accepted by the kernel
  std::uint64_t frames_failed = 0;           ///< at least one packet refused, or cut off by stop()
  std::uint64_t frames_dropped_oldest = 0;   ///< overwritten before they were begun
  std::uint64_t frames_dropped_at_stop = 0;  ///< still queued when stop() was called
  std::uint64_t frames_abandoned = 0;        ///< claimed, then given back; not in frames_published
  std::uint64_t frames_queued = 0;           ///< waiting or being sent now
  std::uint64_t packets = 0;                 ///< accepted by the kernel
  std::uint64_t bytes = 0;                   ///< LCM payload of these packets
  std::uint64_t publish_errors = 0;          ///< packets refused by the kernel
};

/// One frame on its way out: packets in the order they are to be sent, the key packet first.
/// Used by the thread that claimed it, until it is published or abandoned. Allocates nothing.
class FrameBuffer {
 public:
  /// Where the next packet may be written in place; empty when the frame is full.
  std::span<std::uint8_t> space() noexcept;

  /// Ends the packet written at the start of space(). kWrongSize: empty or longer than space().
  Status commit(std::size_t packet_bytes, bool key = false) noexcept;

  /// Copies a packet. kWrongSize: empty or over the packet limit; kTooLarge: the frame is full.
  Status append(std::span<const std::uint8_t> packet, bool key = false) noexcept;

  /// True when a frame that held a key packet was dropped unsent: put a key packet into this one.
  bool key_wanted() const noexcept { return key_wanted_; }

  std::uint32_t packets() const noexcept { return packets_; }
  std::uint32_t bytes() const noexcept { return used_; }  ///< LCM payload, envelopes included

 private:
  friend class Publisher;
  struct Packet {
    std::uint32_t offset;
    std::uint32_t bytes;
  };
  std::uint8_t* memory_ = nullptr;
  Packet* table_ = nullptr;
  std::uint32_t capacity_ = 0, max_packets_ = 0, max_packet_bytes_ = 0;
  std::uint32_t used_ = 0, packets_ = 0;
  bool holds_key_ = false, key_wanted_ = false;
};

class Publisher {
 public:
  /// Bytes of frame memory a publisher of this configuration holds; all taken at creation.
  static std::size_t memory_bytes(const PublisherConfig& config) noexcept;

  /// Starts the sending thread. The frame memory is taken from `arena`, which must outlive the
  /// publisher, or without one mapped by itself. kBadConfig, kUsage, kOutOfArena.
  static Result<std::unique_ptr<Publisher>> create(const PublisherConfig& config,
                                                   std::shared_ptr<LcmLink> link,
                                                   Arena* arena = nullptr);
  ~Publisher();

  /// A buffer for the next frame; one pipeline thread, one buffer at a time. Never waits, never
  /// allocates; drops the oldest frame not yet begun when all buffers are in use. Null only when
  /// the previous claim was neither published nor abandoned, or after stop().
  FrameBuffer* claim() noexcept;

  /// Hands a claimed frame to the sending thread. kWrongSize: no packet in it (it is abandoned).
  Status publish(FrameBuffer* frame) noexcept;

  /// Gives a claimed frame back unsent, for example when the codec failed.
  void abandon(FrameBuffer* frame) noexcept;

  /// Waits until everything published is sent or dropped; false when `timeout_ns` passed first.
  bool flush(std::int64_t timeout_ns) const noexcept;

  /// Ends the sending thread after the packet in hand; drops and counts what is queued.
  void stop() noexcept;

  /// Any thread.
  PublisherStatistics statistics() const noexcept;

 private:
  struct Impl;
  explicit Publisher(std::unique_ptr<Impl> impl);
  std::unique_ptr<Impl> impl_;
};

}  // namespace planecast
