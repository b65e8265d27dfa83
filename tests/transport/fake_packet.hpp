// A stand-in for the codec's packets: identity, a check, and a body that depends on the identity,
// so that a test can tell whether the right bytes came out.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/base/bytes.hpp"
#include "core/base/random.hpp"
#include "transport/packet_info.hpp"

namespace planecast::test {

inline constexpr std::uint8_t kFakeMagic = 0xA7;
inline constexpr std::size_t kFakeHeaderBytes = 28;
inline constexpr std::int64_t kSecond = 1'000'000'000;  // in ns

inline std::uint32_t fake_check(std::span<const std::uint8_t> bytes) noexcept {
  std::uint32_t hash = 2166136261U;
  for (const std::uint8_t byte : bytes) hash = (hash ^ byte) * 16777619U;
  return hash;
}

/// A packet of this identity; `salt` makes another body of another length.
inline std::vector<std::uint8_t> fake_packet(const PacketInfo& info, std::uint32_t salt = 0,
                                             std::size_t body = 0) {
  Pcg32 random(info.session * 977ULL + info.frame, 1 + info.stream * 70001ULL + info.slice + salt);
  if (body == 0) body = 1 + random.below(90);
  std::vector<std::uint8_t> packet(kFakeHeaderBytes + body);
  packet[0] = kFakeMagic;
  packet[1] = info.key ? 1 : 0;
  store_le<std::uint16_t>(&packet[2], info.stream);
  store_le<std::uint32_t>(&packet[4], info.session);
  store_le<std::uint32_t>(&packet[8], info.frame);
  store_le<std::uint16_t>(&packet[12], info.slice);
  store_le<std::uint16_t>(&packet[14], info.slice_count);
  store_le<std::uint64_t>(&packet[16], static_cast<std::uint64_t>(info.stamp_ns));
  for (std::size_t i = kFakeHeaderBytes; i < packet.size(); ++i)
    packet[i] = static_cast<std::uint8_t>(random.next());
  store_le<std::uint32_t>(&packet[24], 0);
  store_le<std::uint32_t>(&packet[24], fake_check(packet));
  return packet;
}

inline Status parse_fake(std::span<const std::uint8_t> packet, PacketInfo& out) noexcept {
  if (packet.size() < kFakeHeaderBytes) return Status::kTruncated;
  if (packet[0] != kFakeMagic) return Status::kBadMagic;
  if (packet[1] > 1) return Status::kReservedBits;
  std::uint32_t hash = 2166136261U;
  for (std::size_t i = 0; i < packet.size(); ++i) {
    const std::uint8_t byte = i >= 24 && i < 28 ? std::uint8_t{0} : packet[i];
    hash = (hash ^ byte) * 16777619U;
  }
  if (hash != load_le<std::uint32_t>(&packet[24])) return Status::kBadCheck;
  out.key = packet[1] == 1;
  out.stream = load_le<std::uint16_t>(&packet[2]);
  out.session = load_le<std::uint32_t>(&packet[4]);
  out.frame = load_le<std::uint32_t>(&packet[8]);
  out.slice = load_le<std::uint16_t>(&packet[12]);
  out.slice_count = load_le<std::uint16_t>(&packet[14]);
  out.stamp_ns = static_cast<std::int64_t>(load_le<std::uint64_t>(&packet[16]));
  return Status::kOk;
}

/// Identity of a slice with the stamp that belongs to its frame number at 30 Hz.
inline PacketInfo slice_info(std::uint32_t session, std::uint16_t stream, std::uint32_t frame,
                             std::uint16_t slice, std::uint16_t count) noexcept {
  PacketInfo info;
  info.session = session;
  info.stream = stream;
  info.frame = frame;
  info.slice = slice;
  info.slice_count = count;
  info.stamp_ns = std::int64_t{frame} * 33'333'333;
  return info;
}

inline PacketInfo key_info(std::uint32_t session, std::uint16_t stream,
                           std::uint32_t frame) noexcept {
  PacketInfo info = slice_info(session, stream, frame, 0, 0);
  info.key = true;
  return info;
}

}  // namespace planecast::test
