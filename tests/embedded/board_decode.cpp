// The least receiver that a board needs: packets one by one from a file or a pipe (a .plc file
// stands for the link) into a decoder in memory that the program gives. Prints a line a frame and
// what it took. No exceptions, no RTTI, nothing of the encoder.
//   board_decode FILE.plc [WIDTH HEIGHT [POINTS]]      exits 0 when every packet was decoded
// POINTS: most of a list of points; without it none is taken, and no memory for them.
#include <sys/resource.h>

#include <cstdio>
#include <cstdlib>
#include <memory>

#include "core/base/bytes.hpp"
#include "core/base/crc32c.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/wire/packet_header.hpp"

namespace {

using namespace planecast;

constexpr std::size_t kFileHeaderBytes = 8, kLengthBytes = 4, kMostPacketBytes = 1U << 20U;

/// Reads one record of the file; empty at its end, which a length of 0 marks too.
std::span<const std::uint8_t> next_packet(std::FILE* file, std::span<std::uint8_t> buffer) {
  std::uint8_t length[kLengthBytes];
  if (std::fread(length, 1, kLengthBytes, file) != kLengthBytes) return {};
  const std::uint32_t bytes = load_le<std::uint32_t>(length);
  if (bytes < kPacketHeaderBytes || bytes > buffer.size()) return {};
  if (std::fread(buffer.data(), 1, bytes, file) != bytes) return {};
  return buffer.first(bytes);
}

void report(const Decoder& decoder, std::uint32_t frame) {
  const auto cloud = decoder.cloud();
  std::printf("frame %u: %u slices, %u points, crc32c %08x\n", frame, decoder.counts().slices,
              decoder.counts().points,
              crc32c({reinterpret_cast<const std::uint8_t*>(decoder.depth().data()),
                      decoder.depth().size_bytes()}));
  (void)cloud;  // here a robot would use it
}

int run(std::FILE* file, Decoder& decoder, std::span<std::uint8_t> buffer) {
  int refused = 0;
  bool open = false;
  std::uint32_t frame = 0;
  const auto end_frame = [&] {
    if (open && decoder.finish() == Status::kOk) report(decoder, frame);
    open = false;
  };
  for (auto packet = next_packet(file, buffer); !packet.empty();
       packet = next_packet(file, buffer)) {
    PacketHeader header;
    Status status = open_packet(packet, header);
    if (status == Status::kOk && header.key) {
      end_frame();
      status = decoder.set_key(packet);
    } else if (status == Status::kOk) {
      if (open && header.frame != frame) end_frame();
      if (!open) status = decoder.begin();
      open = true;
      frame = header.frame;
      if (status == Status::kOk) status = decoder.add(packet);
    }
    refused += status == Status::kOk ? 0 : 1;
  }
  end_frame();
  return refused;
}

}  // namespace

int main(int argc, char** argv) {
  std::FILE* file = argc > 1 ? std::fopen(argv[1], "rb") : nullptr;
  std::uint8_t header[kFileHeaderBytes];
  if (file == nullptr || std::fread(header, 1, sizeof header, file) != sizeof header) {
    std::fprintf(stderr, "usage: board_decode FILE.plc [WIDTH HEIGHT [POINTS]]\n");
    return 2;
  }
  DecoderConfig config{{640, 480}};
  if (argc > 3)
    config.limits = {static_cast<std::uint16_t>(std::atoi(argv[2])),
                     static_cast<std::uint16_t>(std::atoi(argv[3]))};
  if (argc > 4) config.limits.max_points = static_cast<std::uint32_t>(std::atol(argv[4]));
  const std::size_t bytes = Decoder::memory_bytes(config);
  // For the program's whole life, as a board's memory is: never given back.
  static auto* block = static_cast<std::byte*>(std::aligned_alloc(64, (bytes + 63) / 64 * 64));
  static auto* buffer = static_cast<std::uint8_t*>(std::malloc(kMostPacketBytes));
  if (block == nullptr || buffer == nullptr) return 1;
  const auto decoder = Decoder::create(config, {block, bytes});
  if (!decoder.ok()) return 1;
  const int refused = run(file, **decoder, {buffer, kMostPacketBytes});
  rusage usage{};
  getrusage(RUSAGE_SELF, &usage);
  std::printf("decoder memory %zu bytes, resident at most %ld kB, packets refused %d\n", bytes,
              usage.ru_maxrss, refused);
  return refused == 0 ? 0 : 1;
}
