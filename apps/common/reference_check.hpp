// The original beside what was received: every point of a frame against the same point of the input
// that the sender played, and its distance against the bound. Loading is cold; checking a frame
// allocates nothing, so that it can run where frames are decoded.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "apps/common/near_grid.hpp"
#include "apps/common/options.hpp"
#include "apps/common/stream_setup.hpp"
#include "core/base/status.hpp"
#include "core/pipeline/decoder.hpp"

namespace planecast {

/// Most memory that a loaded reference may take [bytes].
inline constexpr std::uint64_t kMaxReferenceBytes = std::uint64_t{4} << 30U;

/// What the comparison of one frame found.
struct FrameCheck {
  bool comparable = false;     ///< kind and size agree; nothing below is set otherwise
  std::uint32_t expected = 0;  ///< readings of the original within --range
  std::uint32_t missing = 0;   ///< of them not received, though the stream drops none
  std::uint32_t dropped = 0;   ///< of them not received, as the stream's settings allow
  std::uint32_t invented = 0;  ///< received where the original has no reading
  double max_error_m = 0;      ///< largest distance of a point from its original
  double max_ratio = 0;  ///< largest distance over the point's bound; kBeyond for a point that
                         ///< had to be equal and is not

  static constexpr double kBeyond = 1e9;
  bool holds() const noexcept {
    return comparable && missing == 0 && invented == 0 && max_ratio <= 1.0;
  }
};

class ReferenceCheck {
 public:
  /// Loads every frame of `input` (as the sender reads it, with the same options). The bound is
  /// --tolerance where it was given, else the one that the stream states. kUsage: a cloud without
  /// --tolerance (its stream states less than the user's bound), or larger than
  /// kMaxReferenceBytes; otherwise those of open_source, setup_stream and to_depth.
  static Result<ReferenceCheck> load(const std::string& input, const CodecOptions& options);

  /// Frames of the input; frame n of a stream is compared with frame n modulo this.
  std::uint64_t frames() const noexcept { return frames_.size(); }

  /// Compares the decoder's current frame with the original of number `frame`. One thread at a
  /// time; O(pixels), about 2 ms for 640 x 480.
  /// Lists of points are compared by nearest points both ways, within the bound: O(n log n).
  FrameCheck check(std::uint64_t frame, const Decoder& decoder) const noexcept;

  /// Depth [m] of the original, row-major in the stream's size, 0 or NaN = no reading. Cold path.
  std::vector<float> depth_m(std::uint64_t frame) const;

 private:
  struct Frame {
    std::vector<std::uint16_t> depth;  ///< counts after --range; empty for raw clouds
    std::vector<Point3f> points;       ///< inputs that are clouds; raw ones and lists after --range
  };
  struct Bound;

  Result<Done> add(const SensorFrame& frame);
  const Frame& original_of(std::uint64_t frame) const noexcept {
    return frames_[static_cast<std::size_t>(frame % frames_.size())];
  }
  void check_raw(const Frame& original, const Decoder& decoder, FrameCheck& out) const noexcept;
  void check_list(const Frame& original, const Decoder& decoder, FrameCheck& out) const noexcept;
  void check_depth(const Frame& original, const Decoder& decoder, FrameCheck& out) const noexcept;

  StreamSetup setup_;
  std::optional<Tolerance> tolerance_;
  bool outliers_dropped_ = false;
  std::uint64_t bytes_ = 0;
  std::vector<Frame> frames_;
  // Of the frame being checked, in memory taken while loading: one thread at a time.
  mutable NearGrid original_grid_, decoded_grid_;
  mutable std::vector<std::array<std::int32_t, 3>> original_bits_, decoded_bits_;
};

}  // namespace planecast
