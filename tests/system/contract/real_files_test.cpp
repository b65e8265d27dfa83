// The error contract on real recordings: every depth image at tolerance 0 bit for bit, every
// organised cloud, and bounded tolerances on some of each. Skipped where the recordings are absent.
#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <filesystem>

#include "apps/common/frame_codec.hpp"
#include "apps/common/stream_setup.hpp"
#include "core/io/depth_png.hpp"
#include "core/io/depth_raw.hpp"
#include "core/io/file_list.hpp"
#include "core/io/point_file.hpp"
#include "tests/core/pipeline/codec_bench.hpp"
#include "tests/support/data_path.hpp"
#include "tests/system/contract/contract_check.hpp"

namespace planecast {
namespace {

using namespace test;
namespace fs = std::filesystem;

constexpr StreamCase kBounded[] = {
    {"10 mm", FrameKind::kDepth, ToleranceKind::kMetres, 0.010},
    {"2 sigma", FrameKind::kDepth, ToleranceKind::kSigma, 2},
    {"surfaces", FrameKind::kDepth, ToleranceKind::kSurfaces, 3},
    {"surfaces, drop", FrameKind::kDepth, ToleranceKind::kSurfaces, 3, true},
};

/// A recording of depth images of one sensor.
struct Recording {
  Intrinsics intrinsics;
  NoiseModel noise;
  std::vector<DepthImage> images;
  std::vector<std::string> names;
};

std::vector<fs::path> files_of(const fs::path& folder, const std::string& extension) {
  std::vector<std::string> names;
  for (const auto& entry : fs::directory_iterator(folder)) {
    if (entry.path().extension() == extension) names.push_back(entry.path().string());
  }
  std::ranges::sort(names);
  const auto files = expand_inputs(names);
  EXPECT_TRUE(files.ok());
  return *files;
}

void add_images(Recording& out, const fs::path& folder, const std::string& extension) {
  for (const fs::path& path : files_of(folder, extension)) {
    if (extension == ".png" && path.stem().string().ends_with("_cloud")) continue;
    auto image = extension == ".raw" ? read_depth_raw(path, 320, 288) : read_depth_png(path);
    ASSERT_TRUE(image.ok()) << image.error().message;
    out.images.push_back(std::move(*image));
    out.names.push_back(path.filename().string());
  }
}

Intrinsics pinhole(double f, double cx, double cy) {
  Intrinsics out;
  out.fx = out.fy = f;
  out.cx = cx;
  out.cy = cy;
  return out;
}

/// Codes images first, first + step, ... of a recording and checks each.
void check_recording(const Recording& recording, const StreamCase& c, std::size_t step) {
  SCOPED_TRACE(c.name);
  ASSERT_FALSE(recording.images.empty());
  const DepthImage& first = recording.images.front();
  EncoderConfig config;
  config.stream.camera = *quantise(recording.intrinsics, first.width, first.height);
  config.stream.noise = recording.noise;
  if (const auto lattice = find_lattice(first.depth)) config.stream.lattice = *lattice;
  set_case(c, config.stream);
  config.runner = {.slots = 1, .mode = RunMode::kInline};
  const auto encoder = make_encoder(config);
  const auto decoder = make_decoder();
  ASSERT_EQ(decoder->set_key(key_of(*encoder)), Status::kOk);
  for (std::size_t i = 0; i < recording.images.size(); i += step) {
    SCOPED_TRACE(recording.names[i]);
    const std::vector<std::uint16_t>& depth = recording.images[i].depth;
    ASSERT_EQ(encoder->submit(DepthView{depth, i, 0}), Status::kOk);
    const auto coded = take_all(*encoder);
    ASSERT_EQ(coded.size(), 1U);
    ASSERT_EQ(coded[0].status, Status::kOk);
    decode_frame(*decoder, coded[0]);
    const ContractReport report = check_contract(*decoder, config.stages, depth);
    ASSERT_EQ(report.broken, 0U) << report.first_broken;
    expect_balance(coded[0].counts, report, config.stream, config.stages);
    if (c.tolerance == ToleranceKind::kLossless) {
      ASSERT_TRUE(std::ranges::equal(decoder->depth(), depth));
    }
  }
}

void check_all_kinds(const Recording& recording, std::size_t step) {
  check_recording(recording, kStreamCases[0], kSanitized ? step : 1);
  for (const StreamCase& c : kBounded) check_recording(recording, c, step);
}

TEST(RealDepth, RealSenseSequenceKeepsItsContract) {
  PLANECAST_NEED_DATA(folder, "depth_seq/aims_realsense");
  Recording recording{pinhole(383.8, 321.7, 236.8), {NoiseModel::Kind::kStereo, 3'000'000}, {}, {}};
  add_images(recording, folder, ".png");
  check_all_kinds(recording, kSanitized ? 60 : 20);
}

TEST(RealDepth, Kinect2StairsKeepTheirContract) {
  PLANECAST_NEED_DATA(folder, "depth_frames/stair_kinect2");
  Recording recording{pinhole(365.31, 254.68, 208.55), {NoiseModel::Kind::kTof, 3'000'000}, {}, {}};
  add_images(recording, folder, ".png");
  check_all_kinds(recording, 1);
}

TEST(RealDepth, AzureKinectFramesKeepTheirContract) {
  PLANECAST_NEED_DATA(folder, "depth_frames/azure_kinect_zdepth");
  Recording recording{pinhole(252, 160, 165), {NoiseModel::Kind::kTof, 3'000'000}, {}, {}};
  add_images(recording, folder, ".raw");
  check_all_kinds(recording, kSanitized ? 3 : 1);
}

double distance_m(const Point3f& a, const Point3f& b) {
  return std::hypot(double{a.x} - b.x, double{a.y} - b.y, double{a.z} - b.z);
}

/// A lossless cloud: the very bits, or z exactly and x, y within 2 um where z follows a grid.
void check_lossless(const StreamSetup& setup, const Point3f& in, const Point3f& out,
                    std::size_t i) {
  if (setup.encoder.stream.kind == FrameKind::kRawCloud) {
    ASSERT_EQ(std::memcmp(&in, &out, sizeof in), 0) << "point " << i;
    return;
  }
  ASSERT_EQ(in.z, out.z) << "point " << i;
  ASSERT_LE(std::hypot(double{in.x} - out.x, double{in.y} - out.y), 2e-6) << "point " << i;
}

/// Codes an organised cloud as the commands do and checks each point.
void check_cloud(const fs::path& path, const Tolerance& tolerance, OffSurface off_surface) {
  SCOPED_TRACE(path.filename().string() + " at " + to_string(tolerance));
  auto cloud = read_point_file(path);
  ASSERT_TRUE(cloud.ok()) << cloud.error().message;
  SensorFrame frame;
  frame.cloud = std::move(*cloud);
  frame.name = path.filename().string();
  CodecOptions options;
  options.tolerance = tolerance;
  options.off_surface = off_surface;
  const auto setup = setup_stream(options, {}, frame);
  ASSERT_TRUE(setup.ok()) << setup.error().message;
  auto codec = FrameCodec::create(*setup, 1190);
  ASSERT_TRUE(codec.ok()) << codec.error().message;
  const auto coded = codec->encode(*setup, frame);
  ASSERT_TRUE(coded.ok()) << coded.error().message;
  const auto decoder = make_decoder();
  ASSERT_EQ(decoder->set_key(codec->key_packet(frame)), Status::kOk);
  ASSERT_EQ(decoder->begin(), Status::kOk);
  for (const auto& packet : coded->packets) ASSERT_EQ(decoder->add(packet), Status::kOk);
  ASSERT_EQ(decoder->finish(), Status::kOk);

  const StreamConfig& config = setup->encoder.stream;
  const bool raw = config.kind == FrameKind::kRawCloud;
  const OpticalAxes axes(config);
  const std::span<const Point3f> out = decoder->cloud();
  ASSERT_EQ(out.size(), frame.cloud.points.size());
  std::uint32_t readings = 0, kept = 0;
  for (std::size_t i = 0; i < out.size(); ++i) {
    const Point3f& in = frame.cloud.points[i];
    const bool reading = raw ? std::isfinite(in.x) && std::isfinite(in.y) && std::isfinite(in.z)
                             : is_depth_reading(in);
    readings += reading;
    if (!reading) {
      ASSERT_TRUE(std::isnan(out[i].z)) << "point " << i << ": a hole was filled";
      continue;
    }
    if (std::isnan(out[i].z)) continue;
    ++kept;
    if (raw || tolerance.kind == ToleranceKind::kLossless) {
      ASSERT_NO_FATAL_FAILURE(check_lossless(*setup, in, out[i], i));
    } else {
      ASSERT_LE(distance_m(in, out[i]), setup->contract.bound_m(axes.depth(in))) << "point " << i;
    }
  }
  EXPECT_EQ(coded->counts.input, readings);
  EXPECT_EQ(coded->counts.kept, kept);
  EXPECT_EQ(readings, kept + coded->counts.off_surface_dropped);
  if (off_surface == OffSurface::kKeep) {
    EXPECT_EQ(kept, readings);
  }
}

std::vector<fs::path> organised_clouds(const fs::path& root) {
  std::vector<fs::path> out;
  for (const auto& entry : fs::recursive_directory_iterator(root)) {
    if (entry.path().extension() == ".pcd") out.push_back(entry.path());
  }
  std::ranges::sort(out);
  return out;
}

TEST(RealClouds, EveryOrganisedCloudKeepsTheLosslessContract) {
  PLANECAST_NEED_SPEED();
  PLANECAST_NEED_DATA(folder, "depth_frames");
  const auto clouds = organised_clouds(folder);
  ASSERT_GE(clouds.size(), 10U);
  for (std::size_t i = 0; i < clouds.size(); i += kSanitized ? 5 : 1) {
    check_cloud(clouds[i], {ToleranceKind::kLossless, 0}, OffSurface::kKeep);
  }
}

TEST(RealClouds, SomeOrganisedCloudsKeepBoundedContracts) {
  PLANECAST_NEED_SPEED();
  PLANECAST_NEED_DATA(folder, "depth_frames");
  const auto clouds = organised_clouds(folder);
  for (std::size_t i = 0; i < clouds.size(); i += kSanitized ? 7 : 3) {
    check_cloud(clouds[i], {ToleranceKind::kMetres, 0.010}, OffSurface::kKeep);
    check_cloud(clouds[i], {ToleranceKind::kSigma, 2}, OffSurface::kKeep);
    check_cloud(clouds[i], {ToleranceKind::kSurfaces, 3}, OffSurface::kKeep);
    check_cloud(clouds[i], {ToleranceKind::kSurfaces, 3}, OffSurface::kDrop);
  }
}

}  // namespace
}  // namespace planecast
