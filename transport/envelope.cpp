#include "transport/envelope.hpp"

#include <cstring>

#include "core/base/bytes.hpp"

namespace planecast {

void write_envelope_header(std::size_t packet_bytes,
                           std::span<std::uint8_t, kEnvelopeOverheadBytes> out) noexcept {
  store_be<std::uint64_t>(out.data(), kEnvelopeFingerprint);
  store_be<std::uint16_t>(out.data() + 8, static_cast<std::uint16_t>(packet_bytes));
}

Status encode_envelope(std::span<const std::uint8_t> packet, std::span<std::uint8_t> out,
                       std::size_t& size) noexcept {
  size = 0;
  if (packet.empty() || packet.size() > kMaxPacketBytes) return Status::kFieldRange;
  if (out.size() < kEnvelopeOverheadBytes + packet.size()) return Status::kTooLarge;
  write_envelope_header(packet.size(), out.first<kEnvelopeOverheadBytes>());
  std::memcpy(out.data() + kEnvelopeOverheadBytes, packet.data(), packet.size());
  size = kEnvelopeOverheadBytes + packet.size();
  return Status::kOk;
}

Status decode_envelope(std::span<const std::uint8_t> message,
                       std::span<const std::uint8_t>& packet) noexcept {
  packet = {};
  if (message.size() < kEnvelopeOverheadBytes) return Status::kTruncated;
  if (load_be<std::uint64_t>(message.data()) != kEnvelopeFingerprint) return Status::kBadMagic;
  const std::size_t announced = load_be<std::uint16_t>(message.data() + 8);
  if (announced > kMaxPacketBytes) return Status::kFieldRange;
  const std::size_t present = message.size() - kEnvelopeOverheadBytes;
  if (present < announced) return Status::kTruncated;
  if (present > announced) return Status::kTrailingBytes;
  packet = message.subspan(kEnvelopeOverheadBytes);
  return Status::kOk;
}

}  // namespace planecast
