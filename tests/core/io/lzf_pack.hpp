// A plain LZF packer for tests: the reader must not be tested against itself alone.
#pragma once

#include <algorithm>
#include <cstdint>
#include <span>
#include <unordered_map>
#include <vector>

namespace planecast::test {

inline std::vector<std::uint8_t> lzf_pack(std::span<const std::uint8_t> in) {
  std::vector<std::uint8_t> out;
  std::unordered_map<std::uint32_t, std::size_t> last_seen;  // three bytes -> where they were last
  std::size_t literals = 0;                                  // start of the pending literals
  const auto flush = [&](std::size_t end) {
    while (literals < end) {
      const std::size_t length = std::min<std::size_t>(32, end - literals);
      out.push_back(static_cast<std::uint8_t>(length - 1));
      out.insert(out.end(), in.begin() + static_cast<std::ptrdiff_t>(literals),
                 in.begin() + static_cast<std::ptrdiff_t>(literals + length));
      literals += length;
    }
  };
  std::size_t at = 0;
  while (at + 3 <= in.size()) {
    const std::uint32_t key = in[at] | in[at + 1] << 8U | in[at + 2] << 16U;
    const auto seen = last_seen.find(key);
    const std::size_t distance = seen == last_seen.end() ? 0 : at - seen->second;
    last_seen[key] = at;
    if (distance == 0 || distance > 8192) {
      ++at;
      continue;
    }
    std::size_t length = 3;
    while (length < 264 && at + length < in.size() &&
           in[at + length] == in[at + length - distance]) {
      ++length;
    }
    flush(at);
    const std::size_t code = length - 2;
    const std::size_t back = distance - 1;
    out.push_back(static_cast<std::uint8_t>(std::min<std::size_t>(code, 7) << 5U | back >> 8U));
    if (code >= 7) out.push_back(static_cast<std::uint8_t>(code - 7));
    out.push_back(static_cast<std::uint8_t>(back));
    at += length;
    literals = at;
  }
  flush(in.size());
  return out;
}

}  // namespace planecast::test
