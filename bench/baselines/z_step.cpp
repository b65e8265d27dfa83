// Depth in coarser steps before a lossless image codec: the plain way to trade error for bits that
// every one of them has. Rounded to the nearest multiple, so the error is at most half a step.
#include <fmt/format.h>

#include <algorithm>

#include "bench/baselines/byte_io.hpp"
#include "bench/baselines/depth_baselines.hpp"

namespace planecast::baselines {
namespace {

class ZStep : public DepthBaseline {
 public:
  ZStep(int step, std::unique_ptr<DepthBaseline> inner)
      : DepthBaseline(inner->name(), fmt::format("z step {}", step)),
        step_(static_cast<std::uint32_t>(step)),
        inner_(std::move(inner)) {}

  Bytes encode(const DepthImage& image) const override {
    DepthImage coarse = image;
    for (std::uint16_t& d : coarse.depth) {
      if (d != 0) d = static_cast<std::uint16_t>(std::max((d + step_ / 2) / step_, 1u));
    }
    Bytes out;
    put(out, static_cast<std::uint16_t>(step_));
    const Bytes inner = inner_->encode(coarse);
    out.insert(out.end(), inner.begin(), inner.end());
    return out;
  }

  DepthImage decode(const Bytes& bytes) const override {
    ByteReader reader(bytes);
    const std::uint32_t step = reader.take<std::uint16_t>();
    const auto body = reader.rest();
    DepthImage image = inner_->decode(Bytes(body.begin(), body.end()));
    for (std::uint16_t& d : image.depth)
      d = static_cast<std::uint16_t>(std::min(d * step, 0xffffu));
    return image;
  }

 private:
  std::uint32_t step_;
  std::unique_ptr<DepthBaseline> inner_;
};

}  // namespace

std::unique_ptr<DepthBaseline> z_step(int step, std::unique_ptr<DepthBaseline> inner) {
  return std::make_unique<ZStep>(step, std::move(inner));
}

}  // namespace planecast::baselines
