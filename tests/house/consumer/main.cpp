// Uses the installed headers and libraries of several rooms; exits 0 when they do what they say.
#include <cstdio>
#include <vector>

#include "core/base/status.hpp"
#include "core/cloud/sensor_frame.hpp"
#include "core/metrics/distance.hpp"
#include "core/sensor/sensor_preset.hpp"
#include "transport/lcm_url.hpp"

int main() {
  const planecast::SensorPreset* preset = planecast::find_preset("kinect1");
  const std::vector<planecast::Point3f> a = {{0, 0, 1}, {0, 1, 1}, {1, 0, 1}};
  const std::vector<planecast::Point3f> b = {{0, 0, 2}, {0, 1, 2}, {1, 0, 2}};
  const planecast::CloudDistance distance = planecast::cloud_distance(a, b);
  const bool url_read = planecast::parse_lcm_url("udpm://239.1.2.3:7000").ok();
  std::printf("%s %.1f m %s\n", preset == nullptr ? "?" : preset->name.data(), distance.d1,
              planecast::to_string(planecast::Status::kOk).data());
  return preset != nullptr && distance.d1 == 1.0 && url_read ? 0 : 1;
}
