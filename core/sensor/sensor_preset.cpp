#include "core/sensor/sensor_preset.hpp"

#include <array>

namespace planecast {
namespace {

constexpr NoiseModel stereo(double s) {
  return {NoiseModel::Kind::kStereo, static_cast<std::uint32_t>(s * 1e9 + 0.5)};
}

constexpr NoiseModel tof(double s) {
  return {NoiseModel::Kind::kTof, static_cast<std::uint32_t>(s * 1e9 + 0.5)};
}

constexpr Intrinsics pinhole(double f, double cx, double cy, double metres_per_unit = 0.001) {
  Intrinsics out;
  out.fx = f;
  out.fy = f;
  out.cx = cx;
  out.cy = cy;
  out.metres_per_unit = metres_per_unit;
  return out;
}

// Kinect v1 noise: Khoshelham and Oude Elberink 2012, sigma = 1.425e-3 z^2. Stereo noise of the
// others: about 0.06 px of disparity over focal length times baseline.
constexpr std::array kPresets = {
    SensorPreset{"kinect1", "Microsoft Kinect v1, PrimeSense structured light", 640, 480,
                 pinhole(525.0, 319.5, 239.5), stereo(0.001425), 30, 0.5, 8.0, 0.075, 8},
    SensorPreset{"kinect2", "Microsoft Kinect v2, time of flight", 512, 424,
                 pinhole(365.3, 254.7, 208.5), tof(0.003), 30, 0.5, 4.5, 0, 0},
    SensorPreset{"realsense-d435", "Intel RealSense D435 / D435i, 640x480", 640, 480,
                 pinhole(383.0, 319.5, 239.5), stereo(0.003), 30, 0.2, 10.0, 0.05, 32},
    SensorPreset{"realsense-d435-848", "Intel RealSense D435 / D435i, 848x480", 848, 480,
                 pinhole(424.0, 423.5, 239.5), stereo(0.003), 30, 0.2, 10.0, 0.05, 32},
    SensorPreset{"realsense-d415", "Intel RealSense D415, 1280x720", 1280, 720,
                 pinhole(916.0, 639.5, 359.5), stereo(0.0012), 30, 0.45, 10.0, 0.055, 32},
    SensorPreset{"realsense-d455", "Intel RealSense D455, 848x480", 848, 480,
                 pinhole(426.0, 423.5, 239.5), stereo(0.0015), 30, 0.4, 12.0, 0.095, 32},
    SensorPreset{"realsense-l515", "Intel RealSense L515, 640x480, scanned time of flight", 640,
                 480, pinhole(457.0, 319.5, 239.5, 0.00025), tof(0.005), 30, 0.25, 9.0, 0, 0},
    SensorPreset{"azure-nfov", "Azure Kinect, narrow field, unbinned", 640, 576,
                 pinhole(504.0, 320.0, 330.0), tof(0.004), 30, 0.5, 3.86, 0, 0},
    SensorPreset{"azure-nfov-binned", "Azure Kinect, narrow field, 2x2 binned", 320, 288,
                 pinhole(252.0, 160.0, 165.0), tof(0.003), 30, 0.5, 5.46, 0, 0},
    SensorPreset{"structure", "Occipital Structure Sensor, structured light", 640, 480,
                 pinhole(575.8, 319.5, 239.5), stereo(0.0014), 30, 0.4, 3.5, 0.065, 8},
    SensorPreset{"orbbec-astra", "Orbbec Astra, structured light", 640, 480,
                 pinhole(570.34, 319.5, 239.5), stereo(0.0014), 30, 0.6, 8.0, 0.075, 8},
    SensorPreset{"xtion", "ASUS Xtion Pro, PrimeSense structured light", 640, 480,
                 pinhole(570.34, 319.5, 239.5), stereo(0.001425), 30, 0.5, 8.0, 0.075, 8},
    SensorPreset{"zed2", "Stereolabs ZED 2, HD720", 1280, 720, pinhole(528.0, 639.5, 359.5),
                 stereo(0.0016), 30, 0.3, 20.0, 0.12, 16},
    SensorPreset{"oak-d", "Luxonis OAK-D, 640x400", 640, 400, pinhole(441.0, 319.5, 199.5),
                 stereo(0.002), 30, 0.35, 12.0, 0.075, 8},
};

}  // namespace

std::span<const SensorPreset> sensor_presets() noexcept {
  return kPresets;
}

const SensorPreset* find_preset(std::string_view name) noexcept {
  for (const SensorPreset& preset : kPresets) {
    if (preset.name == name) return &preset;
  }
  return nullptr;
}

std::string preset_names() {
  std::string names;
  for (const SensorPreset& preset : kPresets) {
    if (!names.empty()) names += ", ";
    names += preset.name;
  }
  return names;
}

}  // namespace planecast
