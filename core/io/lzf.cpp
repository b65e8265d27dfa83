#include "core/io/lzf.hpp"

#include <algorithm>

namespace planecast {
namespace {

constexpr std::size_t kFirstMatchByte = 32;  // below: a run of literals
constexpr std::size_t kLongMatch = 7;        // this length code is followed by one more length byte

struct Match {
  std::size_t length;
  std::size_t distance;
  std::size_t item_bytes;
};

bool read_match(std::span<const std::uint8_t> packed, std::size_t at, Match& match) noexcept {
  const std::size_t control = packed[at];
  const std::size_t code = control >> 5U;
  match.item_bytes = code == kLongMatch ? 3 : 2;
  if (packed.size() - at < match.item_bytes) return false;
  match.length = code + 2 + (code == kLongMatch ? packed[at + 1] : 0U);
  match.distance = ((control & 31U) << 8U) + packed[at + match.item_bytes - 1] + 1;
  return true;
}

}  // namespace

Status lzf_expand(std::span<const std::uint8_t> packed, std::span<std::uint8_t> out,
                  std::size_t& stopped_at) noexcept {
  std::size_t& in = stopped_at;
  in = 0;
  std::size_t filled = 0;
  while (in < packed.size()) {
    const std::size_t control = packed[in];
    if (control < kFirstMatchByte) {
      const std::size_t length = control + 1;
      if (packed.size() - in - 1 < length) return Status::kTruncated;
      if (out.size() - filled < length) return Status::kTooLarge;
      std::copy_n(packed.data() + in + 1, length, out.data() + filled);
      filled += length;
      in += 1 + length;
      continue;
    }
    Match match{};
    if (!read_match(packed, in, match)) return Status::kTruncated;
    if (match.distance > filled) return Status::kBadSymbol;
    if (out.size() - filled < match.length) return Status::kTooLarge;
    // Byte by byte and forward: a match may overlap the bytes it produces.
    for (std::size_t i = 0; i < match.length; ++i, ++filled) {
      out[filled] = out[filled - match.distance];
    }
    in += match.item_bytes;
  }
  return filled == out.size() ? Status::kOk : Status::kTruncated;
}

}  // namespace planecast
