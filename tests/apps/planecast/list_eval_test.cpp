// eval, encode and decode of lists of points: files of every kind, and the scanning laser.
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <functional>
#include <string>

#include "core/io/pcd.hpp"
#include "core/io/ply.hpp"
#include "tests/apps/planecast/command_runner.hpp"

namespace planecast::test {
namespace {

class ListEval : public CommandTest {};

constexpr const char* kScan = "sim:scan:1 --size 120x40";

TEST_F(ListEval, HoldsEveryToleranceOnAScanAndSaysWhatItChose) {
  for (const std::string tolerance : {"0", "10mm", "1mm", "2sigma"}) {
    const RunResult result =
        run(std::string("eval ") + kScan + " --tolerance " + tolerance + " --json");
    ASSERT_EQ(result.code, 0) << tolerance << result.talk;
    const auto report = result.json();
    const auto frame = report["frames"][0];
    EXPECT_TRUE(report["bound_held"]);
    EXPECT_EQ(report["sensor"]["kind"], "points");
    EXPECT_EQ(frame["points_in"], frame["points_out"]) << tolerance;
    EXPECT_GT(frame["points_in"], 4000);
    const double bound = tolerance == "0"      ? 0
                         : tolerance == "10mm" ? 10
                         : tolerance == "1mm"  ? 1
                                               : 8;
    EXPECT_LE(frame["max_mm"], bound) << tolerance;
    EXPECT_LE(frame["d1_ab_mm"], frame["max_mm"]);
    EXPECT_GT(frame["wire_bytes"], 0);
  }
}

TEST_F(ListEval, TheDefaultToleranceComesFromTheRoughnessOfTheFirstFrame) {
  std::string text = "# x y z intensity\n";
  Pcg32 random(3);
  for (int i = 0; i < 3000; ++i) {
    const double x = random.uniform(), y = random.uniform();
    double noise = 0;
    for (int k = 0; k < 12; ++k) noise += random.uniform() - 0.5;  // about normal, deviation 1
    text +=
        std::to_string(x) + " " + std::to_string(y) + " " + std::to_string(0.004 * noise) + " 7\n";
  }
  write_text("a.xyz", text);
  const RunResult result = run("eval a.xyz --json");
  ASSERT_EQ(result.code, 0) << result.talk;
  EXPECT_TRUE(result.says("from the roughness of its surfaces")) << result.talk;
  EXPECT_TRUE(result.says("intensity")) << result.talk;  // not carried
  const std::string noise = result.json()["sensor"]["noise"];
  ASSERT_EQ(noise.rfind("tof:", 0), 0U) << noise;
  EXPECT_NEAR(std::stod(noise.substr(4)), 0.004, 0.001);
}

TEST_F(ListEval, MappedDataGoesThroughInDoubleAndComesBackWithItsOffset) {
  write_text("a.txt",
             "691000.125 5334000.250 500.5\n691001.125 5334002.250 501.0\n"
             "691002.000 5334003.500 499.75\n");
  ASSERT_EQ(run("encode a.txt -o a.plc --tolerance 10mm").code, 0);
  for (const std::string name : {"b.ply", "b.txt", "b.pcd"}) {
    ASSERT_EQ(run("decode a.plc -o " + name).code, 0) << name;
    const RunResult compared = run("compare a.txt " + name + " --max-error 10mm --json");
    EXPECT_EQ(compared.code, 0) << name << compared.out;
    EXPECT_EQ(compared.json()["points_b"], 3);
  }
  EXPECT_NE(text_of("b.txt").find("5334002.2"), std::string::npos) << text_of("b.txt");
  const RunResult bin = run("decode a.plc -o b.bin");  // float32 only
  EXPECT_EQ(bin.code, 2);
  EXPECT_TRUE(bin.says("PLY or PCD")) << bin.talk;
}

TEST_F(ListEval, FramesOfDifferentSizesAreOneStream) {
  write_text("1.xyz", "0 0 1\n1 0 1\n0 1 1\n");
  write_text("2.xyz", "0 0 1\n1 0 1\n");
  const RunResult result = run("eval 1.xyz 2.xyz --tolerance 1mm --json");
  ASSERT_EQ(result.code, 0) << result.talk;
  EXPECT_EQ(result.json()["frames"][0]["points_out"], 3);
  EXPECT_EQ(result.json()["frames"][1]["points_out"], 2);
}

TEST_F(ListEval, CoordinatesOnAGridOfTheFileCostLessThanTheirBits) {
  std::string grid, bits;
  Pcg32 random(9);
  for (int i = 0; i < 2000; ++i) {
    const auto mm = [&] { return std::to_string(random.below(4000)) + "e-3 "; };
    grid += mm() + mm() + mm() + "\n";
    const auto any = [&] { return std::to_string(4 * random.uniform() + 1e-7) + "137 "; };
    bits += any() + any() + any() + "\n";
  }
  write_text("grid.xyz", grid);
  write_text("bits.xyz", bits);
  const auto bytes = [&](const std::string& name) {
    const RunResult result = run("eval " + name + " --tolerance 0 --json");
    EXPECT_EQ(result.code, 0) << result.talk;
    EXPECT_EQ(result.json()["frames"][0]["max_mm"], 0.0);
    return result.json()["frames"][0]["bytes"].get<int>();
  };
  EXPECT_LT(3 * bytes("grid.xyz"), 2 * bytes("bits.xyz"));
}

TEST_F(ListEval, OddCloudsGiveAResultOrAClearError) {
  write_text("one.xyz", "1 2 3\n");
  write_text("same.xyz", "1 2 3\n1 2 3\n1 2 3\n1 2 3\n1 2 3\n");
  write_text("line.xyz", "0 0 0\n1 0 0\n2 0 0\n3 0 0\n4 0 0\n5 0 0\n");
  write_text("nan.xyz", "nan nan nan\n0 0 1\n");
  write_text("huge.xyz", "1e30 0 0\n0 0 1\n1 1 1\n");
  for (const std::string name : {"one", "same", "line", "nan"}) {
    for (const std::string tolerance : {"0", "5mm", "2sigma"}) {
      const RunResult result = run("eval " + name + ".xyz --tolerance " + tolerance);
      EXPECT_EQ(result.code, 0) << name << " " << tolerance << result.talk;
    }
  }
  const RunResult huge = run("eval huge.xyz --tolerance 5mm");
  EXPECT_TRUE(huge.code == 0 || huge.code == 3) << huge.code << huge.talk;
  EXPECT_TRUE(huge.says("huge.xyz")) << huge.talk;
}

// Degenerate clouds by both methods and every contract: every point comes back or is counted.
TEST_F(ListEval, DegenerateCloudsAreCountedByBothMethodsAndEveryContract) {
  const auto lines = [](int count, const std::function<std::string(int)>& line) {
    std::string text;
    for (int i = 0; i < count; ++i) text += line(i) + "\n";
    return text;
  };
  Pcg32 random(5);
  const auto any = [&](double from) { return std::to_string(from + random.uniform()) + " "; };
  const std::pair<std::string, std::string> clouds[] = {
      {"zero", "# nothing\n"},
      {"one", "1 2 3\n"},
      {"two", "1 2 3\n1 2 4\n"},
      {"three", "0 0 0\n1 0 0\n0 1 0\n"},
      {"same", lines(200, [](int) { return "1 2 3"; })},
      {"line", lines(200, [](int i) { return std::to_string(0.01 * i) + " 0 0"; })},
      {"twice", lines(100, [&](int) { return any(0) + any(0) + "0"; })},
      {"nan", lines(3, [](int) { return "nan nan nan"; }) + "0 0 1\n"},
      {"huge", "1e30 0 0\n" + lines(99, [&](int) { return any(0) + any(0) + "0"; })},
      {"map", lines(100, [&](int) { return any(691000) + any(5334000) + "500.5"; })}};
  for (const auto& [name, text] : clouds) {
    write_text(name + ".xyz", name == "twice" ? text + text : text);
    for (const std::string options :
         {"--tolerance 0", "--tolerance 5mm", "", "--tolerance surfaces",
          "--tolerance surfaces --off-surface drop", "--method paper",
          "--method paper --off-surface keep --outliers keep --regenerate lattice"}) {
      const RunResult result = run("eval " + name + ".xyz " + options + " --json");
      if (name == "zero") {
        EXPECT_EQ(result.code, 3) << options;
        EXPECT_TRUE(result.says("zero.xyz: holds no point")) << result.talk;
        continue;
      }
      ASSERT_EQ(result.code, 0) << name << " " << options << result.talk;
      const auto frame = result.json()["frames"][0];
      const int in = frame["points_in"], out = frame["points_out"];
      const int size = static_cast<int>(std::count(text.begin(), text.end(), '\n'));
      EXPECT_EQ(in, name == "nan" ? 1 : (name == "twice" ? 2 * size : size)) << name << options;
      EXPECT_EQ(in, out + frame["points_dropped"].get<int>()) << name << " " << options;
      const bool drops = options.find("drop") != std::string::npos || options == "--method paper";
      if (!drops) EXPECT_EQ(in, out) << name << " " << options;
    }
  }
  const RunResult bound = run("eval one.xyz --method paper --tolerance 5mm");
  EXPECT_EQ(bound.code, 2);
  EXPECT_TRUE(bound.says("leave --method")) << bound.talk;
}

TEST_F(ListEval, InfoNamesTheGridAndWhatEachSliceHolds) {
  ASSERT_EQ(run(std::string("encode ") + kScan + " -o a.plc --tolerance 10mm").code, 0);
  const auto report = run("info a.plc --json").json();
  EXPECT_EQ(report["key_packets"][0]["kind"], "points");
  EXPECT_GT(report["key_packets"][0]["max_points"], 4000);
  int points = 0;
  for (const auto& slice : report["frames"][0]["slices"]) points += slice["points"].get<int>();
  EXPECT_GT(points, 4000);
  EXPECT_EQ(run("decode a.plc -o b.png").code, 2);
}

TEST_F(ListEval, ThePapersMethodCountsWhatItDropsAndMeasuresBothClouds) {
  const RunResult result = run("eval sim:scan:1 --size 360x80 --method paper --json");
  ASSERT_EQ(result.code, 0) << result.talk;
  const auto report = result.json();
  const auto frame = report["frames"][0];
  EXPECT_EQ(report["sensor"]["fill"], "random");
  EXPECT_EQ(report["sensor"]["tolerance"]["off_surface"], "drop");
  EXPECT_GT(frame["surfaces"], 3);
  EXPECT_GT(frame["outliers_dropped"], 0);
  EXPECT_EQ(frame["points_in"].get<int>(),
            frame["points_out"].get<int>() + frame["points_dropped"].get<int>());
  EXPECT_EQ(frame["filtered_points"], frame["points_out"]);
  EXPECT_LT(frame["filtered_d1_ab_mm"], frame["d1_ab_mm"]);  // the dropped points are the far ones
  EXPECT_LT(frame["bits_per_point"], 3);
}

TEST_F(ListEval, ThePapersMethodTakesTheGridsOfCamerasAsLists) {
  const RunResult depth = run("eval sim:room:1 --size 160x120 --method paper --json");
  ASSERT_EQ(depth.code, 0) << depth.talk;
  EXPECT_EQ(depth.json()["sensor"]["kind"], "points");
  write_cloud("a.pcd", cloud_of(small_frame(0), 95.75F, 79.5F, 59.5F));
  const RunResult cloud =
      run("eval a.pcd --method paper --regenerate lattice --off-surface keep "
          "--outliers keep --json");
  ASSERT_EQ(cloud.code, 0) << cloud.talk;
  const auto frame = cloud.json()["frames"][0];
  EXPECT_EQ(frame["points_in"], frame["points_out"]);
  EXPECT_EQ(cloud.json()["sensor"]["fill"], "lattice");
}

TEST_F(ListEval, APaperStreamIsWrittenAndReadBack) {
  ASSERT_EQ(run("encode sim:scan:2 --size 360x80 --method paper -o a.plc").code, 0);
  ASSERT_EQ(run("decode a.plc -o clouds/ --format pcd").code, 0);
  const auto report = run("info a.plc --json").json();
  EXPECT_EQ(report["frames"][0]["slices"][0]["holds"], "patches");
  const auto first = read_pcd(at("clouds/a_000000.pcd"));
  ASSERT_TRUE(first.ok());
  int points = 0;
  for (const auto& slice : report["frames"][0]["slices"]) points += slice["points"].get<int>();
  EXPECT_EQ(first->points.size(), static_cast<std::size_t>(points));
}

}  // namespace
}  // namespace planecast::test
