// Prints point slices and what the decoder makes of them, for tests/golden/reference_points.py.
#include <cstdio>

#include "tests/core/wire/point_bench.hpp"

namespace {

using namespace planecast;
using namespace planecast::point_bench;

void print_hex(const std::uint8_t* bytes, std::size_t size) {
  if (size == 0) std::printf("-");
  for (std::size_t i = 0; i < size; ++i) std::printf("%02x", bytes[i]);
}

bool print_slices(const Points& cloud, std::uint32_t tolerance) {
  Codec codec(tolerance, static_cast<std::uint32_t>(cloud.size()));
  if (codec.pack(cloud, 1200) != Status::kOk) return false;
  for (const Packet& packet : codec.packets()) {
    Points points;
    if (codec.unpack({packet}, points) != Status::kOk) return false;
    std::printf("%u %zu ", tolerance, cloud.size());
    print_hex(packet.data() + kPacketHeaderBytes, packet.size() - kPacketHeaderBytes);
    std::printf(" ");
    Packet bytes;
    for (const GridPoint& p : points)
      for (const std::int32_t v : {p.x, p.y, p.z})
        for (unsigned shift = 0; shift < 32; shift += 8)
          bytes.push_back(static_cast<std::uint8_t>(static_cast<std::uint32_t>(v) >> shift));
    print_hex(bytes.data(), bytes.size());
    std::printf("\n");
  }
  return true;
}

}  // namespace

int main() {
  unsigned seed = 40;
  for (const std::string& name : cloud_names())
    for (const std::uint32_t tolerance : {0U, 60U, 900U})
      if (!print_slices(cloud(name, 150, 3000, ++seed), tolerance)) return 1;
  return print_slices({}, 10) ? 0 : 1;
}
