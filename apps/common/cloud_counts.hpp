// A frame of an organised cloud as counts of its stream's depth grid, each point proven to lie as
// near to its count's own point as the stream's setup allows.
#pragma once

#include <cstdint>
#include <vector>

#include "apps/common/stream_setup.hpp"

namespace planecast {

/// Whether points are held against the counts they get.
enum class Proof : std::uint8_t { kNone, kMisfit };

/// Counts a cloud of the stream's size: depth[i] of pixel i, 0 for a hole; a reading outside the
/// range limits gets a count outside them, for the filter to see. Takes memory only until `depth`
/// has its size. With kMisfit, kBoundExceeded names the first point that has no count, or lies
/// further from its count's point than `setup.allowed_share` of its bound (2 um when lossless);
/// with kNone, only the first that has no count. O(n), about 6 ns a point.
Result<Done> count_cloud(const StreamSetup& setup, const SensorFrame& frame, Proof proof,
                         std::vector<std::uint16_t>& depth);

}  // namespace planecast
