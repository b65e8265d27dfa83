// Tells transport who a Planecast packet is: the one place where the codec's packet header and the
// assembler's PacketInfo meet. Set SubscriberConfig::parse and AssemblerConfig::frame_bits to
// these.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/status.hpp"
#include "core/wire/packet_header.hpp"
#include "transport/packet_info.hpp"

namespace planecast {

/// AssemblerConfig::frame_bits of Planecast streams: AssembledFrame::frame is the number on the
/// wire as it is, and distances between frames are right across its wrap at 2^24.
inline constexpr std::uint8_t kPacketFrameBits = 24;
static_assert((std::uint32_t{1} << kPacketFrameBits) - 1 == kFrameNumberMask);

/// A ParseFn: checks header and check of any bytes and fills `out`. session is the key hash, which
/// differs from one start of a sender to the next; stamp_ns is the header's offset from the
/// epoch of the key packet (see stamp_of_offset). Statuses of open_packet. No allocation.
Status parse_planecast_packet(std::span<const std::uint8_t> packet, PacketInfo& out) noexcept;

/// The stamp [ns] behind an offset: offsets count from `epoch_ns` (StreamConfig) modulo 2^48 ns (78
/// hours); of the possible stamps the one nearest to `near_ns` on the same clock (now, or the
/// stamp before). Any thread.
std::int64_t stamp_of_offset(std::int64_t epoch_ns, std::int64_t offset_ns,
                             std::int64_t near_ns) noexcept;

}  // namespace planecast
