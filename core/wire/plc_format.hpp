// The .plc file as bytes (docs/wire-format.md, "File"): packets as on the wire, each with its
// length, and a frame index for random access. A file that was cut, e.g. by a full disk, reads up
// to its last whole record. No file access here; cold path.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "core/base/status.hpp"
#include "core/wire/packet_header.hpp"

namespace planecast {

inline constexpr std::uint8_t kPlcMajor = 0;
inline constexpr std::uint8_t kPlcMinor = 1;
inline constexpr std::size_t kPlcHeaderBytes = 8;
/// Longest packet of a file: a slice of the file form of the largest image.
inline constexpr std::size_t kMaxPlcPacketBytes = std::size_t{1} << 28U;

/// Appends packets to a caller's byte vector, which must outlive it. One thread.
class PlcWriter {
 public:
  /// Clears `bytes` and writes the file's header.
  explicit PlcWriter(std::vector<std::uint8_t>& bytes);

  /// Appends a sealed key packet or slice, unchanged. A key packet precedes the slices that need
  /// it; slices of one frame follow each other. Those of open_packet for bytes that are no packet;
  /// kTooLarge past kMaxPlcPacketBytes; kBadConfig after finish() or for slices before any key
  /// packet of their hash. Nothing is written on failure.
  Status add_packet(std::span<const std::uint8_t> packet);

  /// Writes the frame index and the trailer; the file is complete. Later calls do nothing.
  void finish();

 private:
  struct IndexEntry {
    std::uint64_t offset = 0;      ///< of the frame's first slice record
    std::uint64_t key_offset = 0;  ///< of the record of the key packet it needs
  };
  struct Key {
    std::uint8_t stream = 0;
    std::uint32_t hash = 0;
    std::uint64_t offset = 0;
  };

  std::vector<std::uint8_t>& bytes_;
  std::vector<IndexEntry> index_;
  std::vector<Key> keys_;
  std::optional<PacketHeader> open_frame_;  ///< what the slices coming in share
  bool finished_ = false;
};

/// One frame of a file. Spans point into the bytes given to read_plc().
struct PlcFrame {
  std::uint8_t stream = 0;
  std::uint32_t frame = 0;  ///< as on the wire, modulo 2^24
  std::uint64_t stamp_offset = 0;
  std::uint16_t slice_count = 0;      ///< slices the frame had; fewer are here when some were lost
  std::span<const std::uint8_t> key;  ///< the key packet its slices name
  std::vector<std::span<const std::uint8_t>> slices;
};

/// What a file holds.
struct PlcContents {
  std::vector<PlcFrame> frames;
  std::vector<std::span<const std::uint8_t>> keys;  ///< all key packets, repeats included
  std::size_t cut_bytes = 0;        ///< bytes at the end that belong to no whole record
  std::size_t damaged_packets = 0;  ///< whole records whose packet fails its check; left out
  std::size_t orphan_slices = 0;    ///< slices whose key packet is not in the file; left out
  bool complete = false;            ///< the trailer is there: nothing is missing at the end
};

/// Reads a file by its records (the index is checked, not needed). O(bytes): every check sum is
/// computed. Errors: kTruncated: shorter than a header; kBadMagic; kUnsupportedVersion;
/// kReservedBits; kFieldRange: a record longer than kMaxPlcPacketBytes or shorter than a packet
/// header; kTrailingBytes: bytes behind the trailer; kBadCheck: a trailer or index that disagrees
/// with the records. Each message states the byte.
Result<PlcContents> read_plc(std::span<const std::uint8_t> bytes);

/// Where one frame of a complete file lies, from the index alone.
struct PlcPlace {
  std::uint64_t offset = 0;      ///< of the frame's first slice record
  std::uint64_t key_offset = 0;  ///< of the record of its key packet
};

/// The index of a complete file, for random access: O(frames), no check sums of packets. The same
/// errors, and kTruncated where the file has no trailer (read_plc() still reads it).
Result<std::vector<PlcPlace>> read_plc_index(std::span<const std::uint8_t> bytes);

}  // namespace planecast
