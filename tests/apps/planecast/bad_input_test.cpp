// Bad input: each a clear error with its exit code, or an empty but valid frame; never a crash, and
// nothing silently skipped.
#include "tests/apps/planecast/command_runner.hpp"

namespace planecast::test {
namespace {

class BadInput : public CommandTest {
 protected:
  void refuses(const std::string& arguments, int code, const std::string& words) const {
    const RunResult result = run(arguments);
    EXPECT_EQ(result.code, code) << arguments << "\n" << result.talk;
    EXPECT_TRUE(result.says(words)) << arguments << "\n" << result.talk;
  }
  // Encodes and decodes a frame without any reading.
  void passes_empty(const std::string& input) const {
    const RunResult result = run("eval " + input + " --json");
    ASSERT_EQ(result.code, 0) << result.talk;
    EXPECT_EQ(result.json()["frames"][0]["points_in"], 0);
    EXPECT_EQ(result.json()["frames"][0]["points_out"], 0);
    ASSERT_EQ(run("encode " + input + " -o a.plc").code, 0);
    EXPECT_EQ(run("decode a.plc -o back.pcd").code, 0);
  }
};

PointCloud all_nan(std::uint32_t width, std::uint32_t height) {
  const float nan = std::nanf("");
  PointCloud cloud;
  cloud.width = width;
  cloud.height = height;
  cloud.points.assign(std::size_t{width} * height, Point3f{nan, nan, nan});
  return cloud;
}

TEST_F(BadInput, TruncatedPng) {
  write_png("a.png", small_frame(0));
  auto bytes = bytes_of("a.png");
  bytes.resize(bytes.size() / 2);
  write_bytes("a.png", bytes);
  for (const std::string command :
       {"eval a.png --tolerance 0", "encode a.png -o a.plc --tolerance 0"})
    refuses(command, 3, "a.png");
  EXPECT_FALSE(fs::exists(at("a.plc")));
}

TEST_F(BadInput, TruncatedPcd) {
  write_cloud("a.pcd", cloud_of(small_frame(0), 95.75F, 79.5F, 59.5F));
  auto bytes = bytes_of("a.pcd");
  bytes.resize(bytes.size() / 2);
  write_bytes("a.pcd", bytes);
  refuses("eval a.pcd", 3, "a.pcd");
}

TEST_F(BadInput, RawOfTheWrongSizeOrWithout) {
  ASSERT_TRUE(write_depth_raw(at("a.raw"), small_frame(0)).ok());
  refuses("eval a.raw --size 161x120 --tolerance 0", 3, "a.raw");
  refuses("eval a.raw --tolerance 0", 2, "--size");
}

TEST_F(BadInput, ZeroWidth) {
  write_text("a.pcd",
             "VERSION .7\nFIELDS x y z\nSIZE 4 4 4\nTYPE F F F\nCOUNT 1 1 1\nWIDTH 0\nHEIGHT 4\n"
             "VIEWPOINT 0 0 0 1 0 0 0\nPOINTS 0\nDATA ascii\n");
  const RunResult result = run("eval a.pcd");
  EXPECT_EQ(result.code, 3) << result.talk;
  refuses("eval a.raw --size 0x120", 2, "--size");
}

TEST_F(BadInput, NanPointsMakeAnEmptyFrame) {
  write_cloud("a.pcd", all_nan(16, 8));
  passes_empty("a.pcd");
}

TEST_F(BadInput, AllHolesMakeAnEmptyFrame) {
  write_png("a.png", {160, 120, std::vector<std::uint16_t>(160 * 120, 0)});
  passes_empty("a.png" + std::string(kSmallCamera));
  passes_empty("a.png --tolerance 0");
}

TEST_F(BadInput, OnePixelIsAFrame) {
  write_png("a.png", {1, 1, {1234}});
  ASSERT_EQ(run("eval a.png --camera 10,10,0,0 --tolerance 10mm").code, 0);
  ASSERT_EQ(run("encode a.png -o a.plc --tolerance 0").code, 0);
  ASSERT_EQ(run("decode a.plc -o b.png").code, 0);
  EXPECT_EQ(read_depth_png(at("b.png"))->depth, std::vector<std::uint16_t>{1234});
}

TEST_F(BadInput, IntrinsicsOfZero) {
  write_png("a.png", small_frame(0));
  refuses("eval a.png --camera 0,0,0,0", 2, "--camera");
  refuses("eval a.png --camera 383,383", 2, "--camera");
}

TEST_F(BadInput, ACameraIsNeededWhereTheBoundIsInMetres) {
  write_png("a.png", small_frame(0));
  refuses("eval a.png --tolerance 10mm", 2, "--camera");
}

TEST_F(BadInput, APresetForAnImageOfAnotherShape) {
  write_png("a.png", {100, 100, std::vector<std::uint16_t>(10000, 900)});
  refuses("eval a.png --camera kinect1", 2, "100x100");
}

TEST_F(BadInput, AFolderOfMixedSizes) {
  fs::create_directory(at("mixed"));
  write_png("mixed/1.png", {8, 8, std::vector<std::uint16_t>(64, 900)});
  write_png("mixed/2.png", {9, 8, std::vector<std::uint16_t>(72, 900)});
  refuses("eval mixed --tolerance 0", 3, "2.png: is 9x8");
}

TEST_F(BadInput, AListWhoseNoiseGrowsWithADepthItDoesNotHave) {
  write_text("a.xyz", "0 0 1\n1 0 1\n0 1 1\n");
  refuses("eval a.xyz --noise stereo:0.003", 2, "tof:0.005");
  refuses("eval a.xyz --tolerance 1mm --max-points 2", 3, "--max-points 3");
}

TEST_F(BadInput, MissingFilesAndFormatsNotRead) {
  write_png("depth.png", small_frame(0));
  refuses("eval dept.png --tolerance 0", 3, "depth.png");
  write_text("a.las", "LASF");
  refuses("eval a.las", 3, "a.las");
  refuses("eval sim:street", 2, "sim:scan");
  refuses("eval lcm:CAMERA", 2, "planecastd");
  refuses("eval", 2, "no input");
  refuses("eval sim:room:0", 2, "sim:room");
}

TEST_F(BadInput, UnknownOptionsAndCommandsNameTheNearest) {
  refuses("eval sim:room:1 --tolerence 0", 2, "--tolerance");
  refuses("evel sim:room:1", 2, "eval");
  refuses("decode a.plc -o b --tolerance 0", 2, "--tolerance");
  refuses("eval sim:room:1 --tolerance 10", 2, "--tolerance");
}

TEST_F(BadInput, OptionsThatContradict) {
  refuses("eval sim:room:1 --off-surface drop", 2, "--tolerance surfaces");
  refuses("eval sim:room:1 --method paper --tolerance 10mm", 2, "surfaces[:K]");
  refuses("eval sim:room:1 --repeat 0", 2, "--repeat");
  refuses("eval sim:room:1 --size 160x120 --slice-bytes 256", 2, "--slice-bytes");
  refuses("encode sim:room:1", 2, "-o OUT.plc");
  refuses("encode sim:room:1 -o a.ply", 2, ".plc");
  refuses("compare a.pcd", 2, "two clouds");
}

TEST_F(BadInput, OutputThatCannotBeWritten) {
  refuses("encode sim:room:1 --size 160x120 -o none/a.plc", 1, "folder");
  ASSERT_EQ(run("encode sim:room:1 --size 160x120 -o a.plc").code, 0);
  refuses("decode a.plc -o none/a.ply", 1, "folder");
  refuses("decode a.plc -o a.tiff", 2, "tiff");
  refuses("decode a.plc -o a.ply --format pcd", 2, "--format");
  refuses("decode a.plc", 2, "-o");
}

TEST_F(BadInput, FilesThatAreNoPlc) {
  write_text("a.plc", "this is no packet file at all");
  for (const std::string command : {"decode a.plc -o b.ply", "info a.plc"})
    refuses(command, 3, "a.plc: byte 0");
  ASSERT_EQ(run("encode sim:room:1 --size 160x120 -o b.plc").code, 0);
  auto bytes = bytes_of("b.plc");
  bytes[4] = 9;
  write_bytes("b.plc", bytes);
  refuses("info b.plc", 3, "version 9");
  refuses("info none.plc", 3, "none.plc");
  refuses("info", 2, ".plc");
}

}  // namespace
}  // namespace planecast::test
