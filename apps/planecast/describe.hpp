// What key packets, slices and surfaces say, as JSON that a person can read too: the one view
// behind `info` and the sensor part of `eval --json`.
#pragma once

#include <cstdint>
#include <nlohmann/json.hpp>
#include <span>
#include <string>

#include "core/base/status.hpp"
#include "core/model/stream_config.hpp"
#include "core/wire/packet_header.hpp"
#include "core/wire/tile_unpack.hpp"

namespace planecast {

using Json = nlohmann::ordered_json;

/// All fields of a key packet, in units of people: metres, pixels, degrees of freedom as on the
/// wire beside them where they are what decides.
Json describe(const StreamConfig& config);

/// The header of a slice, its tile and the tile's surfaces.
Json describe(const PacketHeader& header, const TileContent& tile, const CameraModel& camera,
              std::size_t bytes);

/// What a slice of a stream of points holds.
struct ListContent {
  const char* what = "points";
  std::uint32_t points = 0, surfaces = 0;
};
Json describe(const PacketHeader& header, const ListContent& content, std::size_t bytes);

/// "0x1a2b3c4d".
std::string hex32(std::uint32_t value);

/// JSON as indented lines "key: value"; arrays of numbers on one line. Ends without a line end.
std::string readable(const Json& value, int indent = 0);

}  // namespace planecast
