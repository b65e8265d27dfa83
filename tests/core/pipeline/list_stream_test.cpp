// Streams of points without order, from submit() to cloud(): the contract, loss, refusals.
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/model/point_grid.hpp"
#include "core/wire/point_pack.hpp"
#include "tests/core/pipeline/codec_bench.hpp"

namespace planecast {
namespace {

using namespace test;

const SimStream& rooms() {
  static const SimStream stream = sim_stream(64, 48, 3);
  return stream;
}

std::vector<Point3f> valid(const std::vector<Point3f>& points) {
  std::vector<Point3f> out;
  for (const Point3f& p : points)
    if (std::isfinite(p.z)) out.push_back(p);
  return out;
}

double farthest(std::span<const Point3f> from, std::span<const Point3f> to) {
  double worst = 0;
  for (const Point3f& p : from) {
    double least = std::numeric_limits<double>::infinity();
    for (const Point3f& q : to) {
      const double x = double{p.x} - q.x, y = double{p.y} - q.y, z = double{p.z} - q.z;
      least = std::min(least, x * x + y * y + z * z);
    }
    worst = std::max(worst, least);
  }
  return std::sqrt(worst);
}

std::vector<std::array<float, 3>> sorted(std::span<const Point3f> points) {
  std::vector<std::array<float, 3>> out;
  for (const Point3f& p : points) out.push_back({p.x, p.y, p.z});
  std::sort(out.begin(), out.end());
  return out;
}

struct Stream {
  std::unique_ptr<Encoder> encoder;
  std::unique_ptr<Decoder> decoder;

