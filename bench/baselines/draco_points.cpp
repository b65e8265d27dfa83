// Draco, the point-cloud codec most robots can name: coordinates rounded to so many bits of the
// bounding box, then a kd-tree of point counts (order lost) or differences in order (sequential),
// entropy-coded. Every point comes back, many on the same spot. Its setting is bits, not metres.
#include "bench/baselines/point_baselines.hpp"

#ifdef PLANECAST_HAVE_DRACO
#include <draco/compression/decode.h>
#include <draco/compression/encode.h>
#include <draco/point_cloud/point_cloud_builder.h>
#include <fmt/format.h>

namespace planecast::baselines {
namespace {

class DracoPoints : public PointBaseline {
 public:
  DracoPoints(bool kd_tree, int level, int bits)
      : PointBaseline(fmt::format("Draco {} cl{}", kd_tree ? "kd" : "sequential", level),
                      fmt::format("qp {}", bits)),
        kd_tree_(kd_tree),
        level_(level),
        bits_(bits) {}

  Bytes encode(const PointList& points) const override {
    draco::PointCloudBuilder builder;
    builder.Start(static_cast<draco::PointIndex::ValueType>(points.size()));
    const int position =
        builder.AddAttribute(draco::GeometryAttribute::POSITION, 3, draco::DT_FLOAT32);
    builder.SetAttributeValuesForAllPoints(position, points.data(), sizeof(Point3f));
    const std::unique_ptr<draco::PointCloud> cloud = builder.Finalize(false);
    draco::Encoder encoder;
    encoder.SetSpeedOptions(10 - level_, 10 - level_);
    encoder.SetAttributeQuantization(draco::GeometryAttribute::POSITION, bits_);
    encoder.SetEncodingMethod(kd_tree_ ? draco::POINT_CLOUD_KD_TREE_ENCODING
                                       : draco::POINT_CLOUD_SEQUENTIAL_ENCODING);
    draco::EncoderBuffer buffer;
    const draco::Status status = encoder.EncodePointCloudToBuffer(*cloud, &buffer);
    if (!status.ok()) fail(name(), status.error_msg());
    return Bytes(buffer.data(), buffer.data() + buffer.size());
  }

  PointList decode(const Bytes& bytes) const override {
    draco::DecoderBuffer buffer;
    buffer.Init(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    draco::Decoder decoder;
    auto decoded = decoder.DecodePointCloudFromBuffer(&buffer);
    if (!decoded.ok()) fail(name(), decoded.status().error_msg());
    const draco::PointCloud& cloud = *decoded.value();
    const auto* position = cloud.GetNamedAttribute(draco::GeometryAttribute::POSITION);
    PointList points(cloud.num_points());
    for (draco::PointIndex i(0); i < cloud.num_points(); ++i)
      position->GetMappedValue(i, &points[i.value()]);
    return points;
  }

 private:
  bool kd_tree_;
  int level_, bits_;
};

}  // namespace

std::unique_ptr<PointBaseline> draco_points(bool kd_tree, int level, int quantisation_bits) {
  return std::make_unique<DracoPoints>(kd_tree, level, quantisation_bits);
}
bool draco_available() {
  return true;
}

}  // namespace planecast::baselines

#else

namespace planecast::baselines {
std::unique_ptr<PointBaseline> draco_points(bool, int, int) {
  fail("Draco", "libdraco-dev is missing");
}
bool draco_available() {
  return false;
}
}  // namespace planecast::baselines

#endif
