// The key packet: a StreamConfig as bytes (docs/wire-format.md, "Key packet").
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/status.hpp"
#include "core/model/stream_config.hpp"

namespace planecast {

/// Most bytes of a key packet's body of this version.
inline constexpr std::size_t kMaxKeyBodyBytes = 320;

/// Writes the body; returns its size, or 0 when `out` is shorter than kMaxKeyBodyBytes.
std::size_t write_key_body(const StreamConfig& config, std::span<std::uint8_t> out) noexcept;

/// Reads and checks a body. kTruncated; kUnsupportedVersion: another minor version; kReservedBits;
/// kFieldRange: what check_config refuses; kTrailingBytes. Attribute blocks are skipped by their
/// length. Any bytes, any thread; no allocation.
Status read_key_body(std::span<const std::uint8_t> body, StreamConfig& config) noexcept;

/// The hash that slices carry: CRC-32C of the body.
std::uint32_t key_hash(std::span<const std::uint8_t> body) noexcept;

}  // namespace planecast
