// A reader with the fault that readers have most: it believes the count that its bytes begin with.
// Any build must see the replay end with it; a sanitizer would say so itself.
#include <span>

#include "tests/fuzz/fuzz_target.hpp"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const std::span<const std::uint8_t> bytes(data, size);
  if (bytes.empty()) return 0;
  const std::size_t count = bytes[0];
  for (std::size_t i = 0; i < count; ++i)
    planecast::test::claim(1 + i < bytes.size(), "the count fits the bytes");
  return 0;
}
