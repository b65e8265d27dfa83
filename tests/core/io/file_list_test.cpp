#include "core/io/file_list.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/io/natural_order.hpp"
#include "core/io/nearest_name.hpp"
#include "tests/core/io/io_test_support.hpp"

namespace planecast {
namespace {

using test::TempFolder;

std::vector<std::string> names_of(const std::vector<std::filesystem::path>& paths) {
  std::vector<std::string> names;
  for (const auto& path : paths) names.push_back(path.filename().string());
  return names;
}

Result<std::vector<std::filesystem::path>> expand(const std::filesystem::path& path) {
  const std::vector<std::string> inputs = {path.string()};
  return expand_inputs(inputs);
}

TEST(NaturalOrder, SortsNumbersByValueAndIsStrict) {
  const std::vector<std::string> sorted = {"",
                                           "0.png",
                                           "1.png",
                                           "01.png",
                                           "2.png",
                                           "9.png",
                                           "10.png",
                                           "100.png",
                                           "a",
                                           "a1",
                                           "a1b2",
                                           "a1b10",
                                           "a2",
                                           "a10",
                                           "a99999999999999999999998.png",
                                           "a99999999999999999999999.png",
                                           "b"};
  for (std::size_t i = 0; i < sorted.size(); ++i) {
    for (std::size_t j = 0; j < sorted.size(); ++j) {
      EXPECT_EQ(natural_less(sorted[i], sorted[j]), i < j) << sorted[i] << " " << sorted[j];
    }
  }
}

TEST(NearestName, FindsTyposAndNothingElse) {
  const std::vector<std::string> names = {"depth", "cloud", "frames"};
  EXPECT_EQ(nearest_name("detph", names), std::nullopt);  // two edits of five letters are too many
  EXPECT_EQ(nearest_name("dept", names), "depth");
  EXPECT_EQ(nearest_name("framez", names), "frames");
  EXPECT_EQ(nearest_name("lidar", names), std::nullopt);
  EXPECT_EQ(nearest_name("", names), std::nullopt);
}

TEST(FileList, AFolderGivesItsFramesInNaturalOrder) {
  const TempFolder folder;
  for (const char* name : {"10.png", "2.png", "1.PNG", "LICENSE", "notes.txt", ".hidden.png"}) {
    folder.file(name, "");
  }
  std::filesystem::create_directory(folder / "3.png");
  std::vector<std::filesystem::path> ignored;
  const std::vector<std::string> inputs = {folder.path().string()};
  const auto files = expand_inputs(inputs, &ignored);
  ASSERT_TRUE(files.ok()) << files.error().message;
  EXPECT_EQ(names_of(*files), (std::vector<std::string>{"1.PNG", "2.png", "10.png"}));
  EXPECT_EQ(names_of(ignored), (std::vector<std::string>{"LICENSE", "notes.txt"}));
}

TEST(FileList, TextFilesCountWhenTheyAreAlone) {
  const TempFolder folder;
  folder.file("b.xyz", "");
  folder.file("a.txt", "");
  const auto files = expand(folder.path());
  ASSERT_TRUE(files.ok()) << files.error().message;
  EXPECT_EQ(names_of(*files), (std::vector<std::string>{"a.txt", "b.xyz"}));
}

TEST(FileList, FilesStandInTheOrderGivenWhateverTheirKind) {
  const TempFolder folder;
  const std::vector<std::string> inputs = {folder.file("b.pcd", "").string(),
                                           folder.file("a.png", "").string(),
                                           folder.file("a.las", "").string()};
  const auto files = expand_inputs(inputs);
  ASSERT_TRUE(files.ok()) << files.error().message;
  EXPECT_EQ(names_of(*files), (std::vector<std::string>{"b.pcd", "a.png", "a.las"}));
}

TEST(FileList, MixedKindsAreAnErrorNamingBoth) {
  const TempFolder folder;
  folder.file("0.png", "");
  folder.file("0.pcd", "");
  const auto files = expand(folder.path());
  EXPECT_REFUSED(files, folder.path(), "0.pcd (PCD)");
  EXPECT_REFUSED(files, folder.path(), "0.png (depth PNG)");
}

TEST(FileList, NothingReadableIsAnErrorWithTheFormatsMend) {
  const TempFolder folder;
  EXPECT_REFUSED(expand(folder.path()), folder.path(), "no files");
  std::filesystem::create_directory(folder / "depth");
  EXPECT_REFUSED(expand(folder.path()), folder.path(), (folder / "depth").string());
  folder.file("LICENSE", "");
  folder.file("scan.las", "");
  EXPECT_REFUSED(expand(folder.path()), folder.path(), "LAS");
}

TEST(FileList, AMissingPathNamesTheNearestThatExists) {
  const TempFolder folder;
  folder.file("frame_0001.png", "");
  const auto near = expand(folder / "frame_001.png");
  ASSERT_FALSE(near.ok());
  EXPECT_EQ(near.error().status, Status::kNotFound);
  EXPECT_NE(near.error().message.find("did you mean " + (folder / "frame_0001.png").string()),
            std::string::npos)
      << near.error().message;
  const auto far = expand(folder / "other");
  ASSERT_FALSE(far.ok());
  EXPECT_EQ(far.error().message.find("did you mean"), std::string::npos);
  const auto no_parent = expand(folder / "nowhere/frame.png");
  ASSERT_FALSE(no_parent.ok());
  EXPECT_NE(no_parent.error().message.find("does not exist"), std::string::npos);
  EXPECT_FALSE(expand(folder / "frame_0001.pn/").ok());
}

TEST(FileList, NoInputIsAUsageError) {
  const auto files = expand_inputs({});
  ASSERT_FALSE(files.ok());
  EXPECT_EQ(files.error().status, Status::kUsage);
}

}  // namespace
}  // namespace planecast
