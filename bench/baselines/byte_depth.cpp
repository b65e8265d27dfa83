// zstd, bzip2 (the paper's "Burrows-Wheeler 1994" on images) and xz on the depth image as it lies
// in memory: width, height, then 16-bit counts, row by row. What a recorder without a depth codec
// does; good on stereo and structured light, whose few levels repeat.
#include <cstring>

#include "bench/baselines/byte_io.hpp"
#include "bench/baselines/depth_baselines.hpp"

namespace planecast::baselines {
namespace {

class ByteDepth : public DepthBaseline {
 public:
  ByteDepth(ByteCoder coder, int level)
      : DepthBaseline(name_of(coder, level), "lossless"), coder_(coder), level_(level) {}

  Bytes encode(const DepthImage& image) const override {
    Bytes raw;
    put(raw, image.width);
    put(raw, image.height);
    const std::size_t at = raw.size(), bytes = image.depth.size() * 2;
    raw.resize(at + bytes);
    std::memcpy(raw.data() + at, image.depth.data(), bytes);
    return compress(coder_, level_, raw);
  }

  DepthImage decode(const Bytes& bytes) const override {
    const Bytes raw = decompress(coder_, bytes);
    ByteReader reader(raw);
    DepthImage image;
    image.width = reader.take<std::uint32_t>();
    image.height = reader.take<std::uint32_t>();
    const auto counts = reader.rest();
    if (counts.size() != std::size_t{image.width} * image.height * 2) fail(name(), "wrong size");
    image.depth.resize(counts.size() / 2);
    std::memcpy(image.depth.data(), counts.data(), counts.size());
    return image;
  }

 private:
  ByteCoder coder_;
  int level_;
};

}  // namespace

std::unique_ptr<DepthBaseline> byte_depth(ByteCoder coder, int level) {
  return std::make_unique<ByteDepth>(coder, level);
}

}  // namespace planecast::baselines
