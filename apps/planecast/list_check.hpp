// A list of points against its reconstruction, which has no order: by nearest points, both ways.
#pragma once

#include <span>

#include "apps/common/frame_codec.hpp"
#include "apps/planecast/frame_check.hpp"

namespace planecast {

/// The list as it is to come back, after --range.
OriginalFrame original_list(const CodedList& list);

/// Compares a decoded list with what the encoder was given and says it did with each point.
/// Lossless: the same points, each as often. Metres and sigma: as many points as were not dropped,
/// each of those that were coded with one that came back within the bound, and the other way round.
/// Surfaces: the same for the points coded as themselves; as many others as lie on surfaces.
/// O(n log n).
FrameVerdict check_list(const StreamSetup& setup, const CodedList& list,
                        std::span<const Point3f> decoded);

}  // namespace planecast
