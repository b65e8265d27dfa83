// Hostile slices into a decoder. Their headers are made right, or no mutation would come past the
// check sum. Decoding the same twice must give the same: what a decoder kept of other slices in
// its memory may not show. One input in eight is decoded twice, chosen by its bytes.
#include <algorithm>
#include <cstring>
#include <span>
#include <vector>

#include "core/base/crc32c.hpp"
#include "core/wire/packet_header.hpp"
#include "tests/fuzz/fuzz_target.hpp"
#include "tests/fuzz/golden_streams.hpp"
#include "tests/fuzz/slice_input.hpp"

namespace {

using namespace planecast;
using Part = std::span<const std::uint8_t>;

constexpr std::uint32_t kTwiceOneOf = 8;
constexpr std::size_t kMostParts = 16;

std::vector<std::uint8_t> sealed(Part body, const Decoder& decoder, std::uint16_t number) {
  std::vector<std::uint8_t> packet(kPacketHeaderBytes + body.size());
  std::copy(body.begin(), body.end(), packet.begin() + kPacketHeaderBytes);
  PacketHeader header;
  header.stream = decoder.config().stream;
  header.slice = number;
  header.slice_count = 0xffff;
  header.key_hash = decoder.tables().key_hash();
  seal_packet(header, packet);
  return packet;
}

// What a frame came to.
struct Outcome {
  std::vector<Status> statuses;
  std::vector<std::uint16_t> depth;
  std::vector<std::uint8_t> labels;
  std::vector<Point3f> cloud;
};

template <class T>
bool same_bytes(std::span<const T> a, const std::vector<T>& b) {
  return a.size() == b.size() &&
         (b.empty() || std::memcmp(a.data(), b.data(), a.size_bytes()) == 0);
}

void claim_consistent(const Decoder& decoder) {
  const auto cloud = decoder.cloud();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point3f& p = cloud[i];
    const bool hole = p.x != p.x && p.y != p.y && p.z != p.z;
    test::claim(hole || (p.x - p.x == 0 && p.y - p.y == 0 && p.z - p.z == 0),
                "a point is finite or a hole");
    if (i < decoder.depth().size())
      test::claim(hole == (decoder.depth()[i] == 0), "holes are where the counts are 0");
  }
  for (const std::uint8_t label : decoder.labels())
    test::claim(label <= decoder.counts().surfaces, "a label names a surface");
}

std::vector<Status> decode(Decoder& decoder, Part input, bool as_it_is) {
  test::claim(decoder.begin() == Status::kOk, "a decoder with a key begins");
  std::vector<Status> statuses;
  while (!input.empty() && statuses.size() < kMostParts) {
    const Part part = test::take_part(input);
    const auto number = static_cast<std::uint16_t>(statuses.size());
    statuses.push_back(as_it_is ? decoder.add(part) : decoder.add(sealed(part, decoder, number)));
  }
  test::claim(decoder.finish() == Status::kOk, "a frame is finished whatever came");
  return statuses;
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static auto streams = test::golden_streams(PLANECAST_SOURCE_DIR "/tests/golden");
  if (size == 0) return 0;
  Decoder& decoder = *streams[(data[0] & ~test::kAsItIs) % streams.size()].decoder;
  const bool as_it_is = (data[0] & test::kAsItIs) != 0;
  const Part input(data + 1, size - 1);
  static Outcome first;
  first.statuses = decode(decoder, input, as_it_is);
  claim_consistent(decoder);
  if (crc32c(input) % kTwiceOneOf != 0) return 0;
  first.depth.assign(decoder.depth().begin(), decoder.depth().end());
  first.labels.assign(decoder.labels().begin(), decoder.labels().end());
  first.cloud.assign(decoder.cloud().begin(), decoder.cloud().end());
  test::claim(decode(decoder, input, as_it_is) == first.statuses &&
                  same_bytes(decoder.depth(), first.depth) &&
                  same_bytes(decoder.labels(), first.labels) &&
                  same_bytes(decoder.cloud(), first.cloud),
              "decoding again gives the same");
  return 0;
}
