#include "core/io/depth_png.hpp"

#include <spng.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <memory>
#include <string>
#include <vector>

#include "core/base/bytes.hpp"
#include "core/io/depth_raw.hpp"
#include "core/io/file_bytes.hpp"
#include "core/io/io_error.hpp"

namespace planecast {
namespace {

namespace fs = std::filesystem;
using Context = std::unique_ptr<spng_ctx, decltype(&spng_ctx_free)>;

constexpr std::size_t kHeaderEnd = 33;       // signature, then the whole IHDR chunk
constexpr std::uint64_t kMaxDeflate = 1032;  // what deflate can expand a byte to
constexpr std::size_t kMaxChunk = 1U << 26U;
constexpr std::array<std::uint8_t, 8> kSignature = {0x89, 'P', 'N', 'G', '\r', '\n', 0x1A, '\n'};
constexpr std::string_view kGetAnew = "the file is corrupt or cut short: get it anew";

// Feeds libspng from memory and remembers how far it came: the byte an error names.
struct Feed {
  std::span<const std::uint8_t> file;
  std::size_t offset = 0;
  bool ran_out = false;
};

int feed_bytes(spng_ctx* /*context*/, void* user, void* out, std::size_t length) {
  auto* const feed = static_cast<Feed*>(user);
  if (feed->file.size() - feed->offset < length) {
    feed->offset = feed->file.size();
    feed->ran_out = true;
    return SPNG_IO_EOF;
  }
  std::copy_n(feed->file.data() + feed->offset, length, static_cast<std::uint8_t*>(out));
  feed->offset += length;
  return 0;
}

std::string kind_name(unsigned bit_depth, unsigned color_type) {
  const auto color = [color_type]() -> std::string {
    switch (color_type) {
      case SPNG_COLOR_TYPE_GRAYSCALE:
        return "grey";
      case SPNG_COLOR_TYPE_TRUECOLOR:
        return "RGB";
      case SPNG_COLOR_TYPE_INDEXED:
        return "palette";
      case SPNG_COLOR_TYPE_GRAYSCALE_ALPHA:
        return "grey with alpha";
      case SPNG_COLOR_TYPE_TRUECOLOR_ALPHA:
        return "RGB with alpha";
      default:
        return "unknown colour type " + std::to_string(color_type);
    }
  };
  return std::to_string(bit_depth) + "-bit " + color();
}

// Looks at the header before libspng does: its own messages do not say what the file holds.
Result<Done> check_header(const fs::path& path, std::span<const std::uint8_t> file) {
  if (file.size() < kSignature.size() ||
      !std::equal(kSignature.begin(), kSignature.end(), file.begin())) {
    return file_error(path, at_byte(0), "the PNG signature is missing",
                      "check that this is a PNG file");
  }
  if (file.size() < kHeaderEnd) {
    return file_error(path, at_byte(file.size()), "the file ends in its header", kGetAnew);
  }
  const auto width = load_be<std::uint32_t>(file.data() + 16);
  const auto height = load_be<std::uint32_t>(file.data() + 20);
  const std::string size = std::to_string(width) + " x " + std::to_string(height);
  if (width == 0 || height == 0) {
    return file_error(path, at_byte(16), "the image is " + size + " pixels", kGetAnew);
  }
  if (width > kMaxImageSide || height > kMaxImageSide) {
    return file_error(path, at_byte(16),
                      "the image is " + size + " pixels, more than the limit of 16384 a side",
                      "cut it into smaller images");
  }
  if (file[24] != 16 || file[25] != SPNG_COLOR_TYPE_GRAYSCALE) {
    return file_error(path, at_byte(24),
                      "the image is " + kind_name(file[24], file[25]) + ", depth is 16-bit grey",
                      "save the sensor's raw depth (16-bit, one channel), not a picture of it");
  }
  if (std::size_t{width} * height * 2 > file.size() * kMaxDeflate) {
    return file_error(path, at_byte(file.size()), "the file is too short for " + size + " pixels",
                      kGetAnew);
  }
  return Done{};
}

// Everything up to the end of IEND is read and checked, also after the last row.
int decode(spng_ctx* context, DepthImage& image) {
  spng_ihdr header{};
  std::size_t bytes = 0;
  if (const int code = spng_get_ihdr(context, &header)) return code;
  if (const int code = spng_decoded_image_size(context, SPNG_FMT_PNG, &bytes)) return code;
  image.width = header.width;
  image.height = header.height;
  image.depth.resize(std::size_t{header.width} * header.height);
  if (bytes != image.depth.size() * sizeof(std::uint16_t)) return SPNG_EBUFSIZ;
  if (const int code = spng_decode_image(context, image.depth.data(), bytes, SPNG_FMT_PNG, 0)) {
    return code;
  }
  return spng_decode_chunks(context);
}

struct Picture {
  std::uint32_t width;
  std::uint32_t height;
  std::uint8_t bit_depth;
  std::uint8_t color_type;
  std::size_t samples_expected;
  std::size_t samples;
  const void* pixels;
};

Result<Done> write_png(const fs::path& path, const Picture& p) {
  if (p.width == 0 || p.height == 0 || p.width > kMaxImageSide || p.height > kMaxImageSide ||
      p.samples != p.samples_expected) {
    return file_error(path, "", "the image is empty, over 16384 a side, or not width x height",
                      "give a full image", Status::kUsage);
  }
  const auto failed = [&path](int code) {
    return file_error(path, "", std::string("PNG encoding failed (") + spng_strerror(code) + ")",
                      "free memory and try again", Status::kWriteFailed);
  };
  const Context context(spng_ctx_new(SPNG_CTX_ENCODER), &spng_ctx_free);
  if (!context) return failed(SPNG_EMEM);
  spng_ihdr header{};
  header.width = p.width;
  header.height = p.height;
  header.bit_depth = p.bit_depth;
  header.color_type = p.color_type;
  const std::size_t bytes = p.samples * (p.bit_depth / 8U);
  int code = spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1);
  if (code == 0) code = spng_set_ihdr(context.get(), &header);
  if (code == 0) {
    code = spng_encode_image(context.get(), p.pixels, bytes, SPNG_FMT_PNG, SPNG_ENCODE_FINALIZE);
  }
  if (code != 0) return failed(code);
  std::size_t length = 0;
  const std::unique_ptr<void, decltype(&std::free)> buffer(
      spng_get_png_buffer(context.get(), &length, &code), &std::free);
  if (!buffer || code != 0) return failed(code);
  return write_file_bytes(path, {static_cast<const std::uint8_t*>(buffer.get()), length});
}

}  // namespace

