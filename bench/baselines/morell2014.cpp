// Morell, Orts, Cazorla, Garcia-Rodriguez, "Geometric 3D point cloud compression" (Pattern Recogn.
// Lett. 50, 2014), as read here: planes are found, their points triangulated in the plane, each
// triangle keeps how many points it stands for, the decoder spreads as many over it; points on no
// plane are kept as they are. The paper's comparison has k = 5 and k = 1 without saying what k is;
// here it is the mean number of points that a triangle stands for, which keeps more points as
// vertices for k = 1, as the figures there do. Left out: colour segmentation.
#include <fmt/format.h>

#include <cmath>

#include "bench/baselines/point_baselines.hpp"
#include "bench/baselines/triangle_planes.hpp"

namespace planecast::baselines {
namespace {

class Morell2014 : public PointBaseline {
 public:
  explicit Morell2014(int k) : PointBaseline("Morell 2014", fmt::format("k = {}", k)), k_(k) {}

  Bytes encode(const PointList& points) const override {
    return encode_triangles(points, [this](const auto& members) {
      // A mesh has about two triangles a vertex. Halve the pitch until it has as many vertices as
      // are wanted, then find the pitch between.
      const double wanted = static_cast<double>(members.size()) / (2.0 * k_);
      double high = 1e-6;
      for (const auto& p : members) high = std::max(high, p.cwiseAbs().maxCoeff() * 2);
      double low = high / 2;
      while (low > high * 1e-9 && static_cast<double>(vertices_at(members, low)) < wanted) low /= 2;
      high = low * 2;
      for (int i = 0; i < 6; ++i) {
        const double middle = std::sqrt(low * high);
        (static_cast<double>(vertices_at(members, middle)) < wanted ? high : low) = middle;
      }
      return low;
    });
  }

  PointList decode(const Bytes& bytes) const override { return decode_triangles(bytes); }

 private:
  int k_;
};

}  // namespace

std::unique_ptr<PointBaseline> morell2014(int k) {
  return std::make_unique<Morell2014>(k);
}

}  // namespace planecast::baselines
