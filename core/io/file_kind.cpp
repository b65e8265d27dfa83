#include "core/io/file_kind.hpp"

#include <array>
#include <string>
#include <utility>

#include "core/io/io_error.hpp"
#include "core/io/text.hpp"

namespace planecast {
namespace {

constexpr std::array<std::pair<std::string_view, FileKind>, 10> kRead = {{
    {".png", FileKind::kDepthPng},
    {".raw", FileKind::kDepthRaw},
    {".pcd", FileKind::kPcd},
    {".ply", FileKind::kPly},
    {".bin", FileKind::kKittiBin},
    {".xyz", FileKind::kXyzText},
    {".txt", FileKind::kXyzText},
    {".csv", FileKind::kXyzText},
    {".asc", FileKind::kXyzText},
    {".pts", FileKind::kXyzText},
}};

struct Refused {
  std::string_view extension;
  std::string_view what;
  std::string_view mend;
};

constexpr std::string_view kToDepthPng =
    "save the sensor's depth as 16-bit grey PNG, or its cloud as PCD";
constexpr std::string_view kFromSurvey = "convert it to PCD or PLY, e.g. with pdal translate";
constexpr std::string_view kFromBag = "export its clouds to PCD, e.g. with ros2 bag and pcl_ros";
constexpr std::string_view kFromMesh = "convert it to PLY, e.g. with MeshLab or CloudCompare";

constexpr std::array<Refused, 26> kRefused = {{
    {".tiff", "TIFF images are not read", kToDepthPng},
    {".tif", "TIFF images are not read", kToDepthPng},
    {".jpg", "JPEG pictures hold no depth", kToDepthPng},
    {".jpeg", "JPEG pictures hold no depth", kToDepthPng},
    {".pgm", "PGM images are not read", "convert it to 16-bit PNG, e.g. with ImageMagick"},
    {".exr", "OpenEXR images are not read", kToDepthPng},
    {".npy", "NumPy arrays are not read", kToDepthPng},
    {".npz", "NumPy archives are not read", kToDepthPng},
    {".h5", "HDF5 files are not read", kToDepthPng},
    {".pclzf", "PCLZF images are not read",
     "convert it to PCD or PLY, e.g. with PCL's image grabber"},
    {".las", "LAS files are not read", kFromSurvey},
    {".laz", "LAZ files are not read", kFromSurvey},
    {".copc", "COPC files are not read", kFromSurvey},
    {".e57", "E57 files are not read", kFromSurvey},
    {".ptx", "PTX files are not read", kFromSurvey},
    {".db3", "rosbag2 recordings are not read", kFromBag},
    {".mcap", "MCAP recordings are not read", kFromBag},
    {".bag", "ROS bag recordings are not read", kFromBag},
    {".pcap", "packet recordings are not read as points",
     "convert it to PCD with the sensor maker's tool"},
    {".obj", "OBJ meshes are not read", kFromMesh},
    {".stl", "STL meshes are not read", kFromMesh},
    {".off", "OFF meshes are not read", kFromMesh},
    {".vtk", "VTK files are not read", kFromMesh},
    {".drc", "Draco files are not read", "decode it to PLY with draco_decoder"},
    {".plc", "this is a packed Planecast file", "unpack it with planecast decode"},
    {".zip", "archives are not read", "unpack it first"},
}};

std::string extension_of(const std::filesystem::path& path) {
  return lower_case(path.extension().string());
}

const Refused* find_refused(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  for (const Refused& refused : kRefused) {
    if (refused.extension == extension) return &refused;
  }
  return nullptr;
}

}  // namespace

FileKind file_kind(const std::filesystem::path& path) {
  const std::string extension = extension_of(path);
  for (const auto& [known, kind] : kRead) {
    if (known == extension) return kind;
  }
  return FileKind::kUnread;
}

std::string_view to_string(FileKind kind) noexcept {
  switch (kind) {
    case FileKind::kDepthPng:
      return "depth PNG";
    case FileKind::kDepthRaw:
      return "raw depth";
    case FileKind::kPcd:
      return "PCD";
    case FileKind::kPly:
      return "PLY";
    case FileKind::kKittiBin:
      return "KITTI bin";
    case FileKind::kXyzText:
      return "XYZ text";
    case FileKind::kUnread:
      break;
  }
  return "not read";
}

bool is_known_format(const std::filesystem::path& path) {
  return find_refused(path) != nullptr;
}

Error refusal(const std::filesystem::path& path) {
  if (const Refused* const refused = find_refused(path)) {
    return file_error(path, "", refused->what, refused->mend);
  }
  const std::string extension = extension_of(path);
  const std::string what = extension.empty()
                               ? "the name has no extension to tell its format"
                               : "files of kind " + in_quotes(extension) + " are not read";
  return file_error(
      path, "", what,
      "known are .png .raw .pcd .ply .bin .xyz .txt .csv .asc .pts: convert it to one");
}

}  // namespace planecast
