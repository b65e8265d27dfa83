// The paper's method step by step on a list of points, with everything its tables count: what each
// step keeps, how large each of its files would be, and both clouds that come back.
#pragma once

#include <string>
#include <vector>

#include "bench/baselines/baseline.hpp"
#include "core/model/stream_config.hpp"
#include "core/segment/point_region_growing.hpp"

namespace planecast::bench {

/// Parameters of Algorithm 1, as `--method paper` has them.
struct ChainOptions {
  std::uint32_t k = 30;       ///< neighbours of outlier filter and normals
  std::uint32_t grow_k = 30;  ///< of region growing; the same search where it is k
  double deviations = 1.0;    ///< of the outlier filter
  double smoothness_deg = 3.0;
  CurvatureTest curvature_test = CurvatureTest::kDifference;
  double curvature_limit = 0.05;
  double distance_m = 0.01;    ///< of sample consensus
  double alpha_m = 0.02;       ///< of the hull
  double paper_alpha_m = 0.1;  ///< of the alpha shape whose corners the paper's files would hold
  std::uint32_t min_points = 50;
  std::uint64_t seed = 1;
};

/// The parameters of PCL's tutorials, which the paper most likely used: run_pcl_chain() has them.
ChainOptions pcl_options();

struct ChainResult {
  std::size_t points = 0, filtered = 0, in_regions = 0, in_planes = 0;
  std::uint32_t clusters = 0;           ///< grown, those given up included (the paper's TC)
  std::uint32_t regions = 0;            ///< kept
  std::uint32_t planes = 0;             ///< planes / regions is the paper's PS
  double inter_mm = 0, intra_mm = 0;    ///< mean distances of neighbours across and within regions
  std::size_t hull_points = 0;          ///< corners of the planes' alpha shapes
  std::size_t bytes = 0;                ///< packed, file form
  double encode_ms = 0, decode_ms = 0;  ///< median of 3 runs after a warm-up, thread's CPU
  baselines::PointList filtered_cloud;  ///< after the outlier filter
  baselines::PointList kept_cloud;      ///< on a plane
  baselines::PointList random_cloud, lattice_cloud;  ///< as they come back
};

/// Bytes of the paper's own files: a line of text a boundary point and a plane, or float32.
struct PaperBytes {
  std::size_t hull3 = 0;         ///< 41.3 B a hull point in 3-D, as the paper's file has
  std::size_t hull2 = 0;         ///< 31.9 B a hull point in 2-D
  std::size_t coefficients = 0;  ///< 50 B a plane
  std::size_t float32 = 0;       ///< 8 B a hull point and 20 B a plane
  std::size_t text() const { return hull2 + coefficients; }
};
PaperBytes paper_bytes(const ChainResult& chain);

/// Runs the chain; `timed`: else times are of one run. Throws std::runtime_error.
ChainResult run_chain(const baselines::PointList& points, const ChainOptions& options, bool timed);

}  // namespace planecast::bench
