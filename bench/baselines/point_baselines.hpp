// The point-cloud codecs that the benchmarks compare with, each in the file of its name: Draco, and
// the systems of the paper's Table 3 as far as their papers tell (readings in each file's head).
// All of them return as many points as went in, but Kammerl 2012 with leaves alone; the order may
// change.
#pragma once

#include "bench/baselines/baseline.hpp"
#include "bench/baselines/byte_coders.hpp"

namespace planecast::baselines {

/// Draco (draco_points.cpp). `quantisation_bits` of the bounding box's longest side; `level` 0..10
/// as its tool's -cl. kd-tree: order lost; else sequential: order kept.
std::unique_ptr<PointBaseline> draco_points(bool kd_tree, int level, int quantisation_bits);
bool draco_available();

/// Float32 x, y, z through a byte compressor, "Burrows-Wheeler 1994" with bzip2 (byte_points.cpp).
std::unique_ptr<PointBaseline> byte_points(ByteCoder coder, int level);
/// Schnabel and Klein 2006 with leaves of `cell_m` (octree2006.cpp).
std::unique_ptr<PointBaseline> octree2006(double cell_m);
/// Elseberg, Borrmann, Nuechter 2013 (octree2013.cpp).
std::unique_ptr<PointBaseline> octree2013();
/// Kammerl et al. 2012 by PCL (kammerl2012.cpp): leaves of `cell_m`, points in them in steps of
/// `point_m`; with `voxels` one point a leaf, so that fewer come back.
std::unique_ptr<PointBaseline> kammerl2012(double point_m, double cell_m, bool voxels);
bool kammerl2012_available();
/// Morell et al. 2014, a triangle standing for `k` points (morell2014.cpp).
std::unique_ptr<PointBaseline> morell2014(int k);
/// Delaunay triangles over planes, after Navarrete et al. 2016, vertices `pitch_m` apart
/// (dt2016.cpp).
std::unique_ptr<PointBaseline> dt2016(double pitch_m);
/// Navarrete, Viejo, Cazorla 2018: Gaussian mixtures (gmm2018.cpp).
std::unique_ptr<PointBaseline> gmm2018();

/// The paper's comparison at the settings of bench/paper; `skipped` takes the names of those whose
/// library was not there (point_set.cpp).
PointBaselines point_set(std::vector<std::string>& skipped);

}  // namespace planecast::baselines
