#include "core/io/xyz_text.hpp"
#include "tests/fuzz/fuzz_target.hpp"

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto cloud = planecast::parse_xyz_text("input", {data, size});
  if (cloud.ok()) planecast::test::claim_sound(*cloud);
  return 0;
}
