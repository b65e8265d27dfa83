// LZF as in "DATA binary_compressed" PCD files (liblzf's stream format, no header). Expansion only.
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/status.hpp"

namespace planecast {

/// Three packed bytes give at most 264: what a header claims beyond this ratio is a lie.
inline constexpr std::uint64_t kMaxLzfExpansion = 88;

/// Expands `packed` into exactly out.size() bytes; neither span is read or written outside.
/// `stopped_at` is the offset in `packed` of the item where it ended. No allocation, O(out.size()).
/// kTruncated: packed ends inside an item, or gives fewer bytes than out holds.
/// kTooLarge: it would give more. kBadSymbol: a match reaches back before the start.
Status lzf_expand(std::span<const std::uint8_t> packed, std::span<std::uint8_t> out,
                  std::size_t& stopped_at) noexcept;

}  // namespace planecast
