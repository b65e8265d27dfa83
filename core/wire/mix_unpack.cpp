#include "core/wire/mix_unpack.hpp"

#include <algorithm>

namespace planecast {
namespace {

// Reads what MixTile asks for, and puts pixels where they go.
struct MixReader {
  static constexpr bool kEncodes = false;
  RangeDecoder& coder;
  std::uint16_t* depth;  ///< first pixel of the tile
  std::uint8_t* labels;  ///< beside it, or null
  std::uint32_t width;   ///< of the image

  bool bit(BitModel& model, bool) noexcept { return coder.bit(model); }
  bool bit_at(std::uint32_t probability, bool) noexcept { return coder.bit_at(probability); }
  std::uint32_t raw(std::uint32_t, int bits) noexcept { return coder.raw(bits); }
  bool stopped() const noexcept { return coder.truncated(); }

  void put(std::uint32_t x, std::uint32_t v, std::uint16_t count, std::uint8_t label) noexcept {
    depth[std::size_t{v} * width + x] = count;
    if (labels != nullptr) labels[std::size_t{v} * width + x] = label;
  }
  void put_holes(std::uint32_t x0, std::uint32_t x1, std::uint32_t v) noexcept {
    for (std::uint32_t x = x0; x < x1; ++x) put(x, v, 0, 0);
  }
};

}  // namespace

Status MixUnpacker::unpack(const CodingTables& tables, RangeDecoder& coder, std::int32_t fallback,
                           const TileTarget& target, TileContent& content) noexcept {
  MixJob job(tables, content.rect);
  job.fallback = fallback;
  job.last_middle = fallback * 256;
  job.surface_count = static_cast<int>(content.surfaces);
  for (std::uint32_t i = 0; i < content.surfaces; ++i) job.surfaces[i + 1] = content.surface[i];
  const std::uint32_t width = tables.config->camera.width;
  const std::size_t begin = std::size_t{job.span.v0} * width + job.span.u0;
  MixReader reader{coder, target.depth.data() + begin,
                   target.labels.empty() ? nullptr : target.labels.data() + begin, width};
  const Status status = MixTile<MixReader>(job, scratch_, reader).code();
  content.points = job.points;
  content.corrections = job.corrections;
  return coder.truncated() ? Status::kTruncated : status;
}

}  // namespace planecast
