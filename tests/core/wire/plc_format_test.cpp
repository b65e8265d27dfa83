// The .plc file: what is written is read, a cut tail costs only its last record, damage is counted
// or named, and the index fits.
#include "core/wire/plc_format.hpp"

#include <gtest/gtest.h>

#include "core/wire/key_packet.hpp"
#include "core/wire/packet_header.hpp"
#include "tests/core/wire/wire_bench.hpp"

namespace planecast {
namespace {

using test::Bytes;

constexpr std::uint8_t kStream = 4;

Bytes sealed(PacketHeader header, std::size_t body, std::uint8_t fill) {
  Bytes packet(kPacketHeaderBytes + body, fill);
  if (header.key) header.key_hash = key_hash(std::span(packet).subspan(kPacketHeaderBytes));
  seal_packet(header, packet);
  return packet;
}

Bytes key(std::uint8_t fill) {
  PacketHeader header;
  header.key = true;
  header.stream = kStream;
  return sealed(header, 50, fill);
}

std::uint32_t hash_of(const Bytes& packet) {
  PacketHeader header;
  EXPECT_EQ(open_packet(packet, header), Status::kOk);
  return header.key_hash;
}

Bytes slice(std::uint32_t frame, std::uint16_t i, std::uint16_t n, const Bytes& key_packet) {
  return sealed({false, kStream, frame, frame * 10ULL, i, n, hash_of(key_packet)}, 20 + i,
                static_cast<std::uint8_t>(frame));
}

// Two keys, four frames of three slices; offsets of every record.
struct Sample {
  Bytes file;
  std::vector<std::size_t> record_ends;
  Bytes first_key = key(1), second_key = key(2);

