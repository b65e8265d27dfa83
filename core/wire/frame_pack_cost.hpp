// What the cutting of a frame goes by: how many bits a block will take, guessed from its pixels,
// and the sums that correct the guess by what tiles then took. Encoder half.
#pragma once

#include <cstdint>

#include "core/wire/tile_syntax.hpp"

namespace planecast {

/// Estimated cost of a block in 1/16 bit, before any scale: readings whose neighbours do not
/// predict them within the bound, and the hole mask where a block is mixed.
std::uint32_t block_cost(const CodingTables& tables, const FrameModel& frame, std::uint32_t bx,
                         std::uint32_t by) noexcept;

/// Sums over tiles that least squares needs: costs off surfaces (a) and on (b), bits (y).
struct PackMoments {
  double aa = 0, ab = 0, bb = 0, ay = 0, by = 0;
  void add(double a, double b, double y) noexcept {
    aa += a * a;
    ab += a * b;
    bb += b * b;
    ay += a * y;
    by += b * y;
  }
  void add(const PackMoments& other) noexcept {
    aa += other.aa;
    ab += other.ab;
    bb += other.bb;
    ay += other.ay;
    by += other.by;
  }
};

}  // namespace planecast