  explicit Stream(const EncoderConfig& config) {
    encoder = make_encoder(config);
    FrameLimits limits{1, 1};
    limits.max_points = config.stream.points.max_points;
    decoder = make_decoder({limits});
    EXPECT_EQ(decoder->set_key(key_of(*encoder)), Status::kOk);
  }
  Coded code(std::span<const Point3f> points, std::uint64_t number = 0) {
    EXPECT_EQ(encoder->submit(points, number, 0), Status::kOk);
    auto coded = take_all(*encoder);
    EXPECT_EQ(coded.size(), 1U);
    return coded.empty() ? Coded{} : std::move(coded[0]);
  }
};

EncoderConfig list_config(std::size_t i, std::uint32_t max_points = 0) {
  EncoderConfig config = encoder_config(rooms(), kListCases[i]);
  if (max_points != 0) config.stream.points.max_points = max_points;
  return config;
}

class ListStream : public testing::TestWithParam<std::size_t> {};
INSTANTIATE_TEST_SUITE_P(Kinds, ListStream, testing::Values(0, 1), [](const auto& param) {
  return std::string(kListCases[param.param].name);
});

TEST_P(ListStream, KeepsItsContractFrameAfterFrame) {
  const Source source(rooms(), kListCases[GetParam()]);
  Stream stream(list_config(GetParam()));
  for (std::uint64_t i = 0; i < source.size(); ++i) {
    const std::vector<Point3f> in = valid(source.cloud(i));
    const Coded coded = stream.code(source.cloud(i), i);  // NaN for holes: they are no points
    ASSERT_EQ(coded.status, Status::kOk);
    EXPECT_EQ(coded.counts.input, in.size());
    EXPECT_EQ(coded.counts.kept, in.size());
    decode_frame(*stream.decoder, coded);
    const auto out = stream.decoder->cloud();
    ASSERT_EQ(out.size(), in.size());
    EXPECT_EQ(stream.decoder->counts().points, in.size());
    EXPECT_TRUE(stream.decoder->depth().empty());
    if (kListCases[GetParam()].tolerance == ToleranceKind::kLossless) {
      EXPECT_EQ(sorted(in), sorted(out));
    } else {
      EXPECT_LE(farthest(in, out), 0.010);
      EXPECT_LE(farthest(out, in), 0.010);
    }
  }
}

TEST_P(ListStream, SlicesDecodeInAnyOrderAndALostOneTakesItsOwnPointsOnly) {
  const Source source(rooms(), kListCases[GetParam()]);
  EncoderConfig config = list_config(GetParam());
  config.stages.slice_bytes = 400;
  Stream stream(config);
  const Coded coded = stream.code(source.cloud(0));
  ASSERT_GT(coded.slices.size(), 5U);
  decode_frame(*stream.decoder, coded);
  const auto whole = sorted(stream.decoder->cloud());
  ASSERT_EQ(stream.decoder->begin(), Status::kOk);
  for (std::size_t i = coded.slices.size(); i-- > 0;)
    ASSERT_EQ(stream.decoder->add(coded.slices[i]), Status::kOk);
  EXPECT_EQ(sorted(stream.decoder->cloud()), whole);
  ASSERT_EQ(stream.decoder->begin(), Status::kOk);
  for (std::size_t i = 0; i < coded.slices.size(); ++i) {
    if (i % 3 != 1) ASSERT_EQ(stream.decoder->add(coded.slices[i]), Status::kOk);
  }
  const auto part = sorted(stream.decoder->cloud());
  EXPECT_LT(part.size(), whole.size());
  EXPECT_GT(part.size(), whole.size() / 3);
  EXPECT_TRUE(std::includes(whole.begin(), whole.end(), part.begin(), part.end()));
}

TEST(ListStreamRefusals, AFrameOfTooManyPointsIsRefusedAndTheNextOneGoesOn) {
  Stream stream(list_config(1, 10));
  const std::vector<Point3f> points(11, Point3f{1, 2, 3});
  EXPECT_EQ(stream.encoder->submit(points, 0, 0), Status::kFrameTooLarge);
  const Coded coded = stream.code(std::span(points).first(10), 1);
  decode_frame(*stream.decoder, coded);
  EXPECT_EQ(stream.decoder->cloud().size(), 10U);
  EXPECT_EQ(stream.encoder->submit(DepthView{}), Status::kWrongSize);
}

TEST(ListStreamRefusals, AKeyForMorePointsThanTheDecoderHasRoomForIsRefused) {
  const auto encoder = make_encoder(list_config(1, 1000));
  FrameLimits limits{8, 8};
  limits.max_points = 999;
  EXPECT_EQ(make_decoder({limits})->set_key(key_of(*encoder)), Status::kFrameTooLarge);
  limits.max_points = 1000;
  EXPECT_EQ(make_decoder({limits})->set_key(key_of(*encoder)), Status::kOk);
}

TEST(ListStreamRefusals, ADecoderOfDepthStreamsHasNoMemoryForLists) {
  const auto encoder = make_encoder(list_config(1, 1));
  EXPECT_EQ(make_decoder({FrameLimits{640, 480}})->set_key(key_of(*encoder)),
            Status::kFrameTooLarge);
  FrameLimits lists{640, 480};
  lists.max_points = lists.pixels();
  EXPECT_LT(3 * Decoder::memory_bytes({FrameLimits{640, 480}}), Decoder::memory_bytes({lists}));
}

TEST(ListStreamRefusals, TheSameSliceTwiceCannotOverfillTheFrame) {
  Stream stream(list_config(1, 10));
  const Coded coded = stream.code(std::vector<Point3f>(10, Point3f{1, 2, 3}));
  ASSERT_EQ(coded.slices.size(), 1U);
  ASSERT_EQ(stream.decoder->begin(), Status::kOk);
  EXPECT_EQ(stream.decoder->add(coded.slices[0]), Status::kOk);
  EXPECT_EQ(stream.decoder->add(coded.slices[0]), Status::kTooLarge);
  EXPECT_EQ(stream.decoder->cloud().size(), 10U);
}

TEST(ListStreamRefusals, PointsThatCannotKeepTheirBoundFailTheFrameByName) {
  Stream stream(list_config(1, 10));
  for (const float far : {1e30F, 1e7F, -3e5F}) {  // beyond the grid; too coarse for 10 mm
    const Coded coded = stream.code(std::vector<Point3f>{{0, 0, 0}, {far, 0, 0}});
    EXPECT_EQ(coded.status, Status::kBoundExceeded) << far;
  }
  EXPECT_EQ(stream.code(std::vector<Point3f>{{0, 0, 0}, {100, 0, 0}}).status, Status::kOk);
}

TEST(ListStreamOddities, NoPointsFewPointsAndEqualPointsComeBack) {
  for (const std::size_t c : {0, 1}) {
    Stream stream(list_config(c, 100));
    for (const std::size_t n : {0, 1, 2, 3, 100}) {
      const Coded coded = stream.code(std::vector<Point3f>(n, Point3f{0.25F, -1.5F, 2}));
      ASSERT_EQ(coded.status, Status::kOk);
      ASSERT_GE(coded.slices.size(), 1U);
      decode_frame(*stream.decoder, coded);
      ASSERT_EQ(stream.decoder->cloud().size(), n);
      for (const Point3f& p : stream.decoder->cloud())
        EXPECT_LE(std::hypot(p.x - 0.25, p.y + 1.5, p.z - 2), c == 0 ? 0 : 0.010);
    }
  }
}

TEST(ListStreamOddities, LosslessBitsTellZerosApartAndKeepDenormalsAndEnds) {
  Stream stream(list_config(0, 100));
  constexpr float kMost = std::numeric_limits<float>::max();
  const std::vector<Point3f> points = {
      {0.0F, -0.0F, 1e-44F}, {kMost, -kMost, 1e30F}, {-1e-44F, 3, -0.0F}};
  decode_frame(*stream.decoder, stream.code(points));
  auto bits = [](std::span<const Point3f> list) {
    std::vector<std::array<std::int32_t, 3>> out;
    for (const Point3f& p : list)
      out.push_back({rank_of_float(p.x), rank_of_float(p.y), rank_of_float(p.z)});
    std::sort(out.begin(), out.end());
    return out;
  };
  EXPECT_EQ(bits(points), bits(stream.decoder->cloud()));
}

TEST(ListStreamRange, ReadingsOutsideAreTakenOutAndCounted) {
  EncoderConfig config = list_config(1, 100);
  config.stages.range_min_m = 1;
  config.stages.range_max_m = 5;
  config.stream.axes.t_um = {0, 0, 2'000'000};  // distances count from the input's zero
  Stream stream(config);
  const Coded coded =
      stream.code(std::vector<Point3f>{{0, 0, 0}, {0, 0, 4}, {0, 0, -1.5F}, {0, 0, 2}});
  EXPECT_EQ(coded.counts.input, 4U);
  EXPECT_EQ(coded.counts.out_of_range, 2U);
  EXPECT_EQ(coded.counts.kept, 2U);
}

TEST(ListStreamGrid, AGridThatTheInputProvesBringsEveryBitBack) {
  EncoderConfig config = list_config(0, 1000);
  config.stream.points.step_pm = 1'000'000'000;  // whole millimetres
  Stream stream(config);
  std::vector<Point3f> points;
  for (int i = 0; i < 900; ++i)
    points.push_back({static_cast<float>(i * 7 * 0.001), static_cast<float>(-i * 0.001), 1.25F});
  const Coded coded = stream.code(points);
  ASSERT_EQ(coded.status, Status::kOk);
  decode_frame(*stream.decoder, coded);
  EXPECT_EQ(sorted(points), sorted(stream.decoder->cloud()));
  points[3].x = 0.0215F;  // off the grid
  EXPECT_EQ(stream.code(points).status, Status::kBoundExceeded);
}

// A floor of 3000 points with 2 mm of noise, and 200 points anywhere above it.
std::vector<Point3f> floor_and_dust() {
  Pcg32 random(4);
  const auto within = [&](double most) { return most * (2 * random.uniform() - 1); };
  std::vector<Point3f> out;
  for (int i = 0; i < 3000; ++i)
    out.push_back({static_cast<float>(0.02 * (i % 60)), static_cast<float>(0.02 * (i / 60)),
                   static_cast<float>(within(0.002))});
  for (int i = 0; i < 200; ++i)
    out.push_back({static_cast<float>(0.6 + within(0.6)), static_cast<float>(0.5 + within(0.5)),
                   static_cast<float>(0.7 + within(0.4))});
  return out;
}

EncoderConfig surface_config(bool drop, FillMode fill) {
  EncoderConfig config = list_config(drop ? 3 : 2, 4000);
  config.stages.paper = true;
  config.stream.points.fill = fill;
  config.stream.points.patch_unit_nm = 390'625;  // alpha 0.1 m
  return config;
}

TEST(ListStreamSurfaces, EveryPointIsOnASurfaceOrComesBackAsItself) {
  for (const FillMode fill : {FillMode::kLattice, FillMode::kRandom}) {
    Stream stream(surface_config(false, fill));
    const std::vector<Point3f> in = floor_and_dust();
    const Coded coded = stream.code(in);
    ASSERT_EQ(coded.status, Status::kOk);
    EXPECT_GT(coded.counts.on_surface, 2800U);
    EXPECT_GE(coded.counts.off_surface, 200U);
    EXPECT_EQ(coded.counts.on_surface + coded.counts.off_surface, in.size());
    EXPECT_EQ(coded.counts.kept, in.size());
    decode_frame(*stream.decoder, coded);
    const auto out = stream.decoder->cloud();
    ASSERT_EQ(out.size(), in.size());
    EXPECT_GE(stream.decoder->counts().surfaces, 1U);
    EXPECT_LE(farthest(std::span(in).last(200), out), 0.012);  // the dust, to K sigma
    std::size_t on_floor = 0;
    for (const Point3f& p : out) on_floor += std::abs(p.z) < 0.012;
    EXPECT_GE(on_floor, coded.counts.on_surface);
    EXPECT_LE(farthest(std::span(in).first(3000), out), 0.1);  // even over the floor
  }
}

TEST(ListStreamSurfaces, WhatIsDroppedIsCountedAndTheRestComesBack) {
  Stream stream(surface_config(true, FillMode::kRandom));
  const std::vector<Point3f> in = floor_and_dust();
  const Coded coded = stream.code(in);
  ASSERT_EQ(coded.status, Status::kOk);
  EXPECT_EQ(coded.counts.off_surface_dropped, coded.counts.off_surface);
  EXPECT_EQ(coded.counts.kept + coded.counts.off_surface_dropped, in.size());
  decode_frame(*stream.decoder, coded);
  EXPECT_EQ(stream.decoder->cloud().size(), coded.counts.kept);
  std::size_t bytes = 0;
  for (const auto& slice : coded.slices) bytes += slice.size();
  EXPECT_LT(bytes, 300U);  // 3000 points
}

TEST(ListStreamSurfaces, RandomPointsFollowFromSeedFrameAndSliceAlone) {
  const std::vector<Point3f> in = floor_and_dust();
  const auto decoded = [&](std::uint32_t seed, std::uint64_t number) {
    EncoderConfig config = surface_config(true, FillMode::kRandom);
    config.stream.points.seed = seed;
    Stream stream(config);
    decode_frame(*stream.decoder, stream.code(in, number));
    return sorted(stream.decoder->cloud());
  };
  const auto first = decoded(1, 0);
  EXPECT_EQ(first, decoded(1, 0));
  EXPECT_NE(first, decoded(2, 0));
  EXPECT_NE(first, decoded(1, 1));
}

TEST(ListStreamSurfaces, OutliersAreFlaggedAndDroppedOnlyWhenAsked) {
  std::vector<Point3f> in = floor_and_dust();
  in.push_back({30, 30, 30});
  for (const bool drop : {false, true}) {
    EncoderConfig config = surface_config(false, FillMode::kLattice);
    config.stages.drop_outliers = drop;
    Stream stream(config);
    const Coded coded = stream.code(in);
    EXPECT_GE(coded.counts.outliers, 1U);
    EXPECT_EQ(coded.counts.outliers_dropped, drop ? coded.counts.outliers : 0U);
    decode_frame(*stream.decoder, coded);
    EXPECT_EQ(stream.decoder->cloud().size(), in.size() - coded.counts.outliers_dropped);
  }
}

}  // namespace
}  // namespace planecast
