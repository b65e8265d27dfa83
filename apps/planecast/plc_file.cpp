#include "apps/planecast/plc_file.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <utility>

#include "core/io/file_bytes.hpp"
#include "core/wire/key_packet.hpp"
#include "core/wire/packet_header.hpp"

namespace planecast {

bool PlcFile::damaged() const noexcept {
  if (contents.damaged_packets > 0 || contents.orphan_slices > 0) return true;
  for (std::size_t i = 0; i < contents.frames.size(); ++i) {
    const PlcFrame& frame = contents.frames[i];
    if (frame.slices.size() < frame.slice_count && !cut_short(i)) return true;
  }
  return false;
}

bool PlcFile::cut_short(std::size_t i) const noexcept {
  const PlcFrame& frame = contents.frames[i];
  return !contents.complete && i + 1 == contents.frames.size() &&
         frame.slices.size() < frame.slice_count;
}

std::vector<std::string> PlcFile::missing() const {
  std::vector<std::string> out;
  for (std::size_t i = 0; i < contents.frames.size(); ++i) {
    const PlcFrame& frame = contents.frames[i];
    if (frame.slices.size() == frame.slice_count) continue;
    out.push_back(fmt::format("{}: frame {}: {} of {} slices are missing{}", path, frame.frame,
                              frame.slice_count - frame.slices.size(), frame.slice_count,
                              cut_short(i) ? "; it is left out" : "; holes stand in their place"));
  }
  if (contents.damaged_packets > 0) {
    out.push_back(fmt::format("{}: {} damaged packets are left out; copy the file again", path,
                              contents.damaged_packets));
  }
  if (contents.orphan_slices > 0) {
    out.push_back(fmt::format("{}: {} slices lack their key packet and are left out", path,
                              contents.orphan_slices));
  }
  if (!contents.complete) {
    out.push_back(fmt::format(
        "{}: was cut: it ends after {} frames without its index{}", path, contents.frames.size(),
        contents.cut_bytes > 0 ? fmt::format(", {} bytes into a packet", contents.cut_bytes)
                               : std::string()));
  }
  return out;
}

Result<PlcFile> open_plc(const std::vector<std::string>& inputs) {
  if (inputs.size() != 1)
    return Error{Status::kUsage, fmt::format("name one .plc file; {} were given", inputs.size())};
  PlcFile file;
  file.path = inputs.front();
  auto bytes = read_file_bytes(file.path);
  if (!bytes.ok()) return bytes.error();
  file.bytes = std::move(*bytes);
  auto contents = read_plc(file.bytes);
  if (!contents.ok())
    return Error{contents.error().status, file.path + ": " + contents.error().message};
  file.contents = std::move(*contents);
  return file;
}

Result<StreamConfig> config_of(const PlcFile& file, std::span<const std::uint8_t> key_packet) {
  PacketHeader header;
  StreamConfig config;
  Status status = open_packet(key_packet, header);
  if (status == Status::kOk) status = read_key_body(key_packet.subspan(kPacketHeaderBytes), config);
  if (status == Status::kOk) return config;
  return Error{status, fmt::format("{}: byte {}: key packet not readable ({})", file.path,
                                   key_packet.data() - file.bytes.data(), to_string(status))};
}

Result<FrameLimits> limits_of(const PlcFile& file) {
  FrameLimits limits{1, 1};
  for (const auto& key : file.contents.keys) {
    const auto config = config_of(file, key);
    if (!config.ok()) return config.error();
    limits.max_width = std::max(limits.max_width, config->camera.width);
    limits.max_height = std::max(limits.max_height, config->camera.height);
    limits.max_points = std::max(limits.max_points, config->points.max_points);
  }
  if (limits.pixels() > kMaxFilePoints) {
    return Error{Status::kTooLarge,
                 fmt::format("{}: its {}x{} images have over {} pixels, which are not decoded",
                             file.path, limits.max_width, limits.max_height, kMaxFilePoints)};
  }
  return limits;
}

}  // namespace planecast
