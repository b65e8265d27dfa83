// planecast eval, compare, info and doctor: figures that add up.
#include "tests/apps/planecast/command_runner.hpp"

namespace planecast::test {
namespace {

class Eval : public CommandTest {};
class Compare : public CommandTest {};
class Info : public CommandTest {};
class Doctor : public CommandTest {};

TEST_F(Eval, PrintsEveryFigureOfEachFrameAndTheirMean) {
  const RunResult result = run("eval sim:room:2 --size 160x120 --tolerance 2sigma --json");
  ASSERT_EQ(result.code, 0) << result.talk;
  const auto report = result.json();
  ASSERT_EQ(report["frames"].size(), 2);
  for (const char* key :
       {"points_in", "points_out", "points_dropped", "points_out_of_range", "bytes",
        "bits_per_point", "wire_bytes", "slices", "ratio_percent", "d1_ab_mm", "d1_ba_mm", "d1_mm",
        "d2_mm", "max_mm", "encode_ms", "decode_ms", "surfaces"}) {
    ASSERT_TRUE(report["frames"][0][key].is_number()) << key;
    const double mean =
        (report["frames"][0][key].get<double>() + report["frames"][1][key].get<double>()) / 2;
    EXPECT_NEAR(report["mean"][key].get<double>(), mean, 1e-9 + mean * 1e-12) << key;
  }
  EXPECT_EQ(report["sensor"]["camera"]["width"], 160);
  EXPECT_EQ(report["bound_held"], true);
}

TEST_F(Eval, FiguresAgreeWithEachOther) {
  const auto frame =
      run("eval sim:room:1 --size 160x120 --tolerance 60mm --json").json()["frames"][0];
  const double points = frame["points_in"], bytes = frame["bytes"];
  EXPECT_NEAR(frame["bits_per_point"].get<double>(), bytes * 8 / points, 1e-9);
  EXPECT_NEAR(frame["ratio_percent"].get<double>(), (1 - bytes / (12 * points)) * 100, 1e-9);
  EXPECT_NEAR(frame["d1_mm"].get<double>(),
              (frame["d1_ab_mm"].get<double>() + frame["d1_ba_mm"].get<double>()) / 2, 1e-9);
  EXPECT_EQ(frame["points_in"], frame["points_out"]);
  EXPECT_GT(frame["wire_bytes"], frame["bytes"]);
  EXPECT_GT(frame["max_mm"], 0.0);
  EXPECT_LE(frame["max_mm"], 60.0);
  EXPECT_LE(frame["d1_ab_mm"], frame["max_mm"]);
  EXPECT_GT(frame["encode_ms"], 0.0);
  EXPECT_GT(frame["decode_ms"], 0.0);
}

TEST_F(Eval, WireBytesCountEnvelopesAndKeyPackets) {
  const std::string options = "sim:room:1 --size 160x120 --tolerance 0 --slice-bytes 500";
  const auto frame = run("eval " + options + " --json").json()["frames"][0];
  ASSERT_EQ(run("encode " + options + " -o a.plc").code, 0);
  const auto info = run("info a.plc --json").json();
  const std::uint64_t slices = info["frames"][0]["slice_count"];
  const std::uint64_t key = info["key_packets"][0]["bytes"];
  EXPECT_EQ(frame["slices"], slices);
  // 30 Hz: a key packet each 7 frames; 10 bytes of envelope a packet.
  const std::uint64_t bytes = info["frames"][0]["bytes"];
  EXPECT_EQ(frame["wire_bytes"], bytes + slices * 10 + (key + 10 + 6) / 7);
}

TEST_F(Eval, ReportsNoErrorAtAllForLosslessDepth) {
  const auto frame = run("eval sim:room:1 --size 160x120 --tolerance 0 --json").json()["frames"][0];
  for (const char* key : {"d1_ab_mm", "d1_ba_mm", "d1_mm", "d2_mm", "max_mm", "bound_utilisation"})
    EXPECT_EQ(frame[key], 0.0) << key;
}

TEST_F(Eval, CountsWhatRangeTakesAwayApartFromPointsIn) {
  DepthImage image = small_frame(0);
  const auto readings = static_cast<std::uint32_t>(
      image.depth.size() - std::count(image.depth.begin(), image.depth.end(), 0));
  const auto outside = static_cast<std::uint32_t>(
      std::count_if(image.depth.begin(), image.depth.end(),
                    [](std::uint16_t d) { return d != 0 && (d < 1500 || d > 3000); }));
  ASSERT_GT(outside, 0);
  write_png("a.png", image);
  const std::string options = std::string(kSmallCamera) + " --range 1.5,3 --tolerance 0 --json";
  const auto frame = run("eval a.png" + options).json()["frames"][0];
  EXPECT_EQ(frame["points_out_of_range"], outside);
  EXPECT_EQ(frame["points_in"], readings - outside);
  EXPECT_EQ(frame["points_out"], readings - outside);
}

TEST_F(Eval, GatesRawCloudsByDistance) {
  PointCloud cloud;
  cloud.width = 20;
  cloud.height = 10;
  Pcg32 random(3);
  const auto value = [&] { return static_cast<float>(random.uniform() * 2 - 1); };
  for (int i = 0; i < 200; ++i) cloud.points.push_back({value(), value(), value()});
  for (int i = 0; i < 30; ++i) cloud.points[i] = {9, 9, 9};
  write_cloud("a.pcd", cloud);
  const RunResult result = run("eval a.pcd --range 0,5 --tolerance 0 --json");
  ASSERT_EQ(result.code, 0) << result.talk;
  EXPECT_EQ(result.json()["frames"][0]["points_out_of_range"], 30);
  EXPECT_EQ(result.json()["frames"][0]["points_out"], 170);
}

TEST_F(Eval, CountsEveryPointThatSurfacesDrop) {
  const auto frame =
      run("eval sim:room:1 --size 160x120 --tolerance surfaces --off-surface drop --json")
          .json()["frames"][0];
  EXPECT_GT(frame["points_dropped"], 0);
  EXPECT_EQ(frame["points_in"].get<int>(),
            frame["points_out"].get<int>() + frame["points_dropped"].get<int>());
  EXPECT_EQ(frame["on_surface"], frame["points_out"]);
  EXPECT_GT(frame["d1_ab_mm"], frame["d1_ba_mm"]);  // those dropped are far from what is left
  const auto kept =
      run("eval sim:room:1 --size 160x120 --tolerance surfaces --json").json()["frames"][0];
  EXPECT_EQ(frame["off_surface_dropped"], frame["points_dropped"]);
  EXPECT_EQ(kept["points_dropped"], 0);
  EXPECT_GT(kept["off_surface"], 0);
  EXPECT_EQ(kept["points_in"].get<int>(),
            kept["on_surface"].get<int>() + kept["off_surface"].get<int>());
}

TEST_F(Eval, DropsOutliersOnlyWhenAskedAndCountsThem) {
  DepthImage image{64, 48, std::vector<std::uint16_t>(64 * 48, 2000)};
  image.depth[64 * 20 + 30] = 900;  // far from all its neighbours
  write_png("a.png", image);
  const std::string base = "eval a.png --camera 60,60,31.5,23.5 --tolerance 0 --json";
  const auto kept = run(base).json()["frames"][0];
  EXPECT_EQ(kept["points_dropped"], 0);
  const auto dropped = run(base + " --outliers drop").json()["frames"][0];
  EXPECT_GE(dropped["outliers"], 1);
  EXPECT_EQ(dropped["points_dropped"], dropped["outliers"]);
  EXPECT_EQ(dropped["points_out"].get<int>(), 64 * 48 - dropped["points_dropped"].get<int>());
}

TEST_F(Eval, PrintsARowAFrameAndTheMean) {
  const RunResult result = run("eval sim:room:3 --size 160x120");
  ASSERT_EQ(result.code, 0);
  EXPECT_EQ(std::count(result.out.begin(), result.out.end(), '\n'), 6);  // two lines of head
  EXPECT_NE(result.out.find("sim:room#2"), std::string::npos);
  EXPECT_NE(result.out.find("\nmean"), std::string::npos);
}

TEST_F(Eval, NamesFieldsThatItDoesNotCarry) {
  write_text("a.pcd",
             "VERSION .7\nFIELDS x y z intensity\nSIZE 4 4 4 4\nTYPE F F F F\nCOUNT 1 1 1 1\n"
             "WIDTH 2\nHEIGHT 2\nVIEWPOINT 0 0 0 1 0 0 0\nPOINTS 4\nDATA ascii\n"
             "0 0 1 7\n1 0 1 8\n0 1 1 9\n1 1 1.5 9\n");
  const RunResult result = run("eval a.pcd --tolerance 0 --json");
  ASSERT_EQ(result.code, 0) << result.talk;
  EXPECT_TRUE(result.says("intensity")) << result.talk;
  EXPECT_NE(result.json()["notes"].dump().find("intensity"), std::string::npos);
}

TEST_F(Compare, MeasuresAKnownShift) {
  PointCloud cloud = cloud_of(small_frame(0), 95.75F, 79.5F, 59.5F);
  write_cloud("a.pcd", cloud);
  for (Point3f& p : cloud.points) p.y += 0.0005F;  // far less than the points' spacing
  write_cloud("b.pcd", cloud);
  const auto far = run("compare a.pcd b.pcd --json").json();
  EXPECT_NEAR(far["d1_ab_mm"].get<double>(), 0.5, 1e-3);
  EXPECT_NEAR(far["d1_ba_mm"].get<double>(), 0.5, 1e-3);
  EXPECT_NEAR(far["max_corresponding_mm"].get<double>(), 0.5, 1e-3);
  EXPECT_EQ(run("compare a.pcd b.pcd --max-error 0.6mm").code, 0);
  EXPECT_EQ(run("compare a.pcd b.pcd --max-error 0.4mm").code, 5);
}

TEST_F(Compare, SeesThatPointsAreMissing) {
  PointCloud cloud = cloud_of(small_frame(0), 95.75F, 79.5F, 59.5F);
  write_cloud("a.pcd", cloud);
  for (std::size_t i = 0; i < cloud.points.size() / 2; ++i) cloud.points[i].x = std::nanf("");
  write_cloud("b.pcd", cloud);
  const RunResult result = run("compare a.pcd b.pcd --max-error 10mm --json");
  EXPECT_EQ(result.code, 5);
  EXPECT_GT(result.json()["only_a"], 0);
  EXPECT_EQ(result.json()["only_b"], 0);
  EXPECT_EQ(run("compare b.pcd b.pcd --max-error 0").code, 0);
}

TEST_F(Compare, TakesDepthImagesWithTheirCamera) {
  const DepthImage image = small_frame(0);
  write_png("a.png", image);
  write_cloud("b.pcd", cloud_of(image, 95.75F, 79.5F, 59.5F));
  EXPECT_EQ(run("compare a.png b.pcd --max-error 10um" + std::string(kSmallCamera)).code, 0);
  const RunResult result = run("compare a.png b.pcd");
  EXPECT_EQ(result.code, 2);
  EXPECT_TRUE(result.says("--camera")) << result.talk;
}

TEST_F(Info, ShowsKeyPacketSlicesAndSurfaces) {
  ASSERT_EQ(run("encode sim:room:1 --size 160x120 --tolerance 2sigma -o a.plc").code, 0);
  const auto info = run("info a.plc --json").json();
  const auto& key = info["key_packets"][0];
  EXPECT_EQ(key["camera"]["width"], 160);
  EXPECT_EQ(key["noise"], "stereo:0.003");
  EXPECT_EQ(key["tolerance"]["sigmas"], 2.0);
  EXPECT_EQ(key["frame_id"], "camera_optical");
  const auto& slice = info["frames"][0]["slices"][0];
  EXPECT_EQ(slice["key_hash"], key["hash"]);
  EXPECT_GT(slice["points"], 10000);
  EXPECT_EQ(slice["tile_pixels_u0_v0_u1_v1"], nlohmann::json({0, 0, 160, 120}));
  // Without a bound no block is flat, and the room's walls are worth a surface each.
  ASSERT_EQ(run("encode sim:room:1 --size 160x120 --tolerance 0 -o exact.plc").code, 0);
  const auto exact = run("info exact.plc --json").json();
  EXPECT_GT(exact["frames"][0]["slices"][0]["surfaces"].size(), 2);
  const RunResult text = run("info a.plc");
  EXPECT_NE(text.out.find("noise: stereo:0.003"), std::string::npos) << text.out;
  EXPECT_NE(text.out.find("inverse_depth_per_m"), std::string::npos);
}

TEST_F(Doctor, SaysInJsonWhatItsExitCodeSays) {
  const RunResult result = run("doctor --lcm-url memq:// --json");
  EXPECT_EQ(result.code, 0);
  EXPECT_EQ(result.json()["usable"], true);
  EXPECT_FALSE(result.json()["checks"].empty());
}

TEST_F(Doctor, RefusesAMalformedUrl) {
  for (const std::string url :
       {"bogus", "udpm://10.0.0.1:7667", "udpm://239.255.76.67:7667?ttl=300"}) {
    const RunResult result = run("doctor --lcm-url '" + url + "'");
    EXPECT_EQ(result.code, 2) << url;
    EXPECT_TRUE(result.says("--lcm-url")) << result.talk;
  }
}

}  // namespace
}  // namespace planecast::test
