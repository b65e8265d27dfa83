// A frame as transport assembled it, as the decoder takes it.
#pragma once

#include "core/pipeline/decoder.hpp"
#include "transport/assembled_frame.hpp"

namespace planecast {

/// Valid as long as `frame`.
inline SliceList slices_of(const AssembledFrame& frame) noexcept {
  return {&frame, frame.slice_count, [](const void* self, std::uint32_t i) noexcept {
            return static_cast<const AssembledFrame*>(self)->slice(static_cast<std::uint16_t>(i));
          }};
}

}  // namespace planecast
