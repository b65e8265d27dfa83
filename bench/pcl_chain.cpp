#include "bench/pcl_chain.hpp"

#ifdef PLANECAST_HAVE_PCL
#include <pcl/features/normal_3d.h>
#include <pcl/filters/extract_indices.h>
#include <pcl/filters/project_inliers.h>
#include <pcl/filters/statistical_outlier_removal.h>
#include <pcl/segmentation/region_growing.h>
#include <pcl/segmentation/sac_segmentation.h>
#include <pcl/surface/concave_hull.h>

#include <algorithm>

#include "apps/common/frame_codec.hpp"
#include "core/base/random.hpp"

namespace planecast::bench {
namespace {

using Point = pcl::PointXYZ;
using Cloud = pcl::PointCloud<Point>;
using Normals = pcl::PointCloud<pcl::Normal>;

constexpr int kOutlierNeighbours = 50, kNormalNeighbours = 50, kGrowNeighbours = 30;
constexpr double kDistance_m = 0.01, kAlpha_m = 0.1, kLeastShare = 0.1;
constexpr std::size_t kLeastPoints = 50;

Cloud::Ptr pcl_cloud(const baselines::PointList& points) {
  Cloud::Ptr cloud(new Cloud);
  for (const Point3f& p : points) cloud->push_back(Point(p.x, p.y, p.z));
  return cloud;
}

void append(baselines::PointList& to, const Cloud& from) {
  for (const Point& p : from) to.push_back({p.x, p.y, p.z});
}

struct Outline {
  Cloud corners;
  std::vector<pcl::Vertices> rings;
  std::size_t size() const {
    std::size_t n = 0;
    for (const pcl::Vertices& ring : rings) n += ring.vertices.size();
    return n;
  }
};

Outline outline_of(const Cloud::Ptr& flat, double alpha_m) {
  Outline outline;
  pcl::ConcaveHull<Point> hull;
  hull.setInputCloud(flat);
  hull.setAlpha(alpha_m);
  hull.setDimension(2);
  hull.reconstruct(outline.corners, outline.rings);
  return outline;
}

// Random points inside an outline, `count` of them: each is inside an odd number of rings.
void fill(const Outline& outline, const Eigen::Vector3f& normal, std::size_t count, Pcg32& random,
          baselines::PointList& out) {
  if (outline.rings.empty()) return;
  const Eigen::Vector3f u = normal.unitOrthogonal(), v = normal.cross(u);
  const Eigen::Vector3f zero = outline.corners[outline.rings[0].vertices[0]].getVector3fMap();
  std::vector<std::vector<Eigen::Vector2f>> rings;
  Eigen::Vector2f low(1e9F, 1e9F), high(-1e9F, -1e9F);
  for (const pcl::Vertices& ring : outline.rings) {
    rings.emplace_back();
    for (const auto corner : ring.vertices) {
      const Eigen::Vector3f off = outline.corners[corner].getVector3fMap() - zero;
      rings.back().emplace_back(off.dot(u), off.dot(v));
      low = low.cwiseMin(rings.back().back());
      high = high.cwiseMax(rings.back().back());
    }
  }
  for (std::size_t got = 0, tries = 0; got < count && tries < 1000 * count; ++tries) {
    const Eigen::Vector2f at(low.x() + (high.x() - low.x()) * static_cast<float>(random.uniform()),
                             low.y() + (high.y() - low.y()) * static_cast<float>(random.uniform()));
    bool inside = false;
    for (const auto& ring : rings) {
      for (std::size_t a = 0, b = ring.size() - 1; a < ring.size(); b = a++) {
        const Eigen::Vector2f p = ring[a], q = ring[b];
        if ((p.y() > at.y()) != (q.y() > at.y()) &&
            at.x() < (q.x() - p.x()) * (at.y() - p.y()) / (q.y() - p.y()) + p.x())
          inside = !inside;
      }
    }
    if (!inside) continue;
    const Eigen::Vector3f point = zero + at.x() * u + at.y() * v;
    out.push_back({point.x(), point.y(), point.z()});
    ++got;
  }
}

struct Plane {
  Eigen::Vector3f normal;
  std::size_t points;
  Outline outline;
};

// Planes of one region, while a tenth of its points and fifty are left.
void find_planes(Cloud::Ptr rest, std::vector<Plane>& planes, ChainResult& result) {
  const auto least = static_cast<double>(rest->size()) * kLeastShare;
  while (rest->size() >= kLeastPoints && static_cast<double>(rest->size()) > least) {
    pcl::SACSegmentation<Point> consensus;
    consensus.setOptimizeCoefficients(true);
    consensus.setModelType(pcl::SACMODEL_PLANE);
    consensus.setMethodType(pcl::SAC_RANSAC);
    consensus.setDistanceThreshold(kDistance_m);
    consensus.setInputCloud(rest);
    const pcl::PointIndices::Ptr inliers(new pcl::PointIndices);
    const pcl::ModelCoefficients::Ptr plane(new pcl::ModelCoefficients);
    consensus.segment(*inliers, *plane);
    if (inliers->indices.size() < kLeastPoints) return;
    Cloud::Ptr flat(new Cloud), next(new Cloud);
    pcl::ProjectInliers<Point> project;
    project.setModelType(pcl::SACMODEL_PLANE);
    project.setInputCloud(rest);
    project.setIndices(inliers);
    project.setModelCoefficients(plane);
    project.filter(*flat);
    for (const int i : inliers->indices)
      result.kept_cloud.push_back({(*rest)[i].x, (*rest)[i].y, (*rest)[i].z});
    const Eigen::Vector3f normal(plane->values[0], plane->values[1], plane->values[2]);
    planes.push_back({normal.normalized(), inliers->indices.size(), outline_of(flat, kAlpha_m)});
    pcl::ExtractIndices<Point> others;
    others.setInputCloud(rest);
    others.setIndices(inliers);
    others.setNegative(true);
    others.filter(*next);
    rest = next;
  }
}

}  // namespace

bool pcl_available() {
  return true;
}

std::size_t pcl_hull_corners(const baselines::PointList& points, double alpha_m) {
  return outline_of(pcl_cloud(points), alpha_m).size();
}

ChainResult run_pcl_chain(const baselines::PointList& points) {
  ChainResult result;
  result.points = points.size();
  const Cloud::Ptr all = pcl_cloud(points), filtered(new Cloud);
  const double begin = thread_cpu_ms();
  pcl::StatisticalOutlierRemoval<Point> outliers;
  outliers.setInputCloud(all);
  outliers.setMeanK(kOutlierNeighbours);
  outliers.setStddevMulThresh(1.0);
  outliers.filter(*filtered);
  const pcl::search::KdTree<Point>::Ptr tree(new pcl::search::KdTree<Point>);
  const Normals::Ptr normals(new Normals);
  pcl::NormalEstimation<Point, pcl::Normal> estimate;
  estimate.setInputCloud(filtered);
  estimate.setSearchMethod(tree);
  estimate.setKSearch(kNormalNeighbours);
  estimate.compute(*normals);
  pcl::RegionGrowing<Point, pcl::Normal> grow;
  grow.setMinClusterSize(kLeastPoints);
  grow.setSearchMethod(tree);
  grow.setNumberOfNeighbours(kGrowNeighbours);
  grow.setInputCloud(filtered);
  grow.setInputNormals(normals);
  grow.setSmoothnessThreshold(static_cast<float>(3.0 / 180.0 * M_PI));
  grow.setCurvatureThreshold(1.0F);
  std::vector<pcl::PointIndices> regions;
  grow.extract(regions);
  std::vector<Plane> planes;
  for (const pcl::PointIndices& region : regions) {
    Cloud::Ptr own(new Cloud(*filtered, region.indices));
    result.in_regions += own->size();
    find_planes(own, planes, result);
  }
  result.encode_ms = thread_cpu_ms() - begin;
  append(result.filtered_cloud, *filtered);
  result.filtered = filtered->size();
  result.regions = static_cast<std::uint32_t>(regions.size());
  result.planes = static_cast<std::uint32_t>(planes.size());
  result.in_planes = result.kept_cloud.size();
  Pcg32 random(1);
  for (const Plane& plane : planes) {
    result.hull_points += plane.outline.size();
    fill(plane.outline, plane.normal, plane.points, random, result.random_cloud);
  }
  return result;
}

}  // namespace planecast::bench

#else

namespace planecast::bench {
bool pcl_available() {
  return false;
}
ChainResult run_pcl_chain(const baselines::PointList&) {
  baselines::fail("PCL", "libpcl-dev is missing");
}
std::size_t pcl_hull_corners(const baselines::PointList&, double) {
  baselines::fail("PCL", "libpcl-dev is missing");
}
}  // namespace planecast::bench

#endif
