#include "tests/fuzz/golden_streams.hpp"

#include <algorithm>

#include "core/io/file_bytes.hpp"
#include "core/wire/plc_format.hpp"
#include "tests/fuzz/fuzz_target.hpp"
#include "tests/golden/golden_vectors.hpp"

namespace planecast::test {
namespace {

namespace fs = std::filesystem;

struct Size {
  std::uint16_t width, height;
};
// Two blocks by two, cut at the right and at the bottom. Surfaces need more of a frame; clouds of
// any floats take many bytes.
constexpr Size kDepth{12, 10}, kSurfaces{24, 16}, kCloud{9, 5};
constexpr std::uint32_t kListPoints = 32;

// Every so-manieth pixel: what was a plane is one still.
template <class T>
std::vector<T> thinned(const std::vector<T>& image, const CameraModel& from,
                       const CameraModel& to) {
  std::vector<T> out;
  for (std::uint32_t v = 0; v < to.height; ++v) {
    for (std::uint32_t u = 0; u < to.width; ++u)
      out.push_back(
          image[std::size_t{v * from.height / to.height} * from.width + u * from.width / to.width]);
  }
  return out;
}

GoldenCase made_small(GoldenCase c) {
  if (c.config.kind == FrameKind::kPoints) {
    c.config.points.max_points = kListPoints;
    if (c.clouds[0].size() > kListPoints) c.clouds[0].resize(kListPoints);
  } else {
    const CameraModel whole = c.config.camera;
    CameraModel& camera = c.config.camera;
    const bool surfaces = c.config.tolerance == ToleranceKind::kSurfaces;
    const Size size = !c.clouds.empty() ? kCloud : surfaces ? kSurfaces : kDepth;
    camera.width = std::min(whole.width, size.width);
    camera.height = std::min(whole.height, size.height);
    for (auto& image : c.depth) image = thinned(image, whole, camera);
    for (auto& cloud : c.clouds) cloud = thinned(cloud, whole, camera);
  }
  c.depth.resize(std::min<std::size_t>(c.depth.size(), 1));
  c.clouds.resize(std::min<std::size_t>(c.clouds.size(), 1));
  return c;
}

}  // namespace

std::vector<std::uint8_t> file_bytes(const fs::path& path) {
  auto bytes = read_file_bytes(path);
  claim(bytes.ok(), path.c_str());
  return std::move(*bytes);
}

std::vector<GoldenStream> golden_streams(const fs::path& folder) {
  const auto cases = golden_cases(folder);
  claim(cases.ok() && !cases->empty(), "there are golden cases");
  std::vector<GoldenStream> out;
  for (const GoldenCase& whole : *cases) {
    const GoldenCase small = made_small(whole);
    auto bytes = encode_golden(small);
    claim(bytes.ok(), small.name.c_str());
    const auto contents = read_plc(*bytes);
    claim(contents.ok() && !contents->frames.empty(), small.name.c_str());
    const PlcFrame& frame = contents->frames[0];
    GoldenStream stream{small.name, *bytes, {frame.key.begin(), frame.key.end()}, {}, {}};
    for (const auto slice : frame.slices) stream.slices.emplace_back(slice.begin(), slice.end());
    auto decoder = Decoder::create({limits_of(small)});
    claim(decoder.ok() && (*decoder)->set_key(frame.key) == Status::kOk, small.name.c_str());
    stream.decoder = std::move(*decoder);
    out.push_back(std::move(stream));
  }
  return out;
}

}  // namespace planecast::test
