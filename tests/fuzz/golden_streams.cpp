#include "tests/fuzz/golden_streams.hpp"

#include <algorithm>

#include "core/io/file_bytes.hpp"
#include "core/wire/key_packet.hpp"
#include "core/wire/plc_format.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace planecast::test {

namespace fs = std::filesystem;

constexpr std::size_t kMaxPixels = 1000;  // larger images would make each try slow

std::vector<std::uint8_t> file_bytes(const fs::path& path) {
  auto bytes = read_file_bytes(path);
  claim(bytes.ok(), path.c_str());
  return std::move(*bytes);
}

std::vector<GoldenStream> golden_streams(const fs::path& folder) {
  std::vector<fs::path> paths;
  for (const auto& entry : fs::directory_iterator(folder))
    if (entry.path().extension() == ".plc") paths.push_back(entry.path());
  std::sort(paths.begin(), paths.end());
  std::vector<GoldenStream> out;
  for (const fs::path& path : paths) {
    const auto bytes = file_bytes(path);
    const auto contents = read_plc(bytes);
    claim(contents.ok() && !contents->frames.empty(), path.c_str());
    const PlcFrame& frame = contents->frames[0];
    StreamConfig config;
    claim(read_key_body(frame.key.subspan(kPacketHeaderBytes), config) == Status::kOk,
          path.c_str());
    if (config.camera.pixels() > kMaxPixels) continue;
    GoldenStream stream{path.stem().string(), {frame.key.begin(), frame.key.end()}, {}, {}};
    for (const auto slice : frame.slices) stream.slices.emplace_back(slice.begin(), slice.end());
    FrameLimits limits{config.camera.width, config.camera.height};
    limits.max_points = config.points.max_points;
    auto decoder = Decoder::create({limits});
    claim(decoder.ok() && (*decoder)->set_key(frame.key) == Status::kOk, path.c_str());
    stream.decoder = std::move(*decoder);
    out.push_back(std::move(stream));
  }
  claim(!out.empty(), "there are golden vectors");
  return out;
}

}  // namespace planecast::test
