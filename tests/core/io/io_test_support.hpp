// Shared by the io tests: a folder that vanishes, seeded clouds, files cut or patched at will.
#pragma once

#include <gtest/gtest.h>
#include <unistd.h>

#include <atomic>
#include <bit>
#include <cmath>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <functional>
#include <iterator>
#include <limits>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/random.hpp"
#include "core/cloud/sensor_frame.hpp"

namespace planecast::test {

/// A folder of its own for one test; removed with all it holds.
class TempFolder {
 public:
  TempFolder() {
    static std::atomic<int> count{0};
    path_ = std::filesystem::temp_directory_path() /
            ("planecast_io_" + std::to_string(getpid()) + "_" + std::to_string(count++));
    std::filesystem::create_directories(path_);
  }
  ~TempFolder() {
    std::error_code code;
    std::filesystem::remove_all(path_, code);
  }
  TempFolder(const TempFolder&) = delete;
  TempFolder& operator=(const TempFolder&) = delete;

  std::filesystem::path operator/(const std::string& name) const { return path_ / name; }
  const std::filesystem::path& path() const { return path_; }

  /// Writes a file and gives its path.
  std::filesystem::path file(const std::string& name, std::string_view content) const {
    std::ofstream(path_ / name, std::ios::binary) << content;
    return path_ / name;
  }

 private:
  std::filesystem::path path_;
};

inline std::string file_content(const std::filesystem::path& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

/// Appends the bytes of a number in the machine's order (the tests run on little-endian machines).
template <class T>
void append_raw(std::string& out, T value) {
  static_assert(std::endian::native == std::endian::little);
  out.append(reinterpret_cast<const char*>(&value), sizeof(value));
}

/// A cloud of seeded points; `holes` of them are NaN in all coordinates.
inline PointCloud random_cloud(std::uint32_t width, std::uint32_t height, std::uint64_t seed,
                               double holes = 0) {
  Pcg32 random(seed);
  const float nan = std::numeric_limits<float>::quiet_NaN();
  const auto coordinate = [&random] { return static_cast<float>(20 * random.uniform() - 10); };
  PointCloud cloud;
  cloud.width = width;
  cloud.height = height;
  for (std::uint64_t i = 0; i < std::uint64_t{width} * height; ++i) {
    const Point3f p{coordinate(), coordinate(), coordinate()};
    cloud.points.push_back(random.uniform() < holes ? Point3f{nan, nan, nan} : p);
  }
  return cloud;
}

inline bool is_hole(const Point3f& p) {
  return std::isnan(p.x) || std::isnan(p.y) || std::isnan(p.z);
}

inline std::vector<Point3f> valid_points(const PointCloud& cloud) {
  std::vector<Point3f> out;
  for (const Point3f& p : cloud.points) {
    if (!is_hole(p)) out.push_back(p);
  }
  return out;
}

/// Equal bit for bit, so that NaN equals NaN and -0 differs from 0.
inline bool same_points(const std::vector<Point3f>& a, const std::vector<Point3f>& b) {
  const auto same = [](float u, float v) {
    return std::bit_cast<std::uint32_t>(u) == std::bit_cast<std::uint32_t>(v);
  };
  if (a.size() != b.size()) return false;
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (!same(a[i].x, b[i].x) || !same(a[i].y, b[i].y) || !same(a[i].z, b[i].z)) return false;
  }
  return true;
}

/// Calls `read` on every proper prefix of `content`, written under `name`.
inline void for_every_truncation(
    const TempFolder& folder, const std::string& name, const std::string& content,
    const std::function<void(const std::filesystem::path&, std::size_t)>& read) {
  for (std::size_t length = 0; length < content.size(); ++length) {
    read(folder.file(name, std::string_view(content).substr(0, length)), length);
  }
}

/// A change to a good file's header, and what the message that refuses it says.
struct HeaderLie {
  std::string from;
  std::string to;
  std::string message;
};

/// Replaces the only occurrence of `from`; a test that patches nothing fails.
inline std::string patched(std::string text, std::string_view from, std::string_view to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  if (at != std::string::npos) text.replace(at, from.size(), to);
  return text;
}

}  // namespace planecast::test

/// The read failed, as corrupt, and its message names the file and holds `part`.
#define EXPECT_REFUSED(result, path, part)                                      \
  do {                                                                          \
    const auto& refused_result = (result);                                      \
    ASSERT_FALSE(refused_result.ok());                                          \
    EXPECT_EQ(refused_result.error().status, ::planecast::Status::kUnreadable); \
    EXPECT_EQ(refused_result.error().message.rfind((path).string(), 0), 0U)     \
        << refused_result.error().message;                                      \
    EXPECT_NE(refused_result.error().message.find(part), std::string::npos)     \
        << refused_result.error().message;                                      \
    EXPECT_NE(refused_result.error().message.find("; "), std::string::npos)     \
        << "no mend: " << refused_result.error().message;                       \
  } while (false)
