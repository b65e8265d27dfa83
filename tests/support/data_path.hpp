// Where the development data lie. They are not part of the repository: a test that needs them
// skips by name when they are absent.
#pragma once

#include <filesystem>
#include <string>

namespace planecast::test {

/// Path of a file or folder of the development data, e.g. "depth_seq/aims_realsense/0.png".
/// The folder is $PLANECAST_DATA, else ../shared/data beside the checkout; empty when it is absent.
std::filesystem::path data_path(const std::string& relative);

}  // namespace planecast::test

#define PLANECAST_NEED_DATA(variable, relative)                                  \
  const std::filesystem::path variable = ::planecast::test::data_path(relative); \
  if (variable.empty()) GTEST_SKIP() << "development data absent: " << (relative)
