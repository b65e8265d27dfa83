// The image codecs that the depth benchmarks compare with, each in the file of its name, and the
// two ways to put something before them: coarser steps of depth, and the index on the lattice.
#pragma once

#include "bench/baselines/baseline.hpp"
#include "bench/baselines/byte_coders.hpp"

namespace planecast::baselines {

/// Depth as little-endian u16, row-major, through a byte compressor (byte_depth.cpp).
std::unique_ptr<DepthBaseline> byte_depth(ByteCoder coder, int level);
/// RVL (rvl.cpp); `zstd_level` 0: alone, else through zstd.
std::unique_ptr<DepthBaseline> rvl(int zstd_level);
/// 16-bit grey PNG by libspng (png_depth.cpp).
std::unique_ptr<DepthBaseline> png_depth(int zlib_level);
/// JPEG-LS by CharLS, no depth further than `near` counts off (charls_depth.cpp).
std::unique_ptr<DepthBaseline> charls_depth(int near);
bool charls_available();
/// JPEG 2000 by OpenJPEG, lossless (jpeg2000_depth.cpp).
std::unique_ptr<DepthBaseline> jpeg2000_depth();
bool jpeg2000_available();

/// Depth rounded to multiples of `step` counts before `inner`, which sees the multiple; no reading
/// becomes a hole (z_step.cpp).
std::unique_ptr<DepthBaseline> z_step(int step, std::unique_ptr<DepthBaseline> inner);
/// `inner` sees 1 + the rank of a depth among the frame's different depths, and the table of these
/// travels in front (lattice_index.cpp).
std::unique_ptr<DepthBaseline> lattice_index(std::unique_ptr<DepthBaseline> inner);

/// Everything above at the settings of the benchmark, `skipped` taking the names of the codecs
/// whose library was not there (depth_set.cpp).
DepthBaselines depth_set(std::vector<std::string>& skipped);

}  // namespace planecast::baselines
