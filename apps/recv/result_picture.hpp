// What a person looks at to see that it works: original depth, label map and regenerated depth of
// one frame side by side, in one colour scale, with words. Cold path.
#pragma once

#include <filesystem>
#include <span>
#include <string>

#include "apps/common/picture.hpp"
#include "apps/common/reference_check.hpp"
#include "apps/recv/sink_queue.hpp"
#include "core/base/status.hpp"

namespace planecast {

/// What is drawn, row-major, width * height each. Depths in metres, 0 or NaN = no reading.
struct ResultViews {
  std::uint32_t width = 0, height = 0;   ///< [px]
  std::span<const float> original;       ///< empty: not drawn
  std::span<const std::uint8_t> labels;  ///< 0 = on no surface; empty: not drawn
  std::span<const float> regenerated;
  std::string footer;  ///< one line below the pictures
};

/// The pictures with their captions and the scale of the colours.
Picture draw_result(const ResultViews& views);

/// Draws a received frame, with the original where there is a reference (may be null).
/// kWriteFailed.
Result<Done> write_result_picture(const SinkFrame& frame, const ReferenceCheck* reference,
                                  const std::filesystem::path& path);

}  // namespace planecast
