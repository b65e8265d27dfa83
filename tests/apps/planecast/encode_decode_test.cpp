// planecast encode and decode: what goes in comes out, file by file, or the file says what is gone.
#include <cstring>

#include "core/io/ply.hpp"
#include "tests/apps/planecast/command_runner.hpp"

namespace planecast::test {
namespace {

class EncodeDecode : public CommandTest {
 protected:
  void write_folder(std::size_t frames) {
    fs::create_directory(at("depth"));
    for (std::size_t i = 0; i < frames; ++i) {
      images_.push_back(small_frame(i));
      images_.back().depth[7] = 65535;  // invalid codes are values like any other
      images_.back().depth[8] = 1;
      write_png("depth/" + std::to_string(i + 8) + ".png", images_.back());
    }
  }
  std::vector<DepthImage> images_;
};

TEST_F(EncodeDecode, GivesEveryDepthValueOfAFolderBackInNaturalOrder) {
  write_folder(4);  // 8, 9, 10, 11: letters would put 10 first
  ASSERT_EQ(run("encode depth -o a.plc --tolerance 0").code, 0);
  const RunResult decoded = run("decode a.plc -o back --format png");
  ASSERT_EQ(decoded.code, 0) << decoded.talk;
  for (std::size_t i = 0; i < images_.size(); ++i) {
    const auto back = read_depth_png(at("back/a_00000" + std::to_string(i) + ".png"));
    ASSERT_TRUE(back.ok()) << back.error().message;
    EXPECT_EQ(back->width, images_[i].width);
    EXPECT_EQ(back->depth, images_[i].depth) << "frame " << i;
  }
}

TEST_F(EncodeDecode, GivesARawFileBackByteForByte) {
  const DepthImage image = small_frame(3);
  ASSERT_TRUE(write_depth_raw(at("a.raw"), image).ok());
  ASSERT_EQ(run("encode a.raw --size 160x120 -o a.plc --tolerance 0").code, 0);
  ASSERT_EQ(run("decode a.plc -o b.raw").code, 0);
  EXPECT_EQ(bytes_of("b.raw"), bytes_of("a.raw"));
}

TEST_F(EncodeDecode, KeepsDepthOfAGridCloudExactAndItsViewpoint) {
  PointCloud cloud = cloud_of(small_frame(0), 95.75F, 79.5F, 59.5F);
  cloud.viewpoint = {0.5, 0.5, -0.5, 0.5, 1.25, -2, 0.75};
  write_cloud("a.pcd", cloud);
  const RunResult encoded = run("encode a.pcd -o a.plc --tolerance 0");
  ASSERT_EQ(encoded.code, 0) << encoded.talk;
  EXPECT_FALSE(encoded.says("float32 coordinates")) << encoded.talk;
  ASSERT_EQ(run("decode a.plc -o b.pcd").code, 0);
  const auto back = read_pcd(at("b.pcd"));
  ASSERT_TRUE(back.ok());
  ASSERT_EQ(back->width, cloud.width);
  ASSERT_EQ(back->height, cloud.height);
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    ASSERT_EQ(is_hole(back->points[i]), is_hole(cloud.points[i])) << i;
    if (is_hole(cloud.points[i])) continue;
    ASSERT_EQ(back->points[i].z, cloud.points[i].z) << i;
    ASSERT_NEAR(back->points[i].x, cloud.points[i].x, 2e-6) << i;
    ASSERT_NEAR(back->points[i].y, cloud.points[i].y, 2e-6) << i;
  }
  EXPECT_NEAR(back->viewpoint.qy, -0.5, 1e-6);
  EXPECT_NEAR(back->viewpoint.ty, -2, 1e-6);
}

// 40 x 30 points anywhere, the sixth a hole.
PointCloud cameraless_cloud() {
  PointCloud cloud;
  cloud.width = 40;
  cloud.height = 30;
  Pcg32 random(7);
  for (int i = 0; i < 1200; ++i) {
    const auto value = [&] { return static_cast<float>(random.uniform() * 8 - 4); };
    cloud.points.push_back({value(), value(), value()});
  }
  cloud.points[5] = {std::nanf(""), std::nanf(""), std::nanf("")};
  return cloud;
}

TEST_F(EncodeDecode, CodesACloudWithoutACameraAsAListWhereThereIsABound) {
  const PointCloud cloud = cameraless_cloud();
  write_cloud("a.pcd", cloud);
  const RunResult encoded = run("encode a.pcd -o a.plc --tolerance 10mm");
  ASSERT_EQ(encoded.code, 0) << encoded.talk;
  EXPECT_TRUE(encoded.says("coded as a list of points without order")) << encoded.talk;
  ASSERT_EQ(run("decode a.plc -o b.ply").code, 0);
  EXPECT_EQ(run("compare a.pcd b.ply --max-error 10mm").code, 0);
  EXPECT_EQ(run("compare a.pcd b.ply --max-error 1mm").code, 5);
  const auto back = read_ply(at("b.ply"));
  ASSERT_TRUE(back.ok());
  EXPECT_EQ(back->points.size(), 1199U);
  EXPECT_LT(bytes_of("a.plc").size(), 1199U * 9);
}

TEST_F(EncodeDecode, GivesACloudWithoutACameraBackBitForBit) {
  const PointCloud cloud = cameraless_cloud();
  write_cloud("a.pcd", cloud);
  const RunResult encoded = run("encode a.pcd -o a.plc --tolerance 0");
  ASSERT_EQ(encoded.code, 0);
  EXPECT_TRUE(encoded.says("float32 coordinates are coded losslessly")) << encoded.talk;
  ASSERT_EQ(run("decode a.plc -o b.pcd").code, 0);
  const auto back = read_pcd(at("b.pcd"));
  ASSERT_TRUE(back.ok());
  for (std::size_t i = 0; i < cloud.points.size(); ++i) {
    if (i == 5)
      EXPECT_TRUE(is_hole(back->points[i]));
    else
      ASSERT_EQ(std::memcmp(&back->points[i], &cloud.points[i], sizeof(Point3f)), 0) << i;
  }
  EXPECT_EQ(run("decode a.plc -o b.png").code, 2);  // there is no depth to write
}

TEST_F(EncodeDecode, HoldsTheBoundOfACloudTurnedAwayFromItsCamera) {
  PointCloud cloud = cloud_of(small_frame(0), 95.75F, 79.5F, 59.5F);
  for (Point3f& p : cloud.points) p = {0.6F * p.x - 0.8F * p.z, p.y, 0.8F * p.x + 0.6F * p.z};
  write_cloud("a.pcd", cloud);
  const RunResult encoded = run("encode a.pcd -o a.plc --tolerance 5mm");
  ASSERT_EQ(encoded.code, 0) << encoded.talk;
  EXPECT_FALSE(encoded.says("float32 coordinates")) << encoded.talk;
  ASSERT_EQ(run("decode a.plc -o b.pcd").code, 0);
  EXPECT_LT(bytes_of("a.plc").size(), cloud.points.size() * 12 / 10);
  EXPECT_EQ(run("compare a.pcd b.pcd --max-error 5mm").code, 0);
  EXPECT_EQ(run("compare a.pcd b.pcd --max-error 0.5mm").code, 5);
}

TEST_F(EncodeDecode, BeginsAStreamWhereTheCameraChanges) {
  const DepthImage image = small_frame(0);
  write_cloud("1.pcd", cloud_of(image, 95.75F, 79.5F, 59.5F));
  write_cloud("2.pcd", cloud_of(image, 110.0F, 79.5F, 59.5F));
  const RunResult encoded = run("encode 1.pcd 2.pcd -o a.plc --tolerance 5mm");
  ASSERT_EQ(encoded.code, 0) << encoded.talk;
  EXPECT_TRUE(encoded.says("a new stream begins"));
  EXPECT_EQ(run("info a.plc --json").json()["key_packet_count"], 2);
  ASSERT_EQ(run("decode a.plc -o back --format pcd").code, 0);
  EXPECT_EQ(run("compare 1.pcd back/a_000000.pcd --max-error 5mm").code, 0);
  EXPECT_EQ(run("compare 2.pcd back/a_000001.pcd --max-error 5mm").code, 0);
}

TEST_F(EncodeDecode, KeepsThePoseOfEachFrameOfAMovingCamera) {
  ASSERT_EQ(run("encode sim:room:2 --size 160x120 -o a.plc").code, 0);
  ASSERT_EQ(run("decode a.plc -o back --format pcd").code, 0);
  const auto first = read_pcd(at("back/a_000000.pcd"));
  const auto second = read_pcd(at("back/a_000001.pcd"));
  ASSERT_TRUE(first.ok() && second.ok());
  EXPECT_NEAR(first->viewpoint.tz, 1.25, 0.2);  // eye height
  EXPECT_NE(first->viewpoint.qw, second->viewpoint.qw);
}

TEST_F(EncodeDecode, WritesEveryPointFormatWithTheSamePoints) {
  ASSERT_EQ(run("encode sim:room:1 --size 160x120 -o a.plc --tolerance 10mm").code, 0);
  for (const std::string format : {"ply", "pcd", "bin", "xyz"}) {
    ASSERT_EQ(run("decode a.plc -o a." + format).code, 0) << format;
    EXPECT_EQ(run("compare a.ply a." + format + " --max-error 1um").code, 0) << format;
  }
}

TEST_F(EncodeDecode, WritesTheSameBytesTwice) {
  ASSERT_EQ(run("encode sim:room:3 --size 160x120 -o a.plc").code, 0);
  ASSERT_EQ(run("encode sim:room:3 --size 160x120 -o b.plc").code, 0);
  EXPECT_EQ(bytes_of("a.plc"), bytes_of("b.plc"));
}

TEST_F(EncodeDecode, CutsSlicesOfTheWireWhenAsked) {
  ASSERT_EQ(run("encode sim:room:1 --size 160x120 -o a.plc --slice-bytes 400 --tolerance 0").code,
            0);
  const auto info = run("info a.plc --json").json();
  ASSERT_GT(info["frames"][0]["slice_count"], 5);
  for (const auto& slice : info["frames"][0]["slices"]) EXPECT_LE(slice["bytes"], 390);
}

TEST_F(EncodeDecode, GivesTheWholeFramesOfACutFile) {
  write_folder(3);
  ASSERT_EQ(run("encode depth -o a.plc --tolerance 0").code, 0);
  auto bytes = bytes_of("a.plc");
  bytes.resize(bytes.size() * 3 / 4);  // within the last frame
  write_bytes("cut.plc", bytes);
  const RunResult decoded = run("decode cut.plc -o back --format png");
  EXPECT_EQ(decoded.code, 0);
  EXPECT_TRUE(decoded.says("was cut")) << decoded.talk;
  EXPECT_EQ(read_depth_png(at("back/cut_000001.png"))->depth, images_[1].depth);
  EXPECT_FALSE(fs::exists(at("back/cut_000002.png")));
}

TEST_F(EncodeDecode, RefusesAFileCutBeforeItsFirstFrame) {
  write_folder(1);
  ASSERT_EQ(run("encode depth -o a.plc --tolerance 0").code, 0);
  for (const std::size_t size :
       {std::size_t{0}, std::size_t{5}, std::size_t{8}, std::size_t{400}}) {
    auto bytes = bytes_of("a.plc");
    bytes.resize(size);
    write_bytes("cut.plc", bytes);
    EXPECT_EQ(run("decode cut.plc -o b.png").code, 3) << size;
    EXPECT_FALSE(fs::exists(at("b.png")));
  }
}

TEST_F(EncodeDecode, NamesDamageAndDecodesTheRest) {
  write_folder(2);
  ASSERT_EQ(run("encode depth -o a.plc --tolerance 0 --slice-bytes 600").code, 0);
  auto bytes = bytes_of("a.plc");
  bytes[bytes.size() / 4] ^= 0x40U;  // within frame 0
  write_bytes("bad.plc", bytes);
  const RunResult decoded = run("decode bad.plc -o back --format png");
  EXPECT_EQ(decoded.code, 3);
  EXPECT_TRUE(decoded.says("damaged")) << decoded.talk;
  EXPECT_EQ(read_depth_png(at("back/bad_000001.png"))->depth, images_[1].depth);
  const auto holed = read_depth_png(at("back/bad_000000.png"));
  ASSERT_TRUE(holed.ok());
  for (std::size_t i = 0; i < holed->depth.size(); ++i) {
    if (holed->depth[i] != 0) ASSERT_EQ(holed->depth[i], images_[0].depth[i]) << i;
  }
}

TEST_F(EncodeDecode, LeavesNothingBehindWhenAFrameFails) {
  write_folder(2);
  DepthImage other{80, 60, std::vector<std::uint16_t>(4800, 1000)};
  write_png("depth/99.png", other);
  const RunResult encoded = run("encode depth -o a.plc --tolerance 0");
  EXPECT_EQ(encoded.code, 3);
  EXPECT_TRUE(encoded.says("99.png: is 80x60, but the frames before it are 160x120"))
      << encoded.talk;
  EXPECT_FALSE(fs::exists(at("a.plc")));
  EXPECT_TRUE(hidden_files().empty());
}

TEST_F(EncodeDecode, AsksForAFolderWhenThereAreManyFrames) {
  ASSERT_EQ(run("encode sim:room:2 --size 160x120 -o a.plc").code, 0);
  const RunResult decoded = run("decode a.plc -o b.ply");
  EXPECT_EQ(decoded.code, 2);
  EXPECT_TRUE(decoded.says("folder")) << decoded.talk;
}

TEST_F(EncodeDecode, PlaysTheInputAgainWhenTold) {
  ASSERT_EQ(run("encode sim:room:2 --size 160x120 --repeat 3 -o a.plc").code, 0);
  const auto info = run("info a.plc --json").json();
  EXPECT_EQ(info["frame_count"], 6);
  EXPECT_EQ(info["frames"][5]["frame"], 5);
}

}  // namespace
}  // namespace planecast::test
