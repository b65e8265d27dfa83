#include "core/wire/plc_format.hpp"

#include <algorithm>
#include <string>
#include <utility>

#include "core/base/bytes.hpp"
#include "core/base/crc32c.hpp"
#include "core/wire/packet_header.hpp"

namespace planecast {
namespace {

// "PLC0", major, minor, two reserved bytes.
constexpr std::uint8_t kMagic[4] = {'P', 'L', 'C', '0'};
// A record length of zero opens the index: entries of two u64, then the trailer.
constexpr std::uint32_t kIndexMark = 0;
constexpr std::size_t kEntryBytes = 16;
// Index offset u64, entry count u32, CRC-32C over index and the trailer's front, "PLCE".
constexpr std::size_t kTrailerBytes = 20;
constexpr std::uint8_t kTrailerMagic[4] = {'P', 'L', 'C', 'E'};

template <class T>
void append_le(std::vector<std::uint8_t>& bytes, T value) {
  const std::size_t at = bytes.size();
  bytes.resize(at + sizeof(T));
  store_le<T>(bytes.data() + at, value);
}

// What slices of one frame share: the whole header but the slice's own number.
PacketHeader frame_of(PacketHeader header) {
  header.slice = 0;
  return header;
}

Error error_at(Status status, std::size_t byte, const std::string& what) {
  return {status, "byte " + std::to_string(byte) + ": " + what};
}

std::optional<Error> check_file_header(std::span<const std::uint8_t> bytes) {
  const std::size_t magic = std::min<std::size_t>(bytes.size(), 4);
  if (!std::equal(bytes.begin(), bytes.begin() + static_cast<std::ptrdiff_t>(magic), kMagic))
    return error_at(Status::kBadMagic, 0, "not a .plc file; it would begin with 'PLC0'");
  if (bytes.size() < kPlcHeaderBytes)
    return error_at(Status::kTruncated, bytes.size(), "the file ends within its header");
  if (bytes[4] != kPlcMajor) {
    return error_at(Status::kUnsupportedVersion, 4,
                    "file version " + std::to_string(bytes[4]) + "." + std::to_string(bytes[5]) +
                        ", this program reads " + std::to_string(kPlcMajor) +
                        ".x; use the release that wrote it");
  }
  if (bytes[6] != 0 || bytes[7] != 0)
    return error_at(Status::kReservedBits, 6, "reserved bytes of the header are not zero");
  return std::nullopt;
}

// The index at `at` (its mark), which must reach the end of the file exactly. Nothing when the
// file was cut within it.
std::optional<Result<std::vector<PlcPlace>>> read_index(std::span<const std::uint8_t> bytes,
                                                        std::size_t at) {
  const std::size_t front = at + 4;
  if (bytes.size() - at < 8) return std::nullopt;
  const std::size_t count = load_le<std::uint32_t>(bytes.data() + front);
  const std::size_t entries = front + 4;
  // Every entry stands for at least one record of a packet header.
  if (count > at / (4 + kPacketHeaderBytes))
    return error_at(Status::kFieldRange, front, "the index names more frames than the file holds");
  const std::size_t end = entries + count * kEntryBytes + kTrailerBytes;
  if (end > bytes.size()) return std::nullopt;
  if (end < bytes.size())
    return error_at(Status::kTrailingBytes, end, "bytes behind the end of the file; remove them");
  const std::uint8_t* trailer = bytes.data() + end - kTrailerBytes;
  const auto checked = bytes.subspan(at, end - 8 - at);
  if (!std::equal(kTrailerMagic, kTrailerMagic + 4, trailer + 16) ||
      load_le<std::uint32_t>(trailer + 12) != crc32c(checked) ||
      load_le<std::uint64_t>(trailer) != at || load_le<std::uint32_t>(trailer + 8) != count) {
    return error_at(Status::kBadCheck, end - kTrailerBytes, "the trailer does not fit the index");
  }
  std::vector<PlcPlace> places(count);
  for (std::size_t i = 0; i < count; ++i) {
    const std::uint8_t* entry = bytes.data() + entries + i * kEntryBytes;
    places[i] = {load_le<std::uint64_t>(entry), load_le<std::uint64_t>(entry + 8)};
    if (places[i].offset < kPlcHeaderBytes || places[i].offset >= at ||
        places[i].key_offset < kPlcHeaderBytes || places[i].key_offset >= at) {
      return error_at(Status::kFieldRange, entries + i * kEntryBytes, "an index entry points out");
    }
  }
  return Result<std::vector<PlcPlace>>(std::move(places));
}

// Sorts the packets of a file into frames.
class Collector {
 public:
  explicit Collector(PlcContents& contents) : contents_(contents) {}

  void add(std::span<const std::uint8_t> packet, std::size_t offset) {
    PacketHeader header;
    if (open_packet(packet, header) != Status::kOk) {
      ++contents_.damaged_packets;
      return;
    }
    if (header.key) {
      contents_.keys.push_back(packet);
      keys_.push_back({header.stream, header.key_hash, offset});
      return;
    }
    const std::optional<std::size_t> key = key_of(header);
    if (!key) {
      ++contents_.orphan_slices;
      return;
    }
    if (contents_.frames.empty() || last_ != frame_of(header)) {
      contents_.frames.push_back({header.stream,
                                  header.frame,
                                  header.stamp_offset,
                                  header.slice_count,
                                  contents_.keys[*key],
                                  {}});
      places_.push_back({offset, keys_[*key].offset});
      last_ = frame_of(header);
    }
    contents_.frames.back().slices.push_back(packet);
  }

