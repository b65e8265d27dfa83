// A mutated PNG nearly always fails its check sums. So each input is read twice: as it is, and with
// the check sum of every chunk put right.
#include <vector>

#include "core/base/bytes.hpp"
#include "core/io/depth_png.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace {

using namespace planecast;

std::uint32_t crc32(const std::uint8_t* bytes, std::size_t size) {
  std::uint32_t value = 0xffffffffU;
  for (std::size_t i = 0; i < size; ++i) {
    value ^= bytes[i];
    for (int bit = 0; bit < 8; ++bit) value = (value >> 1U) ^ ((value & 1U) * 0xedb88320U);
  }
  return ~value;
}

// Chunks: length u32, type 4 bytes, content, check sum u32 over type and content; big-endian.
void put_checks_right(std::vector<std::uint8_t>& file) {
  for (std::size_t at = 8; at + 12 <= file.size();) {
    const std::size_t length = load_be<std::uint32_t>(&file[at]);
    if (length > file.size() - at - 12) return;
    store_be<std::uint32_t>(&file[at + 8 + length], crc32(&file[at + 4], length + 4));
    at += length + 12;
  }
}

void read(std::span<const std::uint8_t> file) {
  const auto image = parse_depth_png("input", file);
  if (!image.ok()) return;
  test::claim(image->depth.size() == std::size_t{image->width} * image->height,
              "pixels fill the image");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  read({data, size});
  std::vector<std::uint8_t> file(data, data + size);
  put_checks_right(file);
  read(file);
  return 0;
}
