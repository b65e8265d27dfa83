// The least sender that a board needs: an encoder in memory that the program gives, on the caller's
// thread, and the packets it makes. Encodes a room of integers and prints what it takes by size.
//   board_encode            one line a size: width, height, encoder bytes, decoder bytes, packed
//   bytes
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "core/pipeline/decoder.hpp"
#include "core/pipeline/encoder.hpp"

namespace {

using namespace planecast;

constexpr std::uint32_t kSlots = 4;

EncoderConfig settings(std::uint32_t width, std::uint32_t height) {
  Intrinsics intrinsics;
  intrinsics.fx = intrinsics.fy = width * 0.9;
  intrinsics.cx = width / 2.0;
  intrinsics.cy = height / 2.0;
  EncoderConfig config;
  const auto camera = quantise(intrinsics, width, height);
  if (!camera.ok()) std::abort();
  config.stream.camera = *camera;
  config.stream.tolerance = ToleranceKind::kMetres;
  config.stream.tolerance_100nm = 100'000;  // 10 mm
  config.runner.slots = kSlots;
  config.runner.mode = RunMode::kInline;
  return config;
}

/// Floor, wall and a box in front of it, with a little noise [mm].
void render(std::span<std::uint16_t> depth, std::uint32_t width, std::uint32_t height) {
  std::uint32_t random = 1;
  for (std::uint32_t i = 0; i < depth.size(); ++i) {
    const std::uint32_t u = i % width, v = i / width;
    std::uint32_t z = 3000;
    if (2 * v > height) z = std::min(z, 1500 * height / (2 * v - height + 1));
    if (u > width / 3 && u < width / 2 && v > height / 3) z = std::min(z, 1200 + 400 * u / width);
    random = random * 1664525U + 1013904223U;
    depth[i] = static_cast<std::uint16_t>(z + (random >> 24U) % 7);
  }
}

bool encode(std::uint32_t width, std::uint32_t height) {
  const EncoderConfig config = settings(width, height);
  const auto bytes = Encoder::memory_bytes(config);
  if (!bytes.ok()) return false;
  auto* block = static_cast<std::byte*>(std::aligned_alloc(64, (*bytes + 63) / 64 * 64));
  auto* depth = static_cast<std::uint16_t*>(std::malloc(std::size_t{2} * width * height));
  if (block == nullptr || depth == nullptr) return false;
  render({depth, std::size_t{width} * height}, width, height);
  std::size_t packed = 0;
  bool good = false;
  {
    const auto encoder = Encoder::create(config, {block, *bytes});
    good = encoder.ok() && (*encoder)->start().ok() &&
           (*encoder)->submit(DepthView{{depth, std::size_t{width} * height}, 0, 0}) == Status::kOk;
    EncodedFrame frame;
    good = good && (*encoder)->try_next(frame) && frame.status == Status::kOk;
    for (std::uint32_t i = 0; good && i < frame.slot->report.slices; ++i)
      packed += frame.slot->slice(i).size();
  }
  const DecoderConfig decoder{
      {static_cast<std::uint16_t>(width), static_cast<std::uint16_t>(height)}};
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("%u %u %zu %zu %zu %ld\n", width, height, *bytes, Decoder::memory_bytes(decoder),
              packed, usage.ru_maxrss);
  std::free(block);
  std::free(depth);
  return good;
}

}  // namespace

int main() {
  constexpr std::uint32_t kSizes[][2] = {{160, 120}, {320, 240}, {424, 240}, {640, 480}};
  for (const auto& [width, height] : kSizes)
    if (!encode(width, height)) return 1;
  return 0;
}
