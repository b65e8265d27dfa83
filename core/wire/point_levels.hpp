// The nodes of one level of the point tree, who neighbours whom, and what is seen from a node's
// children. Shared by both halves (docs/wire-format.md, "Point tile").
#pragma once

#include <array>
#include <bit>
#include <cstddef>
#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/wire/point_neighbours.hpp"

namespace planecast {

/// Cells of a slice at most: bounds the memory of both halves.
inline constexpr std::uint32_t kMaxSliceCells = 131072;

struct PointNode {
  std::array<std::uint32_t, 3> at{};  ///< position in nodes of this level
  std::uint32_t first = 0;            ///< encoder: its cells
  std::uint32_t end = 0;
  std::uint32_t pattern = 0;  ///< which neighbours are occupied; its own bit is set
  std::uint32_t near[27];     ///< indices of the neighbours in `pattern`
};

namespace detail {

/// The children of the neighbour at bit d that touch the centre node's.
constexpr std::array<std::uint8_t, 27> make_touching() {
  std::array<std::uint8_t, 27> table{};
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        for (unsigned octant = 0; octant < 8; ++octant) {
          const auto seen = [](int d, unsigned c) { return d == 0 || (d < 0) == (c != 0); };
          if (seen(x, octant & 1U) && seen(y, octant >> 1U & 1U) && seen(z, octant >> 2U))
            table[pattern_bit(x, y, z)] |= static_cast<std::uint8_t>(1U << octant);
        }
  return table;
}
inline constexpr auto kTouching = make_touching();

/// Where the children of the neighbour at bit d stand in a window of 4 x 4 x 4.
constexpr std::array<std::int8_t, 27> make_window_shift() {
  std::array<std::int8_t, 27> table{};
  for (int z = -1; z <= 1; ++z)
    for (int y = -1; y <= 1; ++y)
      for (int x = -1; x <= 1; ++x)
        table[pattern_bit(x, y, z)] =
            static_cast<std::int8_t>(2 * x + 1 + 4 * (2 * y + 1) + 16 * (2 * z + 1));
  return table;
}
inline constexpr auto kWindowShift = make_window_shift();

/// What one occupied or unknown child of a neighbour adds to the eight children of the centre
/// node, a byte each: 3, 2, 1 where they share a face, an edge, a corner.
constexpr std::uint64_t weights_of(int dx, int dy, int dz, unsigned octant, bool counts) {
  std::uint64_t sum = 0;
  const int d[3] = {dx, dy, dz};
  for (unsigned mine = 0; mine < 8; ++mine) {
    int far = 0;
    bool touches = true;
    for (unsigned axis = 0; axis < 3; ++axis) {
      const int gap =
          2 * d[axis] + static_cast<int>(octant >> axis & 1U) - static_cast<int>(mine >> axis & 1U);
      touches = touches && gap >= -1 && gap <= 1;
      far += gap != 0 ? 1 : 0;
    }
    if (touches && far > 0)
      sum += std::uint64_t{counts ? 1U : static_cast<unsigned>(4 - far)} << (8 * mine);
  }
  return sum;
}

/// Powers of three of the axis on which the neighbour at bit d shares a face, else 0.
constexpr unsigned face_place(unsigned d) {
  const unsigned x = d % 3, y = d / 3 % 3, z = d / 9;
  if (y == 1 && z == 1 && x != 1) return 1;
  if (x == 1 && z == 1 && y != 1) return 3;
  if (x == 1 && y == 1 && z != 1) return 9;
  return 0;
}

/// `state` times the place of the face for each of the eight that lies across from `octant`.
constexpr std::uint64_t face_of(unsigned d, unsigned octant, unsigned state) {
  const unsigned place = face_place(d);
  if (place == 0 || (kTouching[d] >> octant & 1U) == 0) return 0;
  const unsigned axis = place == 1 ? 0 : (place == 3 ? 1 : 2);
  return std::uint64_t{state * place} << (8 * (octant ^ (1U << axis)));
}

/// Sums for the eight children of a node of what a neighbour's children add, by halves of its mask.
struct NeighbourSums {
  std::uint64_t weights[2][16] = {};  ///< known children: 3 face, 2 edge, 1 corner
  std::uint64_t faces[2][16] = {};    ///< known children across a face
  std::uint64_t unknown = 0;          ///< children, where none is known yet
  std::uint64_t unknown_faces = 0;
};

/// Computed when the program starts, in point_tables.cpp: 14 kB that a board's flash need not hold.
extern const std::array<NeighbourSums, 27> kNeighbourSums;

/// What an occupied child adds to its siblings.
constexpr std::array<std::uint64_t, 8> make_sibling_weights() {
  std::array<std::uint64_t, 8> table{};
  for (unsigned octant = 0; octant < 8; ++octant)
    table[octant] = weights_of(0, 0, 0, octant, false);
  return table;
}
inline constexpr auto kSiblingWeights = make_sibling_weights();

/// Set bits of a byte.
constexpr std::array<std::uint8_t, 256> make_bit_counts() {
  std::array<std::uint8_t, 256> table{};
  for (unsigned mask = 1; mask < 256; ++mask)
    table[mask] = static_cast<std::uint8_t>(table[mask >> 1U] + (mask & 1U));
  return table;
}
inline constexpr auto kBitCounts = make_bit_counts();

/// Child octant -> its neighbour at bit d: the parent's neighbour and the octant there.
struct ChildStep {
  std::uint8_t parent, octant;
};
constexpr std::array<std::array<ChildStep, 27>, 8> make_child_steps() {
  std::array<std::array<ChildStep, 27>, 8> table{};
  for (unsigned octant = 0; octant < 8; ++octant)
    for (int z = -1; z <= 1; ++z)
      for (int y = -1; y <= 1; ++y)
        for (int x = -1; x <= 1; ++x) {
          const int at[3] = {static_cast<int>(octant & 1U) + x,
                             static_cast<int>(octant >> 1U & 1U) + y,
                             static_cast<int>(octant >> 2U) + z};
          int outside[3] = {};
          unsigned inside = 0;
          for (unsigned i = 0; i < 3; ++i) {
            outside[i] = at[i] < 0 ? -1 : (at[i] > 1 ? 1 : 0);
            inside |= static_cast<unsigned>(at[i] & 1) << i;
          }
          table[octant][pattern_bit(x, y, z)] = {
              static_cast<std::uint8_t>(pattern_bit(outside[0], outside[1], outside[2])),
              static_cast<std::uint8_t>(inside)};
        }
  return table;
}
inline constexpr auto kChildSteps = make_child_steps();

}  // namespace detail

/// A node's children at their places in a window of 4 x 4 x 4 whose corner is child 0.
constexpr std::uint64_t window_of(std::uint32_t mask) noexcept {
  return (mask & 3U) | (mask & 12U) << 2U | (mask & 48U) << 12U | (mask & 192U) << 14U;
}

/// Adds the children `mask` of the neighbour at bit `d` to the window round a node's children.
inline void add_to_window(std::uint64_t& window, unsigned d, std::uint32_t mask) noexcept {
  const std::uint64_t children = window_of(mask & detail::kTouching[d]);
  // No bit leaves at the lower end: the touching children are those that stay.
  window |= std::rotl(children, detail::kWindowShift[d]);
}

/// The place of child `octant` in the window.
constexpr unsigned window_place(unsigned octant) noexcept {
  return (octant & 1U) + 4 * (octant >> 1U & 1U) + 16 * (octant >> 2U);
}

/// The 3 x 3 x 3 round child `octant` as a pattern of 27 bits.
inline std::uint32_t pattern_of_child(std::uint64_t window, unsigned octant) noexcept {
  const std::uint64_t w = window >> window_place(octant);
  const auto layer = [](std::uint64_t v) {
    const auto bits = static_cast<std::uint32_t>(v);
    return (bits & 7U) | (bits >> 1U & 0x38U) | (bits >> 2U & 0x1c0U);
  };
  return layer(w) | layer(w >> 16U) << 9U | layer(w >> 32U) << 18U;
}

/// What is known round the eight children of a node while they are coded, a byte for each.
class Surroundings {
 public:
  /// The neighbour at bit d. Coded before, it has the children `mask`; else any may be occupied.
  void add(unsigned d, bool coded, std::uint32_t mask) noexcept {
    const detail::NeighbourSums& sums = detail::kNeighbourSums[d];
    const std::uint64_t open = coded ? 0 : ~std::uint64_t{0};
    const std::uint32_t known = coded ? mask : 0;
    weights_ += sums.weights[0][known & 15U] + sums.weights[1][known >> 4U];
    faces_ += sums.faces[0][known & 15U] + sums.faces[1][known >> 4U] + (sums.unknown_faces & open);
    unknown_ += sums.unknown & open;
  }
  /// Child `octant` of the node itself turned out to be occupied.
  void add_sibling(unsigned octant) noexcept { weights_ += detail::kSiblingWeights[octant]; }

