#include "core/io/depth_raw.hpp"

#include <string>
#include <vector>

#include "core/base/bytes.hpp"
#include "core/io/file_bytes.hpp"
#include "core/io/io_error.hpp"

namespace planecast {
namespace {

std::string size_text(std::uint32_t width, std::uint32_t height) {
  return std::to_string(width) + "x" + std::to_string(height);
}

bool side_is_good(std::uint32_t side) noexcept {
  return side >= 1 && side <= kMaxImageSide;
}

}  // namespace

Result<DepthImage> read_depth_raw(const std::filesystem::path& path, std::uint32_t width,
                                  std::uint32_t height) {
  if (!side_is_good(width) || !side_is_good(height)) {
    return file_error(path, "", "the size " + size_text(width, height) + " is out of range",
                      "give the image's size, 1 to 16384 pixels a side, e.g. --size 640x480",
                      Status::kUsage);
  }
  const auto file = read_file_bytes(path);
  if (!file) return file.error();
  const std::size_t expected = std::size_t{width} * height * 2;
  if (file->size() != expected) {
    return file_error(path, "",
                      "expected " + std::to_string(expected) + " bytes for " +
                          size_text(width, height) + " 16-bit values, found " +
                          std::to_string(file->size()),
                      "correct --size, or get the file anew");
  }
  DepthImage image{width, height, std::vector<std::uint16_t>(expected / 2)};
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    image.depth[i] = load_le<std::uint16_t>(file->data() + 2 * i);
  }
  return image;
}

Result<Done> write_depth_raw(const std::filesystem::path& path, const DepthImage& image) {
  if (std::size_t{image.width} * image.height != image.depth.size()) {
    return file_error(path, "", "the image's width x height is not its number of values",
                      "set width and height before writing", Status::kUsage);
  }
  std::vector<std::uint8_t> bytes(image.depth.size() * 2);
  for (std::size_t i = 0; i < image.depth.size(); ++i) {
    store_le(bytes.data() + 2 * i, image.depth[i]);
  }
  return write_file_bytes(path, bytes);
}

}  // namespace planecast
