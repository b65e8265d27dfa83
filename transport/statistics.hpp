// What the receiving side counted, as plain structs that add up: every packet that arrived is in
// exactly one of these counters.
#pragma once

#include <array>
#include <cstdint>
#include <string>
#include <vector>

#include "core/base/status.hpp"
#include "transport/transit_histogram.hpp"

namespace planecast {

/// Most streams one receiver keeps apart.
inline constexpr std::uint16_t kMaxStreams = 16;

/// One stream's counts.
/// slices_received = slices_delivered + slices_duplicate + slices_late + slices_old_session
///   + slices_inconsistent + slices_too_large + slices_no_slot + slices_discarded + in assembly.
/// frames_complete + frames_partial = taken + frames_skipped + waiting for the consumer.
struct StreamStatistics {
  std::uint16_t stream = 0;
  std::uint32_t session = 0;

  std::uint64_t slices_received = 0;
  std::uint64_t slices_delivered = 0;     ///< handed on within a frame
  std::uint64_t slices_duplicate = 0;     ///< already there
  std::uint64_t slices_late = 0;          ///< their frame was handed on, or passed over, before
  std::uint64_t slices_old_session = 0;   ///< of a sender that another has replaced
  std::uint64_t slices_inconsistent = 0;  ///< slice number or count disagrees with the frame's
  std::uint64_t slices_too_large = 0;     ///< the frame exceeds the configured slices or bytes
  std::uint64_t slices_no_slot = 0;       ///< the consumer held too many frames
  std::uint64_t slices_discarded = 0;     ///< their frame was dropped when the session changed
  std::uint64_t slices_lost = 0;          ///< missing in the frames handed on (late ones included)
  std::uint64_t slices_reordered = 0;     ///< arrived after a later one; counted above as well

  std::uint64_t keys_received = 0;  ///< key packets, every one
  std::uint64_t keys_ignored = 0;  ///< of them: duplicate, outdated, too large or of an old session
  std::uint64_t unknown_keys = 0;  ///< slices whose key packet the consumer did not have

  std::uint64_t frames_complete = 0;   ///< handed on with every slice
  std::uint64_t frames_partial = 0;    ///< handed on with slices missing
  std::uint64_t frames_lost = 0;       ///< passed over: not one slice arrived
  std::uint64_t frames_discarded = 0;  ///< in assembly when the session changed
  std::uint64_t frames_skipped = 0;    ///< handed on and overwritten before the consumer took them
  std::uint64_t frames_taken = 0;      ///< taken by the consumer
  std::uint64_t session_changes = 0;
  std::uint64_t resyncs = 0;  ///< jumps of the frame number too large to be loss

  double jitter_ns = 0;       ///< interarrival jitter of RFC 3550, first slice of a frame
  TransitHistogram assembly;  ///< first slice to handing on
  TransitHistogram capture;   ///< stamp to handing on; only with a shared clock
};

/// What was counted before a packet reached its stream.
struct LinkStatistics {
  std::uint64_t messages = 0;    ///< LCM messages on the channel, greetings included
  std::uint64_t bytes = 0;       ///< their LCM payload
  std::uint64_t greetings = 0;   ///< envelopes without a packet, sent by receivers that start
  std::uint64_t bad_length = 0;  ///< the sizes of message and envelope disagree
  std::uint64_t bad_type = 0;    ///< another LCM type, or not one of our packets
  std::uint64_t bad_version = 0;
  std::uint64_t bad_check = 0;
  std::uint64_t bad_packet = 0;      ///< malformed in another way
  std::uint64_t unknown_stream = 0;  ///< more streams than configured
  std::uint64_t receive_errors = 0;  ///< liblcm failed to receive

  /// Counts a packet that the envelope or the parser refused under its cause.
  void count_refused(Status status) noexcept;
};

/// Everything one receiver counted.
struct ReceiverStatistics {
  LinkStatistics link;
  std::uint16_t stream_count = 0;
  std::array<StreamStatistics, kMaxStreams> streams{};  ///< the first stream_count are in use
};

/// "name value" lines for people, zero counts of failures left out. Cold path.
std::vector<std::string> to_lines(const ReceiverStatistics& statistics);

}  // namespace planecast
