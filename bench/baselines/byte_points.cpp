// "Burrows-Wheeler 1994" of the paper's Table 3, read as bzip2 -9 on the points as they lie in
// memory: float32 x, y, z by turns. Lossless, order kept. The other byte compressors likewise.
#include <cstring>

#include "bench/baselines/point_baselines.hpp"

namespace planecast::baselines {
namespace {

class BytePoints : public PointBaseline {
 public:
  BytePoints(ByteCoder coder, int level)
      : PointBaseline(coder == ByteCoder::kBzip2 ? "Burrows-Wheeler 1994" : name_of(coder, level),
                      name_of(coder, level) + " on float32"),
        coder_(coder),
        level_(level) {}

  Bytes encode(const PointList& points) const override {
    const auto* begin = reinterpret_cast<const std::uint8_t*>(points.data());
    return compress(coder_, level_, {begin, points.size() * sizeof(Point3f)});
  }

  PointList decode(const Bytes& bytes) const override {
    const Bytes raw = decompress(coder_, bytes);
    if (raw.size() % sizeof(Point3f) != 0) fail(name(), "bytes are no points");
    PointList points(raw.size() / sizeof(Point3f));
    if (!raw.empty()) std::memcpy(points.data(), raw.data(), raw.size());
    return points;
  }

 private:
  ByteCoder coder_;
  int level_;
};

}  // namespace

std::unique_ptr<PointBaseline> byte_points(ByteCoder coder, int level) {
  return std::make_unique<BytePoints>(coder, level);
}

}  // namespace planecast::baselines
