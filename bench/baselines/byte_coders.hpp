// General byte compressors by their own libraries, as functions of bytes; the depth baselines and
// the point baselines that end in one share them. A function whose library was not found throws.
#pragma once

#include <span>
#include <string>

#include "bench/baselines/baseline.hpp"

namespace planecast::baselines {

enum class ByteCoder : std::uint8_t { kZstd, kBzip2, kXz };

/// Whether its library was there when this was built.
bool available(ByteCoder coder);
/// "zstd-3", "bzip2-9", "xz-6".
std::string name_of(ByteCoder coder, int level);
/// The compressed bytes, preceded by the original length as a varint.
Bytes compress(ByteCoder coder, int level, std::span<const std::uint8_t> raw);
/// The original bytes. Throws on bytes that compress() did not make.
Bytes decompress(ByteCoder coder, std::span<const std::uint8_t> packed);

}  // namespace planecast::baselines
