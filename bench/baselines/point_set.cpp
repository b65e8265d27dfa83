#include "bench/baselines/point_baselines.hpp"

namespace planecast::baselines {

PointBaselines point_set(std::vector<std::string>& skipped) {
  PointBaselines set;
  if (available(ByteCoder::kBzip2)) {
    set.push_back(byte_points(ByteCoder::kBzip2, 9));
  } else {
    skipped.emplace_back("Burrows-Wheeler 1994 (libbz2-dev)");
  }
  for (const double cell_m : {0.01, 0.002}) set.push_back(octree2006(cell_m));
  set.push_back(octree2013());
  if (kammerl2012_available()) {
    set.push_back(kammerl2012(0.001, 0.01, false));
    for (const double cell_m : {0.01, 0.002}) set.push_back(kammerl2012(cell_m, cell_m, true));
  } else {
    skipped.emplace_back("Kammerl 2012 (PCL's own codec: libpcl-dev, toolchains/setup.sh --pcl)");
  }
  for (const int k : {5, 1}) set.push_back(morell2014(k));
  set.push_back(dt2016(0.1));
  set.push_back(gmm2018());
  if (draco_available()) {
    for (const int bits : {9, 11}) set.push_back(draco_points(true, 7, bits));
  } else {
    skipped.emplace_back("Draco (libdraco-dev)");
  }
  return set;
}

}  // namespace planecast::baselines
