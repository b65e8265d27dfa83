// "DT2016" of the paper's comparison (Navarrete et al., "3DCOMET", Robot. Auton. Syst. 75, 2016),
// as read here: Delaunay triangles over planes again, with vertices a fixed distance apart whatever
// the density of points, as a mesh of walls would have them. What exactly was run is not known.
#include <fmt/format.h>

#include "bench/baselines/point_baselines.hpp"
#include "bench/baselines/triangle_planes.hpp"

namespace planecast::baselines {
namespace {

class Dt2016 : public PointBaseline {
 public:
  explicit Dt2016(double pitch_m)
      : PointBaseline("DT2016", fmt::format("vertices {:.3g} m apart", pitch_m)),
        pitch_m_(pitch_m) {}

  Bytes encode(const PointList& points) const override {
    return encode_triangles(points, [this](const auto&) { return pitch_m_; });
  }
  PointList decode(const Bytes& bytes) const override { return decode_triangles(bytes); }

 private:
  double pitch_m_;
};

}  // namespace

std::unique_ptr<PointBaseline> dt2016(double pitch_m) {
  return std::make_unique<Dt2016>(pitch_m);
}

}  // namespace planecast::baselines
