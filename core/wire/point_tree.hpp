// The tree of cells of a point slice, level by level, the same code for both halves
// (docs/wire-format.md, "Point tile"). `Io` reads or writes decisions:
//   kReads; bool bit(BitModel&, bool); bool bit_at(probability, bool); uint32 raw(value, bits);
//   bool failed(); uint32 octant(cell, level), uint32 count(cell): the encoder's cells;
//   void emit(cell position, points): what the decoder puts out.
#pragma once

#include <algorithm>
#include <array>
#include <bit>
#include <cstdint>

#include "core/base/status.hpp"
#include "core/wire/point_levels.hpp"
#include "core/wire/point_models.hpp"

namespace planecast {

template <class Io>
class PointTree {
 public:
  /// `levels` holds min(points, kMaxSliceCells) nodes or more.
  PointTree(Io& io, PointModels& models, PointMixers& mixers, PointLevels& levels) noexcept
      : io_(io), models_(models), mixers_(mixers), levels_(levels) {}

  /// A tree of 2^depth cells a side that holds `points` points in (encoder) `cells` cells, its
  /// points counted by groups of 2^group_shift cells a side. kBadSymbol: impossible content;
  /// kTruncated; kTooLarge: more cells than the levels hold.
  Status code(unsigned depth, unsigned group_shift, std::uint32_t points,
              std::uint32_t cells) noexcept {
    points_ = points;
    placed_ = 0;
    most_nodes_ = std::min(points, levels_.capacity());
    if (most_nodes_ == 0) return points == 0 ? Status::kOk : Status::kTooLarge;
    levels_.begin(cells);
    for (unsigned level = depth; level-- > 0;) {
      if (const Status status = code_level(level); status != Status::kOk) return status;
      levels_.descend(level > 0);
    }
    return code_counts(group_shift);
  }

 private:
  Status code_level(unsigned level) noexcept {
    const auto nodes = levels_.nodes();
    for (std::uint32_t i = 0; i < nodes.size(); ++i) {
      const PointNode& node = nodes[i];
      levels_.set_children(i, 0, 0);
      if (level > 0 && node.pattern == 1U << kCentreBit) {
        const bool single = !Io::kReads && node.end - node.first == 1 && io_.count(node.first) == 1;
        if (io_.bit(models_.single[std::min(level, 31U)], single)) {
          if (const Status status = code_single(node, level); status != Status::kOk) return status;
          continue;
        }
      }
      if (const Status status = code_children(nodes, i, level); status != Status::kOk)
        return status;
    }
    return io_.failed() ? Status::kTruncated : Status::kOk;
  }

  // The rest of the position of a lone point, three bits a level.
  Status code_single(const PointNode& node, unsigned level) noexcept {
    std::array<std::uint32_t, 3> at = node.at;
    for (unsigned l = level + 1; l-- > 0;) {
      const std::uint32_t octant = io_.raw(Io::kReads ? 0 : io_.octant(node.first, l), 3);
      for (unsigned axis = 0; axis < 3; ++axis) at[axis] = 2 * at[axis] + (octant >> axis & 1U);
    }
    return place(at, 1);
  }

  Status code_children(std::span<PointNode> nodes, std::uint32_t i, unsigned level) noexcept {
    const PointNode& node = nodes[i];
    Surroundings around;
    for (std::uint32_t left = node.pattern & ~(1U << kCentreBit); left != 0; left &= left - 1) {
      const auto d = static_cast<unsigned>(std::countr_zero(left));
      const std::uint32_t j = node.near[d];
      around.add(d, j < i, levels_.mask(j));
    }
    const NodePlane& plane = levels_.planes().plane(node.pattern);
    OccupancyModels& models = models_.occupancy[level == 0 ? 0 : 1];
    BitMixer<3>& mixer = mixers_.occupancy[level == 0 ? 0 : 1][plane.kind];
    const std::uint32_t first_child = levels_.below();
    std::uint32_t mask = 0;
    std::uint32_t first = node.first;
    unsigned next = Io::kReads ? 8 : io_.octant(first, level);  // encoder: the next occupied one
    for (unsigned octant = 0; octant < 8; ++octant) {
      bool occupied = next == octant;
      if (octant < 7 || mask != 0) {
        MixedModel* const contexts[3] = {
            &models.faces[around.faces(octant)][1U << octant | mask],
            &models.around[std::min(around.weight(octant), 39U)]
                          [std::min(around.unknown(octant), 15U)],
            &models.plane[plane.kind][plane.distance[octant]][sibling_class(mask)]};
        const MixedBit<3> mixed(mixer, contexts);
        occupied = io_.bit_at(mixed.probability, occupied);
        mixed.learn(mixer, contexts, occupied);
        if constexpr (requires { io_.watch(contexts, occupied); }) io_.watch(contexts, occupied);
      } else {
        occupied = true;  // a node has a child
      }
      if (!occupied) continue;
      if (levels_.below() >= most_nodes_) return Status::kBadSymbol;
      PointNode& child = levels_.add_child(node, octant);
      if constexpr (!Io::kReads) {
        child.first = first;
        do {
          ++first;
          next = first < node.end ? io_.octant(first, level) : 8;
        } while (next == octant);
        child.end = first;
      }
      mask |= 1U << octant;
      around.add_sibling(octant);
    }
    levels_.set_children(i, first_child, mask);
    return Status::kOk;
  }

