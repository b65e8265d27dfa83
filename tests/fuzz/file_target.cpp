// Hostile .plc files: their records, index and trailer; and the frames of streams that are known.
#include <algorithm>

#include "core/wire/plc_format.hpp"
#include "tests/fuzz/fuzz_target.hpp"
#include "tests/fuzz/golden_streams.hpp"

namespace {

using namespace planecast;

void decode(const PlcFrame& frame) {
  static auto streams = test::golden_streams(PLANECAST_SOURCE_DIR "/tests/golden");
  for (auto& stream : streams) {
    if (!std::equal(frame.key.begin(), frame.key.end(), stream.key.begin(), stream.key.end()))
      continue;
    Decoder& decoder = *stream.decoder;
    test::claim(decoder.begin() == Status::kOk, "a decoder with a key begins");
    for (const auto slice : frame.slices) (void)decoder.add(slice);
    test::claim(decoder.finish() == Status::kOk, "a frame is finished whatever came");
  }
}

bool inside(std::span<const std::uint8_t> part, std::span<const std::uint8_t> whole) {
  return part.data() >= whole.data() && part.data() + part.size() <= whole.data() + whole.size();
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  const auto contents = read_plc(bytes);
  const auto places = read_plc_index(bytes);
  if (!contents.ok()) return 0;
  test::claim(contents->cut_bytes <= size, "no more is cut than was there");
  for (const PlcFrame& frame : contents->frames) {
    test::claim(inside(frame.key, bytes) && frame.slices.size() <= 65535, "a frame is in the file");
    for (const auto slice : frame.slices) test::claim(inside(slice, bytes), "so is a slice");
  }
  if (places.ok()) {
    for (const PlcPlace& place : *places)
      test::claim(place.offset < size && place.key_offset < size, "the index names what is there");
  }
  for (std::size_t i = 0; i < std::min<std::size_t>(contents->frames.size(), 2); ++i)
    decode(contents->frames[i]);
  return 0;
}
