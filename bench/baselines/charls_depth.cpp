// JPEG-LS by CharLS (ISO 14495-1): median edge prediction, Golomb codes by context, runs; near-
// lossless keeps every sample within NEAR. Readings are raised by 2 NEAR before coding, so that a
// hole (0) and a reading can still be told apart afterwards.
#include "bench/baselines/depth_baselines.hpp"

#ifdef PLANECAST_HAVE_CHARLS
#include <charls/charls.h>
#include <fmt/format.h>

#include <algorithm>

#include "bench/baselines/byte_io.hpp"

namespace planecast::baselines {
namespace {

class CharlsDepth : public DepthBaseline {
 public:
  explicit CharlsDepth(int near)
      : DepthBaseline("CharLS", near == 0 ? "lossless" : fmt::format("near {}", near)),
        near_(static_cast<std::uint32_t>(near)) {}

  Bytes encode(const DepthImage& image) const override {
    DepthImage raised = image;
    for (std::uint16_t& d : raised.depth) {
      if (d == 0) continue;
      if (d + 2 * near_ > 0xffff) fail(name(), "depth over 65535 - 2 near");
      d = static_cast<std::uint16_t>(d + 2 * near_);
    }
    const std::uint32_t most = *std::max_element(raised.depth.begin(), raised.depth.end());
    int bits = 9;  // eight and fewer would be coded from bytes
    while (bits < 16 && (most >> bits) != 0) ++bits;
    charls::jpegls_encoder encoder;
    encoder.frame_info({image.width, image.height, bits, 1}).near_lossless(int(near_));
    Bytes out(encoder.estimated_destination_size());
    encoder.destination(out);
    out.resize(encoder.encode(raised.depth));
    return out;
  }

  DepthImage decode(const Bytes& bytes) const override {
    charls::jpegls_decoder decoder(bytes, true);
    DepthImage image{decoder.frame_info().width, decoder.frame_info().height, {}};
    image.depth.resize(std::size_t{image.width} * image.height);
    if (decoder.destination_size() != image.depth.size() * 2) fail(name(), "wrong size");
    decoder.decode(image.depth);
    const auto near = static_cast<std::uint32_t>(decoder.near_lossless());
    for (std::uint16_t& d : image.depth) {
      if (d <= near) {
        d = 0;
      } else {
        d = static_cast<std::uint16_t>(std::max<std::int64_t>(std::int64_t{d} - 2 * near, 1));
      }
    }
    return image;
  }

 private:
  std::uint32_t near_;
};

}  // namespace

std::unique_ptr<DepthBaseline> charls_depth(int near) {
  return std::make_unique<CharlsDepth>(near);
}
bool charls_available() {
  return true;
}

}  // namespace planecast::baselines

#else

namespace planecast::baselines {
std::unique_ptr<DepthBaseline> charls_depth(int) {
  fail("CharLS", "libcharls-dev is missing");
}
bool charls_available() {
  return false;
}
}  // namespace planecast::baselines

#endif
