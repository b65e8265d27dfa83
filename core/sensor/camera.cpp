#include "core/sensor/camera.hpp"

#include <cstdio>
#include <string>

namespace planecast {
namespace {

constexpr double kQ16 = 65536.0;
constexpr double kQ24 = 16777216.0;
constexpr double kPicometresPerMetre = 1e12;

// Rounds half away from zero; the caller has checked that the value fits. No libm here.
std::int64_t round_half_away(double value) noexcept {
  return static_cast<std::int64_t>(value < 0 ? value - 0.5 : value + 0.5);
}

// False for NaN as well.
bool within(double value, double low, double high) noexcept {
  return value >= low && value <= high;
}

Error bad_number(const char* name, double value, const std::string& mend) {
  char number[40];
  std::snprintf(number, sizeof number, "%g", value);
  return {Status::kBadConfig, std::string("camera: ") + name + " = " + number + ": " + mend};
}

// Whether every pixel 0..side-1 of one axis has a ray within kMaxRay.
bool rays_fit(std::uint32_t side, std::uint32_t focal_q16, std::int32_t centre_q16) noexcept {
  const std::int64_t first = -std::int64_t{centre_q16};
  const std::int64_t last = (std::int64_t{side} - 1) * 65536 - centre_q16;
  const std::int64_t limit = std::int64_t{kMaxRay} * focal_q16;
  return first >= -limit && first <= limit && last >= -limit && last <= limit;
}

struct Coefficient {
  const char* name;
  double value;
  std::int32_t* target;
};

}  // namespace

Status check_camera(const CameraModel& camera) noexcept {
  const bool sizes = camera.width >= 1 && camera.width <= kMaxImageSide && camera.height >= 1 &&
                     camera.height <= kMaxImageSide;
  const bool unit = camera.unit_pm >= 1 && camera.unit_pm <= kMaxUnitPm;
  if (!sizes || !unit || camera.fx_q16 == 0 || camera.fy_q16 == 0) return Status::kFieldRange;
  const bool rays = rays_fit(camera.width, camera.fx_q16, camera.cx_q16) &&
                    rays_fit(camera.height, camera.fy_q16, camera.cy_q16);
  return rays ? Status::kOk : Status::kFieldRange;
}

Result<CameraModel> quantise(const Intrinsics& in, std::uint32_t width, std::uint32_t height) {
  if (width < 1 || width > kMaxImageSide) {
    return bad_number("width", width, "an image is 1 to 16384 pixels wide");
  }
  if (height < 1 || height > kMaxImageSide) {
    return bad_number("height", height, "an image is 1 to 16384 pixels high");
  }
  // 65535 px is a field of view below one degree for the largest image allowed.
  const char* focal_mend =
      "the focal length in pixels must be above 0 and below 65536; "
      "it is usually 0.5 to 2 times the image width";
  if (!within(in.fx, 1.0 / kQ16, 65535.0)) return bad_number("fx", in.fx, focal_mend);
  if (!within(in.fy, 1.0 / kQ16, 65535.0)) return bad_number("fy", in.fy, focal_mend);
  const char* centre_mend =
      "the optical centre in pixels must lie within -32767..32767; "
      "it is usually near half the image size";
  if (!within(in.cx, -32767.0, 32767.0)) return bad_number("cx", in.cx, centre_mend);
  if (!within(in.cy, -32767.0, 32767.0)) return bad_number("cy", in.cy, centre_mend);
  if (!within(in.metres_per_unit * kPicometresPerMetre, 1.0, static_cast<double>(kMaxUnitPm))) {
    return bad_number("metres per unit", in.metres_per_unit,
                      "one depth count must be 1e-12 to 1 m; 0.001 for millimetres");
  }

  CameraModel out;
  out.width = static_cast<std::uint16_t>(width);
  out.height = static_cast<std::uint16_t>(height);
  out.fx_q16 = static_cast<std::uint32_t>(round_half_away(in.fx * kQ16));
  out.fy_q16 = static_cast<std::uint32_t>(round_half_away(in.fy * kQ16));
  out.cx_q16 = static_cast<std::int32_t>(round_half_away(in.cx * kQ16));
  out.cy_q16 = static_cast<std::int32_t>(round_half_away(in.cy * kQ16));
  out.unit_pm =
      static_cast<std::uint64_t>(round_half_away(in.metres_per_unit * kPicometresPerMetre));
  const Coefficient coefficients[] = {{"k1", in.k1, &out.k1_q24},
                                      {"k2", in.k2, &out.k2_q24},
                                      {"p1", in.p1, &out.p1_q24},
                                      {"p2", in.p2, &out.p2_q24},
                                      {"k3", in.k3, &out.k3_q24}};
  for (const Coefficient& c : coefficients) {
    if (!within(c.value, -127.0, 127.0)) {
      return bad_number(c.name, c.value,
                        "a distortion coefficient lies within -127..127; "
                        "the order is k1,k2,p1,p2,k3");
    }
    *c.target = static_cast<std::int32_t>(round_half_away(c.value * kQ24));
  }
  if (!rays_fit(width, out.fx_q16, out.cx_q16)) {
    return bad_number("fx", in.fx,
                      "with this cx and width some pixels look more than 82 degrees "
                      "off axis; give fx and cx for this image size");
  }
  if (!rays_fit(height, out.fy_q16, out.cy_q16)) {
    return bad_number("fy", in.fy,
                      "with this cy and height some pixels look more than 82 degrees "
                      "off axis; give fy and cy for this image size");
  }
  return out;
}

Intrinsics to_intrinsics(const CameraModel& camera) noexcept {
  Intrinsics out;
  out.fx = camera.fx_q16 / kQ16;
  out.fy = camera.fy_q16 / kQ16;
  out.cx = camera.cx_q16 / kQ16;
  out.cy = camera.cy_q16 / kQ16;
  out.k1 = camera.k1_q24 / kQ24;
  out.k2 = camera.k2_q24 / kQ24;
  out.p1 = camera.p1_q24 / kQ24;
  out.p2 = camera.p2_q24 / kQ24;
  out.k3 = camera.k3_q24 / kQ24;
  out.metres_per_unit = static_cast<double>(camera.unit_pm) / kPicometresPerMetre;
  return out;
}

}  // namespace planecast
