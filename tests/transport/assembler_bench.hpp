// An assembler whose clock the test moves by hand, with small frames of fake packets.
#pragma once

#include <cstdint>
#include <memory>
#include <utility>
#include <vector>

#include "tests/transport/fake_packet.hpp"
#include "transport/assembler.hpp"

namespace planecast::test {

inline constexpr std::int64_t kMs = 1'000'000;

inline AssemblerConfig small_assembler() {
  AssemblerConfig config;
  config.max_streams = 2;
  config.max_slices = 16;
  config.max_frame_bytes = 4096;
  config.max_key_bytes = 200;
  config.output_frames = 64;
  config.held_frames = 2;
  return config;
}

/// An assembler with a clock that the test moves by hand.
struct AssemblerBench {
  explicit AssemblerBench(const AssemblerConfig& config = small_assembler())
      : assembler(std::move(Assembler::create(config).value())) {}

  void push(const PacketInfo& info, std::uint32_t salt = 0) {
    assembler->push(fake_packet(info, salt), info, now_ns);
  }
  void slice(std::uint32_t frame, std::uint16_t index, std::uint16_t count = 4,
             std::uint32_t session = 7) {
    push(slice_info(session, 1, frame, index, count));
  }
  void frame(std::uint32_t number, std::uint16_t count = 4, std::uint32_t session = 7) {
    for (std::uint16_t i = 0; i < count; ++i) slice(number, i, count, session);
  }
  void advance(std::int64_t ns) {
    now_ns += ns;
    assembler->poll(now_ns);
  }
  StreamStatistics stream(std::size_t index = 0) const {
    return assembler->statistics().streams[index];
  }
  std::vector<std::uint32_t> take_numbers() {
    std::vector<std::uint32_t> numbers;
    while (FrameRef frame = assembler->take()) numbers.push_back(frame->frame);
    return numbers;
  }

  std::unique_ptr<Assembler> assembler;
  std::int64_t now_ns = 1'000 * kMs;
};

using Numbers = std::vector<std::uint32_t>;

}  // namespace planecast::test