Result<DepthImage> read_depth_png(const fs::path& path) {
  const auto file = read_file_bytes(path);
  if (!file) return file.error();
  return parse_depth_png(path, *file);
}

Result<DepthImage> parse_depth_png(const fs::path& path, std::span<const std::uint8_t> file) {
  const Result<Done> header = check_header(path, file);
  if (!header) return header.error();
  const Context context(spng_ctx_new(0), &spng_ctx_free);
  Feed feed{file};
  int code = context ? 0 : static_cast<int>(SPNG_EMEM);
  if (code == 0) code = spng_set_crc_action(context.get(), SPNG_CRC_ERROR, SPNG_CRC_ERROR);
  if (code == 0) code = spng_set_image_limits(context.get(), kMaxImageSide, kMaxImageSide);
  if (code == 0) code = spng_set_chunk_limits(context.get(), kMaxChunk, kMaxChunk);
  if (code == 0) code = spng_set_png_stream(context.get(), &feed_bytes, &feed);
  DepthImage image;
  if (code == 0) code = decode(context.get(), image);
  if (code == 0 && feed.ran_out) code = SPNG_EOF;  // libspng forgives a cut in the last chunk
  if (code != 0) {
    const char* const what = feed.ran_out ? "the file ends too early" : spng_strerror(code);
    return file_error(path, at_byte(feed.offset), what, kGetAnew);
  }
  return image;
}

Result<Done> write_depth_png(const fs::path& path, const DepthImage& image) {
  return write_png(
      path, {image.width, image.height, 16, SPNG_COLOR_TYPE_GRAYSCALE,
             std::size_t{image.width} * image.height, image.depth.size(), image.depth.data()});
}

Result<Done> write_rgb_png(const fs::path& path, std::uint32_t width, std::uint32_t height,
                           std::span<const std::uint8_t> rgb) {
  return write_png(path, {width, height, 8, SPNG_COLOR_TYPE_TRUECOLOR,
                          std::size_t{width} * height * 3, rgb.size(), rgb.data()});
}

}  // namespace planecast
