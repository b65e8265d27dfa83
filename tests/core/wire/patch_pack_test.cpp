// Patches through the wire: drafts to slices and back, cut where they must be; spoilt bytes.
#include "core/wire/patch_pack.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "core/base/random.hpp"
#include "core/wire/patch_unpack.hpp"

namespace planecast {
namespace {

struct Drafts {
  std::vector<PatchDraft> drafts;
  std::vector<DraftCell> cells;
  std::uint64_t points = 0;

  /// A disc with a hole of cells, some of them empty but inside.
  void add(std::uint32_t side, Pcg32& random, std::uint8_t degree = 1) {
    PatchDraft d;
    d.degree = degree;
    d.axis = static_cast<std::uint8_t>(random.below(3));
    d.pitch_log2 = static_cast<std::uint8_t>(6 + random.below(4));
    d.cell_u = static_cast<std::int32_t>(random.below(2000)) - 1000;
    d.cell_v = static_cast<std::int32_t>(random.below(2000)) - 1000;
    d.wide = side;
    d.high = side + random.below(3);
    d.first_cell = static_cast<std::uint32_t>(cells.size());
    d.coefficients = {1000 * random.uniform(), 2 * random.uniform() - 1, 2 * random.uniform() - 1};
    if (degree == 2) {
      for (int i = 3; i < 6; ++i) d.coefficients[i] = (random.uniform() - 0.5) * 1e-5;
    }
    const double c = side / 2.0;
    for (std::uint32_t j = 0; j < d.high; ++j) {
      for (std::uint32_t i = 0; i < d.wide; ++i) {
        const double r = std::hypot(i - c, j - c) / c;
        const std::uint32_t count = random.below(5);
        const bool inside = (r > 0.3 && r < 1) || (i == 0 && j == 0);
        cells.push_back({inside ? 2 * count + 1 : 0});
        if (inside) d.points += count;
      }
    }
    points += d.points;
    drafts.push_back(d);
  }
};

void flip_bit(std::vector<std::uint8_t>& bytes, Pcg32& random) {
  std::uint8_t& byte = bytes[random.below(static_cast<std::uint32_t>(bytes.size()))];
  byte = static_cast<std::uint8_t>(byte ^ (1U << random.below(8)));
}

class PatchPackTest : public ::testing::Test {
 protected:
  PatchPackTest() : arena_(std::move(Arena::map(std::size_t{1} << 21U).value())) {
    packer_.layout(arena_);
    unpacker_.layout(arena_);
  }

  Status pack(const Drafts& d, std::size_t slice_bytes) {
    out_.assign(std::size_t{1} << 20U, 0);
    places_.assign(4000, {});
    report_ = {};
    return packer_.pack(d.drafts, d.cells, {}, slice_bytes, out_, places_, report_);
  }

  std::span<const std::uint8_t> body(std::uint32_t slice) const {
    const SlicePlace p = places_[slice];
    return std::span(out_).subspan(p.offset + kPacketHeaderBytes, p.bytes - kPacketHeaderBytes);
  }

