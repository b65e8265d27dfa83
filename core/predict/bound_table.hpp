// How far a reconstruction may be from its reading, in depth counts and in levels, so that the
// 3-D bound of the stream holds. Integers only, rounded towards the stricter side; both halves
// use it: the encoder to verify, both to choose the step of a correction.
#pragma once

#include <cstdint>
#include <span>

#include "core/base/arena.hpp"
#include "core/base/status.hpp"
#include "core/model/stream_config.hpp"
#include "core/predict/level_table.hpp"
#include "core/sensor/ray_table.hpp"

namespace planecast {

/// Blocks are 8 x 8 pixels: the unit of labels, flags and ray classes.
inline constexpr int kBlockSide = 8;

/// Ray classes: pixels whose rays have about the same length share their steps.
inline constexpr int kRayClasses = 16;

/// Largest half-width kept in the table, in levels.
inline constexpr int kMaxHalfWidth = 255;

/// The levels whose depths hold the bound of a reading; none where low > high. {0, 0} for a hole.
struct LevelWindow {
  std::uint16_t low = 0, high = 0;
};

/// Which half of the codec a table is for.
enum class CodecHalf : std::uint8_t { kEncoder, kDecoder };

/// The bound of a stream as tables. Read-only after build(). Memory: 1.3 MiB from the arena, of an
/// encoder 5.3 MiB.
class BoundTable {
 public:
  void layout(Arena& arena, std::uint32_t max_pixels,
              CodecHalf half = CodecHalf::kEncoder) noexcept;

  /// Computes the tables for a stream. O(65536 * kRayClasses). kFieldRange when the image is
  /// larger than the layout allows.
  Status build(const StreamConfig& config, const RayTable& rays, const LevelTable& levels) noexcept;

  /// True when the stream is lossless: every half-width is zero.
  bool lossless() const noexcept { return lossless_; }

  /// Class of a block (8 x 8 pixels); bx, by in blocks.
  std::uint8_t ray_class(std::uint32_t bx, std::uint32_t by) const noexcept {
    return classes_[std::size_t{by} * blocks_wide_ + bx];
  }

  /// Largest |depth' - depth| in counts that keeps a reading of `depth` counts within the bound.
  std::uint32_t max_error(std::uint16_t depth, std::uint8_t ray_class) const noexcept {
    return static_cast<std::uint32_t>(
        (std::uint64_t{error_q8_[depth]} * inverse_length_q16_[ray_class]) >> 24U);
  }

  /// Half-widths in levels around each level, for one class: half_widths(c)[level].
  const std::uint8_t* half_widths(std::uint8_t ray_class) const noexcept {
    return half_width_.data() + std::size_t{ray_class} * 65536;
  }

  /// Windows of all depth counts, for one class: windows(c)[depth]. An encoder's: all that is
  /// asked of a reading is one look-up.
  const LevelWindow* windows(std::uint8_t ray_class) const noexcept {
    return windows_.data() + std::size_t{ray_class} * 65536;
  }

 private:
  void build_errors(const StreamConfig& config) noexcept;
  void build_classes(const RayTable& rays) noexcept;
  void build_half_widths(const LevelTable& levels) noexcept;
  void build_windows(const LevelTable& levels) noexcept;

  bool lossless_ = true;
  std::uint32_t blocks_wide_ = 0;
  std::uint32_t inverse_length_q16_[kRayClasses] = {};
  std::span<std::uint32_t> error_q8_;
  std::span<std::uint8_t> half_width_;
  std::span<std::uint8_t> classes_;
  std::span<LevelWindow> windows_;  ///< empty in a decoder
};

}  // namespace planecast