  const std::vector<PlcPlace>& places() const { return places_; }

 private:
  struct Key {
    std::uint8_t stream;
    std::uint32_t hash;
    std::size_t offset;
  };

  std::optional<std::size_t> key_of(const PacketHeader& header) const {
    for (std::size_t i = keys_.size(); i-- > 0;)
      if (keys_[i].stream == header.stream && keys_[i].hash == header.key_hash) return i;
    return std::nullopt;
  }

  PlcContents& contents_;
  std::vector<Key> keys_;
  std::vector<PlcPlace> places_;
  PacketHeader last_;
};

}  // namespace

PlcWriter::PlcWriter(std::vector<std::uint8_t>& bytes) : bytes_(bytes) {
  bytes_.assign(kMagic, kMagic + 4);
  bytes_.insert(bytes_.end(), {kPlcMajor, kPlcMinor, 0, 0});
}

Status PlcWriter::add_packet(std::span<const std::uint8_t> packet) {
  if (finished_) return Status::kBadConfig;
  if (packet.size() > kMaxPlcPacketBytes) return Status::kTooLarge;
  PacketHeader header;
  if (const Status status = open_packet(packet, header); status != Status::kOk) return status;
  const std::uint64_t offset = bytes_.size();
  if (header.key) {
    keys_.push_back({header.stream, header.key_hash, offset});
  } else {
    const auto key = std::find_if(keys_.rbegin(), keys_.rend(), [&](const Key& k) {
      return k.stream == header.stream && k.hash == header.key_hash;
    });
    if (key == keys_.rend()) return Status::kBadConfig;
    if (open_frame_ != frame_of(header)) index_.push_back({offset, key->offset});
    open_frame_ = frame_of(header);
  }
  append_le(bytes_, static_cast<std::uint32_t>(packet.size()));
  bytes_.insert(bytes_.end(), packet.begin(), packet.end());
  return Status::kOk;
}

void PlcWriter::finish() {
  if (finished_) return;
  finished_ = true;
  const std::size_t at = bytes_.size();
  append_le(bytes_, kIndexMark);
  append_le(bytes_, static_cast<std::uint32_t>(index_.size()));
  for (const IndexEntry& entry : index_) {
    append_le(bytes_, entry.offset);
    append_le(bytes_, entry.key_offset);
  }
  append_le(bytes_, std::uint64_t{at});
  append_le(bytes_, static_cast<std::uint32_t>(index_.size()));
  append_le(bytes_, crc32c(std::span<const std::uint8_t>(bytes_).subspan(at)));
  bytes_.insert(bytes_.end(), kTrailerMagic, kTrailerMagic + 4);
}

Result<PlcContents> read_plc(std::span<const std::uint8_t> bytes) {
  if (auto error = check_file_header(bytes)) return *error;
  PlcContents contents;
  Collector collector(contents);
  std::size_t at = kPlcHeaderBytes;
  while (bytes.size() - at >= 4) {
    const std::size_t length = load_le<std::uint32_t>(bytes.data() + at);
    if (length == kIndexMark) {
      const auto index = read_index(bytes, at);
      if (!index) break;
      if (!index->ok()) return index->error();
      const bool whole = contents.damaged_packets == 0;
      const auto& found = collector.places();
      const auto same = [](const PlcPlace& a, const PlcPlace& b) {
        return a.offset == b.offset && a.key_offset == b.key_offset;
      };
      if (whole &&
          !std::equal(found.begin(), found.end(), (*index)->begin(), (*index)->end(), same))
        return error_at(Status::kBadCheck, at, "the index does not fit the records");
      contents.complete = true;
      return contents;
    }
    if (length < kPacketHeaderBytes || length > kMaxPlcPacketBytes) {
      return error_at(Status::kFieldRange, at,
                      "a record of " + std::to_string(length) + " bytes; packets have " +
                          std::to_string(kPacketHeaderBytes) + " to " +
                          std::to_string(kMaxPlcPacketBytes));
    }
    if (length > bytes.size() - at - 4) break;
    collector.add(bytes.subspan(at + 4, length), at);
    at += 4 + length;
  }
  contents.cut_bytes = bytes.size() - at;
  return contents;
}

Result<std::vector<PlcPlace>> read_plc_index(std::span<const std::uint8_t> bytes) {
  if (auto error = check_file_header(bytes)) return *error;
  const auto no_trailer = [&] {
    return error_at(Status::kTruncated, bytes.size(), "the file has no trailer: it was cut");
  };
  if (bytes.size() < kPlcHeaderBytes + 8 + kTrailerBytes) return no_trailer();
  const std::uint8_t* trailer = bytes.data() + bytes.size() - kTrailerBytes;
  if (!std::equal(kTrailerMagic, kTrailerMagic + 4, trailer + 16)) return no_trailer();
  const auto named = load_le<std::uint64_t>(trailer);
  const auto at = static_cast<std::size_t>(named);
  if (named < kPlcHeaderBytes || named > bytes.size() - 8 - kTrailerBytes ||
      load_le<std::uint32_t>(bytes.data() + at) != kIndexMark) {
    return error_at(Status::kBadCheck, bytes.size() - kTrailerBytes, "the trailer points nowhere");
  }
  auto index = read_index(bytes, at);
  if (!index) return no_trailer();
  return *index;
}

}  // namespace planecast