  Arena arena_;
  PatchPacker packer_;
  PatchUnpacker unpacker_;
  std::vector<std::uint8_t> out_;
  std::vector<SlicePlace> places_;
  FrameReport report_;
};

TEST_F(PatchPackTest, PatchesComeBackWithAllTheirCellsAndPoints) {
  Pcg32 random(1);
  Drafts d;
  for (std::uint32_t side : {1U, 2U, 9U, 30U, 14U}) d.add(side + 4, random, side == 9 ? 2 : 1);
  ASSERT_EQ(pack(d, kFileSliceBytes), Status::kOk);
  ASSERT_EQ(report_.slices, 1U);
  ASSERT_EQ(report_.points, d.points);
  ASSERT_EQ(unpacker_.begin(body(0)), Status::kOk);
  for (const PatchDraft& draft : d.drafts) {
    Patch patch;
    std::span<const std::uint8_t> cells;
    ASSERT_EQ(unpacker_.next(patch, cells), Status::kOk);
    EXPECT_EQ(patch.points, draft.points);
    EXPECT_EQ(patch.axis, draft.axis);
    EXPECT_EQ(patch.degree, draft.degree);
    const PatchSurface surface(patch);
    for (std::uint32_t j = 0; j < draft.high; ++j) {
      for (std::uint32_t i = 0; i < draft.wide; ++i) {
        const std::int64_t pi = draft.cell_u + std::int64_t{i} - patch.cell_u;
        const std::int64_t pj = draft.cell_v + std::int64_t{j} - patch.cell_v;
        const bool in_grid = pi >= 0 && pj >= 0 && pi < patch.wide && pj < patch.high;
        const bool inside = in_grid && cells[static_cast<std::size_t>(pj * patch.wide + pi)] != 0;
        ASSERT_EQ(inside, d.cells[draft.first_cell + j * draft.wide + i].inside());
        if (!inside) continue;
        // Within a step of the height's rounding of the surface as it was fitted.
        const auto& c = draft.coefficients;
        const std::int64_t u = (draft.cell_u + std::int64_t{i}) << draft.pitch_log2;
        const std::int64_t v = (draft.cell_v + std::int64_t{j}) << draft.pitch_log2;
        const auto x = static_cast<double>(u), y = static_cast<double>(v);
        const double height =
            c[0] + c[1] * x + c[2] * y + c[3] * x * x + c[4] * x * y + c[5] * y * y;
        ASSERT_NEAR(static_cast<double>(surface.height(u, v)), height,
                    draft.degree == 2 ? 2 << patch.height_log2 : 1 << patch.height_log2);
      }
    }
  }
  EXPECT_EQ(unpacker_.left(), 0U);
}

TEST_F(PatchPackTest, SmallSlicesDecodeAloneAndHoldAllPoints) {
  Pcg32 random(2);
  Drafts d;
  for (int n = 0; n < 90; ++n) d.add(4 + random.below(20), random);
  d.add(230, random);  // many slices large
  for (const std::size_t limit : {kMinSliceBytes, std::size_t{1200}}) {
    ASSERT_EQ(pack(d, limit), Status::kOk);
    ASSERT_GT(report_.slices, 1U);
    std::uint64_t points = 0, surfaces = 0;
    for (std::uint32_t s = report_.slices; s-- > 0;) {
      ASSERT_LE(places_[s].bytes, limit);
      ASSERT_EQ(unpacker_.begin(body(s)), Status::kOk);
      while (unpacker_.left() > 0) {
        Patch patch;
        std::span<const std::uint8_t> cells;
        ASSERT_EQ(unpacker_.next(patch, cells), Status::kOk);
        points += patch.points;
        ++surfaces;
      }
    }
    EXPECT_EQ(points, d.points);
    EXPECT_EQ(surfaces, report_.surfaces);
  }
}

TEST_F(PatchPackTest, APatchLargerThanTheFormatIsCut) {
  Drafts d;
  PatchDraft wide;
  wide.wide = 9000;
  wide.high = 20;
  wide.points = 9000 * 20;
  wide.coefficients = {10, 0.25, 0};
  d.drafts.push_back(wide);
  d.cells.assign(9000 * 20, DraftCell{3});
  ASSERT_EQ(pack(d, 1200), Status::kOk);
  EXPECT_EQ(report_.points, 9000U * 20);
  EXPECT_GT(report_.surfaces, 2U);
}

TEST_F(PatchPackTest, MemoryThatIsTooSmallIsRefusedNotPassed) {
  Pcg32 random(3);
  Drafts d;
  for (int n = 0; n < 90; ++n) d.add(20, random);
  out_.assign(700, 0x5a);
  places_.assign(100, {});
  const std::span<std::uint8_t> some = std::span(out_).first(600);
  EXPECT_EQ(packer_.pack(d.drafts, d.cells, {}, 1200, some, places_, report_), Status::kTooLarge);
  for (std::size_t i = 600; i < 700; ++i) ASSERT_EQ(out_[i], 0x5a);
  out_.assign(std::size_t{1} << 20U, 0);
  report_ = {};
  EXPECT_EQ(packer_.pack(d.drafts, d.cells, {}, 1200, out_, std::span(places_).first(1), report_),
            Status::kTooLarge);
  EXPECT_EQ(packer_.pack(d.drafts, d.cells, {}, 100, out_, places_, report_), Status::kBadConfig);
  d.drafts[0].first_cell = static_cast<std::uint32_t>(d.cells.size());
  EXPECT_EQ(packer_.pack(d.drafts, d.cells, {}, 1200, out_, places_, report_), Status::kFieldRange);
}

TEST_F(PatchPackTest, SpoiltBytesEndInAStatusAndNeverInMorePatchesThanSaid) {
  Pcg32 random(4);
  Drafts d;
  for (int n = 0; n < 12; ++n) d.add(4 + random.below(20), random, n % 3 == 0 ? 2 : 1);
  ASSERT_EQ(pack(d, 1200), Status::kOk);
  const std::vector<std::uint8_t> good(body(0).begin(), body(0).end());
  int refused = 0;
  for (int round = 0; round < 4000; ++round) {
    std::vector<std::uint8_t> bytes = good;
    const std::uint32_t kind = random.below(3);
    if (kind == 0) bytes.resize(random.below(static_cast<std::uint32_t>(bytes.size())));
    for (std::uint32_t n = kind == 1 ? 1 : random.below(9); n > 0 && !bytes.empty(); --n)
      flip_bit(bytes, random);
    if (kind == 2) bytes.push_back(static_cast<std::uint8_t>(1 + random.below(255)));
    Status status = unpacker_.begin(bytes);
    std::uint32_t patches = 0;
    while (status == Status::kOk && unpacker_.left() > 0) {
      Patch patch;
      std::span<const std::uint8_t> cells;
      status = unpacker_.next(patch, cells);
      if (status != Status::kOk) break;
      ASSERT_EQ(check_patch(patch), Status::kOk);
      ASSERT_EQ(cells.size(), std::size_t{patch.wide} * patch.high);
      ASSERT_LE(++patches, kMaxPatchesInSlice);
    }
    refused += status != Status::kOk ? 1 : 0;
    if (status != Status::kOk) {
      EXPECT_EQ(unpacker_.left(), 0U);
    }
  }
  EXPECT_GT(refused, 1000);
  EXPECT_EQ(unpacker_.begin({}), Status::kFieldRange);  // zeros: a body of another kind
}

TEST_F(PatchPackTest, ACutOrLengthenedSliceIsNamed) {
  Pcg32 random(5);
  Drafts d;
  for (int n = 0; n < 5; ++n) d.add(20, random);
  ASSERT_EQ(pack(d, 1200), Status::kOk);
  std::vector<std::uint8_t> bytes(body(0).begin(), body(0).end());
  const auto read = [&]() {
    Status status = unpacker_.begin(bytes);
    Patch patch;
    std::span<const std::uint8_t> cells;
    while (status == Status::kOk && unpacker_.left() > 0) status = unpacker_.next(patch, cells);
    return status;
  };
  ASSERT_EQ(read(), Status::kOk);
  bytes.insert(bytes.end(), 9, 0);
  EXPECT_EQ(read(), Status::kTrailingBytes);
  bytes.resize(bytes.size() / 2);
  EXPECT_NE(read(), Status::kOk);
}

TEST(RoundPatch, ValuesBeyondTheFormatAreRefusedByTheCheck) {
  PatchDraft d;
  d.wide = d.high = 3;
  d.coefficients = {1e12, 0, 0};
  Patch p = round_patch(d, 0, 0, 3, 3, 0);
  p.points = 1;
  EXPECT_EQ(check_patch(p), Status::kOk) << "clamped to the range";
  d.cell_u = 1 << 29;
  p = round_patch(d, 0, 0, 3, 3, 0);
  p.points = 1;
  EXPECT_EQ(check_patch(p), Status::kFieldRange);
}

}  // namespace
}  // namespace planecast
