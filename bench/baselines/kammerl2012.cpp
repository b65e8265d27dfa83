// Kammerl, Blodow, Rusu, Gedikli, Beetz, Steinbach, "Real-time compression of point cloud streams"
// (ICRA 2012): PCL's own codec, which is theirs. An octree whose occupancy bytes go through a range
// coder (of a single frame: no difference to the frame before), with, but for `voxels`, a point's
// place in its leaf at a finer step. Leaves alone come back as one point each.
#include "bench/baselines/point_baselines.hpp"

#ifdef PLANECAST_HAVE_PCL
#include <fmt/format.h>
#include <pcl/compression/octree_pointcloud_compression.h>

#include <sstream>

namespace planecast::baselines {
namespace {

class Kammerl2012 : public PointBaseline {
 public:
  Kammerl2012(double point_m, double cell_m, bool voxels)
      : PointBaseline("Kammerl 2012", voxels ? fmt::format("leaves {} mm alone", cell_m * 1e3)
                                             : fmt::format("points {} mm in leaves of {} mm",
                                                           point_m * 1e3, cell_m * 1e3)),
        point_m_(point_m),
        cell_m_(cell_m),
        voxels_(voxels) {}

  Bytes encode(const PointList& points) const override {
    const Cloud::Ptr cloud(new Cloud);
    for (const Point3f& p : points) cloud->push_back(pcl::PointXYZ(p.x, p.y, p.z));
    std::ostringstream out;
    if (!points.empty()) codec()->encodePointCloud(cloud, out);
    const std::string text = out.str();
    return Bytes(text.begin(), text.end());
  }

  PointList decode(const Bytes& bytes) const override {
    PointList points;
    if (bytes.empty()) return points;
    std::istringstream in(std::string(bytes.begin(), bytes.end()));
    Cloud::Ptr cloud(new Cloud);
    codec()->decodePointCloud(in, cloud);
    for (const pcl::PointXYZ& p : *cloud) points.push_back({p.x, p.y, p.z});
    return points;
  }

 private:
  using Cloud = pcl::PointCloud<pcl::PointXYZ>;
  using Codec = pcl::io::OctreePointCloudCompression<pcl::PointXYZ>;

  // A new one a frame: it keeps what it saw before.
  std::unique_ptr<Codec> codec() const {
    return std::make_unique<Codec>(pcl::io::MANUAL_CONFIGURATION, false, point_m_, cell_m_, voxels_,
                                   1, false);
  }

  double point_m_, cell_m_;
  bool voxels_;
};

}  // namespace

std::unique_ptr<PointBaseline> kammerl2012(double point_m, double cell_m, bool voxels) {
  return std::make_unique<Kammerl2012>(point_m, cell_m, voxels);
}
bool kammerl2012_available() {
  return true;
}

}  // namespace planecast::baselines

#else

namespace planecast::baselines {
std::unique_ptr<PointBaseline> kammerl2012(double, double, bool) {
  fail("Kammerl 2012", "libpcl-dev is missing");
}
bool kammerl2012_available() {
  return false;
}
}  // namespace planecast::baselines

#endif
