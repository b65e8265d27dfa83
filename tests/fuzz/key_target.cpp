// Hostile bodies of key packets. What is accepted must be written and read again as the same, and
// for some of the small images among them the tables of a stream are built (that takes long).
#include <algorithm>
#include <vector>

#include "core/base/crc32c.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/wire/key_packet.hpp"
#include "core/wire/packet_header.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace {

using namespace planecast;

constexpr FrameLimits kLimits{48, 32, 1000};
constexpr std::uint32_t kBuildOneOf = 512;

void build(std::span<const std::uint8_t> body, std::uint32_t hash) {
  static auto decoder = Decoder::create({.limits = kLimits});
  test::claim(decoder.ok(), "a small decoder has its memory");
  std::vector<std::uint8_t> packet(kPacketHeaderBytes + body.size());
  std::copy(body.begin(), body.end(), packet.begin() + kPacketHeaderBytes);
  PacketHeader header;
  header.key = true;
  header.key_hash = hash;
  seal_packet(header, packet);
  Decoder& d = **decoder;
  if (d.set_key(packet) != Status::kOk) return;
  test::claim(d.ready() && d.begin() == Status::kOk && d.finish() == Status::kOk,
              "a stream whose key packet is taken gives empty frames");
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> body(data, size);
  StreamConfig config;
  if (read_key_body(body, config) != Status::kOk) return 0;
  std::uint8_t again[kMaxKeyBodyBytes];
  const std::size_t length = write_key_body(config, again);
  test::claim(length > 0 && length <= size, "what was read can be written");
  StreamConfig second;
  test::claim(read_key_body({again, length}, second) == Status::kOk, "and read again");
  std::uint8_t third[kMaxKeyBodyBytes];
  test::claim(write_key_body(second, third) == length && std::equal(again, again + length, third),
              "as the same");
  const std::uint32_t hash = crc32c(body);
  if (hash % kBuildOneOf == 0) build(body, hash);
  return 0;
}
