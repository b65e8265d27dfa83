// RVL (Wilson, "Fast lossless depth image compression", ISS 2017), written anew from the paper:
// runs of holes and of readings by turns; a reading is its difference from the reading before, in
// zigzag; every number goes out in groups of three bits with a bit that says "more", eight such
// nibbles a 32-bit word. Optionally through zstd, as robots' recorders do.
#include <fmt/format.h>

#include "bench/baselines/byte_io.hpp"
#include "bench/baselines/depth_baselines.hpp"

namespace planecast::baselines {
namespace {

class NibbleWriter {
 public:
  explicit NibbleWriter(Bytes& out) : out_(out) {}
  void write(std::uint32_t value) {
    do {
      std::uint32_t nibble = value & 7;
      value >>= 3;
      if (value != 0) nibble |= 8;
      word_ = (word_ << 4) | nibble;
      if (++count_ == 8) flush();
    } while (value != 0);
  }
  void finish() {
    if (count_ == 0) return;
    word_ <<= 4 * (8 - count_);
    flush();
  }

 private:
  void flush() {
    put(out_, word_);
    word_ = 0;
    count_ = 0;
  }
  Bytes& out_;
  std::uint32_t word_ = 0;
  int count_ = 0;
};

class NibbleReader {
 public:
  explicit NibbleReader(ByteReader& in) : in_(in) {}
  std::uint32_t read() {
    std::uint32_t value = 0, nibble = 8;
    for (int shift = 0; (nibble & 8) != 0 && shift < 32; shift += 3) {
      if (count_ == 0) {
        word_ = in_.take<std::uint32_t>();
        count_ = 8;
      }
      nibble = word_ >> 28;
      word_ <<= 4;
      --count_;
      value |= (nibble & 7) << shift;
    }
    return value;
  }

 private:
  ByteReader& in_;
  std::uint32_t word_ = 0;
  int count_ = 0;
};

class Rvl : public DepthBaseline {
 public:
  explicit Rvl(int zstd_level)
      : DepthBaseline(zstd_level == 0 ? "RVL" : fmt::format("RVL+zstd-{}", zstd_level), "lossless"),
        zstd_level_(zstd_level) {}

  Bytes encode(const DepthImage& image) const override {
    Bytes out;
    out.reserve(image.depth.size());
    put(out, image.width);
    put(out, image.height);
    NibbleWriter nibbles(out);
    std::int32_t before = 0;
    const std::uint16_t *p = image.depth.data(), *const end = p + image.depth.size();
    while (p != end) {
      const std::uint16_t* start = p;
      while (p != end && *p == 0) ++p;
      nibbles.write(static_cast<std::uint32_t>(p - start));
      for (start = p; p != end && *p != 0;) ++p;
      nibbles.write(static_cast<std::uint32_t>(p - start));
      for (; start != p; ++start) {
        const std::int32_t delta = *start - before;
        nibbles.write(static_cast<std::uint32_t>((delta << 1) ^ (delta >> 31)));
        before = *start;
      }
    }
    nibbles.finish();
    return zstd_level_ == 0 ? out : compress(ByteCoder::kZstd, zstd_level_, out);
  }

  DepthImage decode(const Bytes& bytes) const override {
    const Bytes inner = zstd_level_ == 0 ? Bytes{} : decompress(ByteCoder::kZstd, bytes);
    ByteReader reader(zstd_level_ == 0 ? bytes : inner);
    DepthImage image;
    image.width = reader.take<std::uint32_t>();
    image.height = reader.take<std::uint32_t>();
    if (image.width > kMaxImageSide || image.height > kMaxImageSide) fail(name(), "wrong size");
    image.depth.assign(std::size_t{image.width} * image.height, 0);
    NibbleReader nibbles(reader);
    std::size_t i = 0;
    std::int32_t before = 0;
    while (i < image.depth.size()) {
      i += nibbles.read();
      const std::size_t end = i + nibbles.read();
      if (end > image.depth.size()) fail(name(), "a run leaves the image");
      for (; i < end; ++i) {
        const std::uint32_t z = nibbles.read();
        before += static_cast<std::int32_t>(z >> 1) ^ -static_cast<std::int32_t>(z & 1);
        image.depth[i] = static_cast<std::uint16_t>(before);
      }
    }
    return image;
  }

 private:
  int zstd_level_;
};

}  // namespace

std::unique_ptr<DepthBaseline> rvl(int zstd_level) {
  return std::make_unique<Rvl>(zstd_level);
}

}  // namespace planecast::baselines