  /// 3 for each known and occupied neighbour at a face of the child, 2 edge, 1 corner.
  unsigned weight(unsigned octant) const noexcept { return byte(weights_, octant); }
  unsigned unknown(unsigned octant) const noexcept { return byte(unknown_, octant); }
  /// The three face neighbours outside the node, x lowest: 0 empty, 1 unknown, 2 occupied.
  unsigned faces(unsigned octant) const noexcept { return byte(faces_, octant); }

 private:
  static unsigned byte(std::uint64_t bytes, unsigned i) noexcept {
    return static_cast<unsigned>(bytes >> (8 * i)) & 255U;
  }
  std::uint64_t weights_ = 0, unknown_ = 0, faces_ = 0;
};

/// Two levels of nodes, the one being coded and the one below it. Memory from the arena.
class PointLevels {
 public:
  void layout(Arena& arena, std::uint32_t max_points) noexcept {
    const std::uint32_t nodes = max_points < kMaxSliceCells ? max_points : kMaxSliceCells;
    upper_ = arena.take<PointNode>(nodes);
    lower_ = arena.take<PointNode>(nodes);
    children_ = arena.take<std::uint32_t>(nodes);
    masks_ = arena.take<std::uint8_t>(nodes);
    planes_ = arena.take<PlaneCache>(1);
  }

