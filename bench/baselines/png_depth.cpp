// 16-bit grey PNG by libspng: what image_transport's compressedDepth sends by default. Filters are
// chosen row by row, zlib's level is the setting.
#include <fmt/format.h>
#include <spng.h>

#include <cstdlib>
#include <memory>

#include "bench/baselines/byte_io.hpp"
#include "bench/baselines/depth_baselines.hpp"

namespace planecast::baselines {
namespace {

struct Free {
  void operator()(spng_ctx* c) const { spng_ctx_free(c); }
  void operator()(void* p) const { std::free(p); }
};
using Context = std::unique_ptr<spng_ctx, Free>;

class PngDepth : public DepthBaseline {
 public:
  explicit PngDepth(int level)
      : DepthBaseline(fmt::format("PNG-{}", level), "lossless"), level_(level) {}

  Bytes encode(const DepthImage& image) const override {
    const Context png(spng_ctx_new(SPNG_CTX_ENCODER));
    check(spng_set_option(png.get(), SPNG_ENCODE_TO_BUFFER, 1));
    check(spng_set_option(png.get(), SPNG_IMG_COMPRESSION_LEVEL, level_));
    spng_ihdr header{image.width, image.height, 16, SPNG_COLOR_TYPE_GRAYSCALE, 0, 0, 0};
    check(spng_set_ihdr(png.get(), &header));
    check(spng_encode_image(png.get(), image.depth.data(), image.depth.size() * 2, SPNG_FMT_PNG,
                            SPNG_ENCODE_FINALIZE));
    std::size_t size = 0;
    int error = 0;
    const std::unique_ptr<void, Free> data(spng_get_png_buffer(png.get(), &size, &error));
    check(error);
    const auto* begin = static_cast<const std::uint8_t*>(data.get());
    return Bytes(begin, begin + size);
  }

  DepthImage decode(const Bytes& bytes) const override {
    const Context png(spng_ctx_new(0));
    check(spng_set_png_buffer(png.get(), bytes.data(), bytes.size()));
    spng_ihdr header{};
    check(spng_get_ihdr(png.get(), &header));
    DepthImage image{header.width, header.height, {}};
    image.depth.resize(std::size_t{image.width} * image.height);
    check(
        spng_decode_image(png.get(), image.depth.data(), image.depth.size() * 2, SPNG_FMT_RAW, 0));
    // SPNG_FMT_RAW is big-endian, as the file is.
    for (std::uint16_t& d : image.depth) d = static_cast<std::uint16_t>((d << 8) | (d >> 8));
    return image;
  }

 private:
  void check(int error) const {
    if (error != 0) fail(name(), spng_strerror(error));
  }
  int level_;
};

}  // namespace

std::unique_ptr<DepthBaseline> png_depth(int zlib_level) {
  return std::make_unique<PngDepth>(zlib_level);
}

}  // namespace planecast::baselines