  Sample() {
    PlcWriter writer(file);
    const auto add = [&](const Bytes& packet) {
      ASSERT_EQ(writer.add_packet(packet), Status::kOk);
      record_ends.push_back(file.size());
    };
    for (std::uint32_t frame = 0; frame < 4; ++frame) {
      const Bytes& current = frame < 2 ? first_key : second_key;
      if (frame % 2 == 0) add(current);
      for (std::uint16_t i = 0; i < 3; ++i) add(slice(frame, i, 3, current));
    }
    writer.finish();
  }
};

TEST(PlcFormat, WhatIsWrittenIsRead) {
  const Sample s;
  const auto read = read_plc(s.file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_TRUE(read->complete);
  EXPECT_EQ(read->cut_bytes, 0U);
  EXPECT_EQ(read->damaged_packets + read->orphan_slices, 0U);
  EXPECT_EQ(read->keys.size(), 2U);
  ASSERT_EQ(read->frames.size(), 4U);
  for (std::uint32_t f = 0; f < 4; ++f) {
    const PlcFrame& frame = read->frames[f];
    EXPECT_EQ(frame.frame, f);
    EXPECT_EQ(frame.stamp_offset, f * 10);
    EXPECT_EQ(frame.stream, kStream);
    EXPECT_EQ(frame.slice_count, 3);
    ASSERT_EQ(frame.slices.size(), 3U);
    const Bytes& current = f < 2 ? s.first_key : s.second_key;
    EXPECT_TRUE(std::equal(frame.key.begin(), frame.key.end(), current.begin(), current.end()));
    for (std::uint16_t i = 0; i < 3; ++i) {
      const Bytes expected = slice(f, i, 3, current);
      EXPECT_TRUE(std::equal(frame.slices[i].begin(), frame.slices[i].end(), expected.begin(),
                             expected.end()));
    }
  }
}

TEST(PlcFormat, TheIndexNamesEveryFramesFirstRecordAndKey) {
  const Sample s;
  const auto places = read_plc_index(s.file);
  ASSERT_TRUE(places.ok()) << places.error().message;
  ASSERT_EQ(places->size(), 4U);
  for (std::size_t f = 0; f < 4; ++f) {
    const std::uint8_t* record = s.file.data() + (*places)[f].offset;
    const auto length = load_le<std::uint32_t>(record);
    PacketHeader header;
    ASSERT_EQ(open_packet({record + 4, length}, header), Status::kOk);
    EXPECT_EQ(header.frame, f);
    EXPECT_EQ(header.slice, 0);
    const std::uint8_t* key_record = s.file.data() + (*places)[f].key_offset;
    PacketHeader key_header;
    ASSERT_EQ(open_packet({key_record + 4, load_le<std::uint32_t>(key_record)}, key_header),
              Status::kOk);
    EXPECT_TRUE(key_header.key);
    EXPECT_EQ(key_header.key_hash, header.key_hash);
  }
}

TEST(PlcFormat, ATailCutAtAnyByteCostsOnlyItsLastRecord) {
  const Sample s;
  for (std::size_t size = 0; size < s.file.size(); ++size) {
    const auto cut = std::span<const std::uint8_t>(s.file).first(size);
    const auto read = read_plc(cut);
    if (size < kPlcHeaderBytes) {
      ASSERT_FALSE(read.ok());
      EXPECT_EQ(read.error().status, Status::kTruncated);
      continue;
    }
    ASSERT_TRUE(read.ok()) << size << ": " << read.error().message;
    EXPECT_FALSE(read->complete) << size;
    const auto whole = static_cast<std::size_t>(std::count_if(
        s.record_ends.begin(), s.record_ends.end(), [&](std::size_t end) { return end <= size; }));
    std::size_t found = read->keys.size();
    for (const PlcFrame& frame : read->frames) found += frame.slices.size();
    EXPECT_EQ(found, whole) << size;
    EXPECT_EQ(read->cut_bytes, size - (whole == 0 ? kPlcHeaderBytes : s.record_ends[whole - 1]));
    EXPECT_FALSE(read_plc_index(cut).ok());
  }
}

TEST(PlcFormat, ADamagedPacketIsCountedAndTheOthersAreRead) {
  const Sample s;
  std::size_t begin = kPlcHeaderBytes;
  for (std::size_t record = 0; record < s.record_ends.size(); ++record) {
    Bytes spoilt = s.file;
    spoilt[begin + 4 + kPacketHeaderBytes + 3] ^= 0x10;
    const auto read = read_plc(spoilt);
    ASSERT_TRUE(read.ok()) << read.error().message;
    EXPECT_EQ(read->damaged_packets, 1U);
    EXPECT_TRUE(read->complete);
    const bool was_key = record % 7 == 0;
    EXPECT_EQ(read->orphan_slices, was_key ? 6U : 0U);
    std::size_t slices = 0;
    for (const PlcFrame& frame : read->frames) slices += frame.slices.size();
    EXPECT_EQ(slices, was_key ? 6U : 11U);
    begin = s.record_ends[record];
  }
}

TEST(PlcFormat, EveryChangedByteIsNamedOrCountedOrHarmless) {
  const Sample s;
  for (std::size_t i = 0; i < s.file.size(); ++i) {
    for (const int flip : {0x01, 0x80, 0xff}) {
      Bytes spoilt = s.file;
      spoilt[i] ^= static_cast<std::uint8_t>(flip);
      const auto read = read_plc(spoilt);
      if (!read.ok()) {
        EXPECT_TRUE(test::is_wire_status(read.error().status));
        EXPECT_NE(read.error().message.find("byte "), std::string::npos);
        continue;
      }
      const bool noticed = read->damaged_packets + read->orphan_slices + read->cut_bytes > 0;
      // The minor version of the file says nothing to this reader.
      EXPECT_TRUE(noticed || i == 5) << i;
      (void)read_plc_index(spoilt);
    }
  }
}

struct Fault {
  const char* name;
  std::size_t at;
  std::uint8_t value;
  Status status;
};

TEST(PlcFormat, HeaderAndIndexFaultsHaveTheirNames) {
  const Sample s;
  const std::size_t index = s.record_ends.back();
  const std::size_t end = s.file.size();
  const Fault faults[] = {
      {"magic", 0, 'X', Status::kBadMagic},
      {"major", 4, 9, Status::kUnsupportedVersion},
      {"reserved", 6, 1, Status::kReservedBits},
      {"record length", kPlcHeaderBytes, 3, Status::kFieldRange},
      {"huge record", kPlcHeaderBytes + 3, 0x7f, Status::kFieldRange},
      {"frame count", index + 7, 0x7f, Status::kFieldRange},
      {"entry", index + 9, 0x33, Status::kBadCheck},
      {"trailer check", end - 5, 0x01, Status::kBadCheck},
      {"trailer magic", end - 1, 'X', Status::kBadCheck},
      {"trailer offset", end - 20, 0xee, Status::kBadCheck},
  };
  for (const Fault& fault : faults) {
    Bytes spoilt = s.file;
    spoilt[fault.at] = fault.value;
    const auto read = read_plc(spoilt);
    ASSERT_FALSE(read.ok()) << fault.name;
    EXPECT_EQ(read.error().status, fault.status) << fault.name << ": " << read.error().message;
  }
  Bytes longer = s.file;
  longer.push_back(0);
  const auto read = read_plc(longer);
  ASSERT_FALSE(read.ok());
  EXPECT_EQ(read.error().status, Status::kTrailingBytes);
}

TEST(PlcFormat, FramesOfOneNumberStayApartWhenAnythingElseDiffers) {
  Bytes file;
  PlcWriter writer(file);
  const Bytes k = key(1);
  ASSERT_EQ(writer.add_packet(k), Status::kOk);
  for (const std::uint16_t n : {std::uint16_t{1}, std::uint16_t{2}})
    for (std::uint16_t i = 0; i < n; ++i)
      ASSERT_EQ(writer.add_packet(slice(7, i, n, k)), Status::kOk);
  PacketHeader later{false, kStream, 7, 999, 0, 2, hash_of(k)};
  ASSERT_EQ(writer.add_packet(sealed(later, 5, 0)), Status::kOk);
  writer.finish();
  const auto read = read_plc(file);
  ASSERT_TRUE(read.ok()) << read.error().message;
  EXPECT_EQ(read->frames.size(), 3U);
  EXPECT_EQ(read_plc_index(file)->size(), 3U);
}

TEST(PlcFormat, WritersRefuseWhatReadersWould) {
  Bytes file;
  PlcWriter writer(file);
  const Bytes k = key(1);
  EXPECT_EQ(writer.add_packet(slice(0, 0, 1, k)), Status::kBadConfig) << "no key packet yet";
  Bytes spoilt = k;
  spoilt.back() ^= 1;
  EXPECT_EQ(writer.add_packet(spoilt), Status::kBadCheck);
  EXPECT_EQ(writer.add_packet(std::span(k).first(10)), Status::kTruncated);
  EXPECT_EQ(file.size(), kPlcHeaderBytes);
  EXPECT_EQ(writer.add_packet(k), Status::kOk);
  writer.finish();
  const std::size_t size = file.size();
  writer.finish();
  EXPECT_EQ(writer.add_packet(k), Status::kBadConfig);
  EXPECT_EQ(file.size(), size);
  const auto read = read_plc(file);
  ASSERT_TRUE(read.ok());
  EXPECT_TRUE(read->complete);
  EXPECT_TRUE(read->frames.empty());
}

TEST(PlcFormat, RandomBytesBehindAHeaderAreNamedOrCut) {
  Pcg32 random(5);
  for (int i = 0; i < 3000; ++i) {
    Bytes file = {'P', 'L', 'C', '0', kPlcMajor, kPlcMinor, 0, 0};
    const std::uint32_t more = random.below(200);
    for (std::uint32_t n = 0; n < more; ++n)
      file.push_back(random.below(3) == 0 ? std::uint8_t{0}
                                          : static_cast<std::uint8_t>(random.next()));
    const auto read = read_plc(file);
    if (!read.ok()) EXPECT_TRUE(test::is_wire_status(read.error().status));
    if (read.ok()) EXPECT_TRUE(read->frames.empty());
    (void)read_plc_index(file);
  }
}

}  // namespace
}  // namespace planecast
