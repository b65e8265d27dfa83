// Finds out whether a sensor says only depths C / (k + offset), as stereo and structured light
// do, from the depth counts that one frame holds. Encoder half, once per stream.
#pragma once

#include <cstdint>
#include <optional>
#include <span>

#include "core/model/stream_config.hpp"

namespace planecast {

/// The lattice of a depth image (counts, 0 = no reading), or nothing when the counts are dense,
/// too few to tell, or explained for less than 99 % of the readings. Deterministic; allocates;
/// about 50 ms, so call it at the start of a stream. Method: coherence of C / depth over C (a
/// Fourier sum over the distinct counts), then intersection of the rounding intervals.
std::optional<Lattice> find_lattice(std::span<const std::uint16_t> depth);

}  // namespace planecast