  std::uint32_t capacity() const noexcept { return static_cast<std::uint32_t>(upper_.size()); }

  /// Begins with the root alone.
  void begin(std::uint32_t cells) noexcept {
    PointNode& root = upper_[0];
    root.at = {};
    root.first = 0;
    root.end = cells;
    root.pattern = 1U << kCentreBit;
    root.near[kCentreBit] = 0;
    upper_count_ = 1;
    lower_count_ = 0;
  }

  PlaneCache& planes() noexcept { return planes_[0]; }
  std::span<PointNode> nodes() noexcept { return upper_.first(upper_count_); }
  /// The occupied children of node `i`, once it is coded.
  std::uint32_t mask(std::uint32_t i) const noexcept { return masks_[i]; }
  /// Node `i` has the children `mask`, of which the first is `first` on the level below.
  void set_children(std::uint32_t i, std::uint32_t first, std::uint32_t mask) noexcept {
    children_[i] = first;
    masks_[i] = static_cast<std::uint8_t>(mask);
  }
  std::uint32_t below() const noexcept { return lower_count_; }

  /// Appends child `octant` of `parent`; needs below() < capacity().
  PointNode& add_child(const PointNode& parent, unsigned octant) noexcept {
    PointNode& child = lower_[lower_count_++];
    for (unsigned axis = 0; axis < 3; ++axis)
      child.at[axis] = 2 * parent.at[axis] + (octant >> axis & 1U);
    return child;
  }

  /// Makes the level below the current one; with `linked`, its nodes learn their neighbours.
  void descend(bool linked) noexcept {
    if (linked)
      for (std::uint32_t i = 0; i < upper_count_; ++i) link_children(i);
    std::swap(upper_, lower_);
    upper_count_ = lower_count_;
    lower_count_ = 0;
  }

 private:
  void link_children(std::uint32_t i) noexcept {
    if (masks_[i] == 0) return;
    const PointNode& parent = upper_[i];
    std::uint64_t window = 0;
    for (std::uint32_t left = parent.pattern; left != 0; left &= left - 1) {
      const auto d = static_cast<unsigned>(std::countr_zero(left));
      add_to_window(window, d, masks_[parent.near[d]]);
    }
    std::uint32_t next = children_[i];
    for (std::uint32_t family = masks_[i]; family != 0; family &= family - 1) {
      const auto octant = static_cast<unsigned>(std::countr_zero(family));
      PointNode& child = lower_[next++];
      child.pattern = pattern_of_child(window, octant);
      for (std::uint32_t left = child.pattern; left != 0; left &= left - 1) {
        const auto d = static_cast<unsigned>(std::countr_zero(left));
        const detail::ChildStep step = detail::kChildSteps[octant][d];
        const std::uint32_t other = parent.near[step.parent];
        child.near[d] =
            children_[other] + detail::kBitCounts[masks_[other] & ((1U << step.octant) - 1)];
      }
    }
  }

  std::span<PlaneCache> planes_;  ///< one
  std::span<PointNode> upper_, lower_;
  // Of the upper level; apart from the nodes, since neighbours are looked up all over.
  std::span<std::uint32_t> children_;
  std::span<std::uint8_t> masks_;
  std::uint32_t upper_count_ = 0, lower_count_ = 0;
};

}  // namespace planecast
