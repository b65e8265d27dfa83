// Hostile bodies of slices of patches, past any header: what is read obeys the format, and can be
// filled both ways with as many finite points as it says.
#include <algorithm>
#include <span>
#include <vector>

#include "core/base/arena.hpp"
#include "core/regen/patch_fill.hpp"
#include "core/wire/patch_unpack.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace {

using namespace planecast;

// More would make each try slow.
constexpr std::uint32_t kMostPoints = 512;
constexpr int kMostPatches = 8;

struct Halves {
  Arena arena;
  PatchUnpacker unpacker;
  PatchFiller filler;

  Halves() : arena(std::move(Arena::map(std::size_t{1} << 20U).value())) {
    unpacker.layout(arena);
    filler.layout(arena);
    test::claim(!arena.failed(), "there is memory for patches");
  }
};

void claim_filled(Halves& halves, const Patch& patch, std::span<const std::uint8_t> cells) {
  for (const FillMode fill : {FillMode::kLattice, FillMode::kRandom}) {
    PointStream stream;
    stream.patch_unit_nm = 78125;
    stream.fill = fill;
    Pcg32 generator = patch_generator(stream, 0, 0);
    std::vector<Point3f> points(patch.points);
    test::claim(halves.filler.fill(patch, cells, stream, generator, points) == Status::kOk,
                "a patch that was read can be filled");
    for (const Point3f& p : points)
      test::claim(p.x - p.x == 0 && p.y - p.y == 0 && p.z - p.z == 0, "points are finite");
  }
}

}  // namespace

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  static Halves halves;
  const std::vector<std::uint8_t> body(data, data + size);  // of its own size: over-reads show
  if (halves.unpacker.begin(body) != Status::kOk) {
    test::claim(halves.unpacker.left() == 0, "nothing is left of what was refused");
    return 0;
  }
  for (int n = 0; n < kMostPatches && halves.unpacker.left() > 0; ++n) {
    Patch patch;
    std::span<const std::uint8_t> cells;
    const std::uint32_t before = halves.unpacker.left();
    const Status status = halves.unpacker.next(patch, cells);
    test::claim(halves.unpacker.left() < before, "reading ends");
    // The last patch may be whole and the bytes behind it too many.
    if (status != Status::kOk) break;
    test::claim(check_patch(patch) == Status::kOk, "what is read obeys the format");
    test::claim(cells.size() == std::size_t{patch.wide} * patch.high, "cells fill the patch");
    test::claim(std::any_of(cells.begin(), cells.end(), [](auto c) { return c != 0; }),
                "a patch has a cell inside");
    if (patch.points <= kMostPoints) claim_filled(halves, patch, cells);
  }
  return 0;
}