  static unsigned sibling_class(std::uint32_t mask) noexcept {
    return std::min((detail::kBitCounts[mask] + 1U) / 2U, 2U);  // 0; 1 or 2; more
  }

  // Points beyond the first of each cell, by groups, evenly over the cells of a group.
  Status code_counts(unsigned shift) noexcept {
    const auto leaves = levels_.nodes();
    std::uint32_t density = 0;  // extra points a cell, Q4, of the groups before
    for (std::uint32_t first = 0; first < leaves.size();) {
      std::uint32_t end = first;
      std::uint64_t total = 0;
      while (end < leaves.size() && same_group(leaves[first], leaves[end], shift)) {
        if constexpr (!Io::kReads) total += io_.count(leaves[end].first);
        ++end;
      }
      const std::uint32_t cells = end - first;
      const std::uint32_t extra =
          code_extra(static_cast<std::uint32_t>(total - (Io::kReads ? 0 : cells)), cells, density);
      for (std::uint32_t i = 0; i < cells; ++i) {
        const auto share = static_cast<std::uint32_t>(std::uint64_t{i + 1} * extra / cells -
                                                      std::uint64_t{i} * extra / cells);
        if (extra > points_) return Status::kBadSymbol;
        if (const Status status = place(leaves[first + i].at, 1 + share); status != Status::kOk)
          return status;
      }
      const std::uint64_t now =
          std::min<std::uint64_t>(std::uint64_t{16} * extra / cells, 1U << 16U);
      density = static_cast<std::uint32_t>((3 * std::uint64_t{density} + now) / 4);
      first = end;
    }
    if (io_.failed()) return Status::kTruncated;
    return placed_ == points_ ? Status::kOk : Status::kBadSymbol;
  }

  static bool same_group(const PointNode& a, const PointNode& b, unsigned shift) noexcept {
    return a.at[0] >> shift == b.at[0] >> shift && a.at[1] >> shift == b.at[1] >> shift &&
           a.at[2] >> shift == b.at[2] >> shift;
  }

  std::uint32_t code_extra(std::uint32_t extra, std::uint32_t cells,
                           std::uint32_t density) noexcept {
    const auto crowd = std::min(static_cast<unsigned>(std::bit_width(cells)), 5U) - 1;
    const unsigned dense = density < 2 ? 0 : (density < 16 ? 1 : (density < 64 ? 2 : 3));
    BitModel* const sizes = models_.extra_size[crowd * 4 + dense];
    const auto wanted = static_cast<unsigned>(std::bit_width(extra));
    unsigned size = 0;
    while (size < 32 && io_.bit(sizes[size], wanted > size)) ++size;
    if (size < 2) return size;
    const unsigned below = size - 2;  // bits below the two leading ones
    std::uint32_t value =
        2U | (io_.bit(models_.extra_top[size], (extra >> below & 1U) != 0) ? 1U : 0U);
    for (unsigned left = below; left > 0;) {
      const unsigned part = std::min(left, 16U);
      left -= part;
      value = value << part | io_.raw(extra >> left & ((1U << part) - 1), static_cast<int>(part));
    }
    return value;
  }

  Status place(const std::array<std::uint32_t, 3>& at, std::uint32_t points) noexcept {
    if (points > points_ - placed_) return Status::kBadSymbol;
    placed_ += points;
    return io_.emit(at, points);
  }

  Io& io_;
  PointModels& models_;
  PointMixers& mixers_;
  PointLevels& levels_;
  std::uint32_t points_ = 0;      ///< of the slice
  std::uint32_t placed_ = 0;      ///< so far
  std::uint32_t most_nodes_ = 0;  ///< on any level
};

}  // namespace planecast
