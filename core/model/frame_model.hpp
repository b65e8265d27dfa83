// What a frame means between fit and pack: cleaned depth, the surfaces found, and which block lies
// on which. Spans over memory that its owner (a frame slot, or a tile decoder's caller) keeps.
#pragma once

#include <cstdint>
#include <span>

#include "core/model/surface.hpp"

namespace planecast {

/// Labels of a block: 0 none, otherwise 1 + index into FrameModel::surfaces. second != 0 only
/// where first != 0 and the frame is of surfaces kind.
struct BlockLabel {
  std::uint8_t first = 0;
  std::uint8_t second = 0;
};

/// Most surfaces of a frame; a label fits a byte.
inline constexpr int kMaxSurfaces = 63;

/// Input of the packer. depth: row-major, width * height counts, 0 = no reading; blocks: 8 x 8
/// pixels, row-major, ceil(width/8) * ceil(height/8).
struct FrameModel {
  std::span<const std::uint16_t> depth;
  std::span<const BlockLabel> blocks;
  std::span<const Surface> surfaces;
  std::uint8_t shift = 0;  ///< every coefficient is a multiple of 2^shift
};

}  // namespace planecast
