#include "apps/common/reference_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "apps/common/frame_source.hpp"
#include "apps/common/picture.hpp"
#include "core/filter/outlier_filter.hpp"

namespace planecast {
namespace {

constexpr double kRayUnit = 1.0 / 134217728.0;  // 2^-27
constexpr double kExactSideways = 2e-6;         // [m] x and y of a lossless cloud (DESIGN 4)
constexpr double kNothing = 2e-6;               // [m] see Worst::take

bool valid(const Point3f& p) {
  return std::isfinite(p.x) && std::isfinite(p.y) && std::isfinite(p.z);
}

// From a received point to its original [m].
struct Offset {
  double x, y, z;

  Offset(double ox, double oy, double oz, const Point3f& p)
      : x(ox - p.x), y(oy - p.y), z(oz - p.z) {}
  Offset(const Point3f& original, const Point3f& p)
      : Offset(original.x, original.y, original.z, p) {}
  double m2() const noexcept { return x * x + y * y + z * z; }
  double sideways() const noexcept { return std::max(std::abs(x), std::abs(y)); }
};

// The largest distance so far, and the largest over its bound; both squared.
struct Worst {
  double m2 = 0;
  double ratio2 = 0;

  void take(const Offset& off, double limit_m) noexcept {
    const double here = off.m2();
    m2 = std::max(m2, here);
    // A bound of nothing still forgives what float32 rounds away.
    const double limit = std::max(limit_m, kNothing);
    ratio2 = std::max(ratio2, here / (limit * limit));
  }
  void take_exact(const Offset& off, bool same) noexcept {
    m2 = std::max(m2, off.m2());
    if (!same) ratio2 = FrameCheck::kBeyond * FrameCheck::kBeyond;
  }
};

bool same_bits(float a, float b) {
  return std::bit_cast<std::uint32_t>(a) == std::bit_cast<std::uint32_t>(b);
}

}  // namespace

// The bound of a reading at its depth.
struct ReferenceCheck::Bound {
  ToleranceKind kind = ToleranceKind::kLossless;
  double value = 0;  // metres, or multiples of sigma
  NoiseModel noise;

  Bound(const std::optional<Tolerance>& asked, const StreamConfig& stream) : noise(stream.noise) {
    kind = asked ? asked->kind : stream.tolerance;
    if (kind == ToleranceKind::kMetres) {
      value = asked ? asked->value : stream.tolerance_100nm * 1e-7;
    } else if (kind != ToleranceKind::kLossless) {
      value = asked ? asked->value : stream.sigmas_q16 / 65536.0;
    }
  }
  bool exact() const noexcept { return kind == ToleranceKind::kLossless; }
  double at(double z_m) const noexcept {
    return kind == ToleranceKind::kMetres ? value : value * noise.sigma_m(z_m);
  }
};

Result<ReferenceCheck> ReferenceCheck::load(const std::string& input, const CodecOptions& options) {
  auto source = open_source({input}, options);
  if (!source.ok()) return source.error();
  ReferenceCheck out;
  out.outliers_dropped_ = options.outliers == Outliers::kDrop;
  if (options.is_given("tolerance") || options.is_given("method"))
    out.tolerance_ = options.tolerance;
  SensorFrame frame;
  for (;;) {
    const auto more = (*source)->next(frame);
    if (!more.ok()) return more.error();
    if (!*more) break;
    if (out.frames_.empty()) {
      auto setup = setup_stream(options, (*source)->sensor(), frame);
      if (!setup.ok()) return setup.error();
      out.setup_ = std::move(*setup);
      if (out.setup_.cloud_input && !out.tolerance_) {
        return Error{
            Status::kUsage,
            "--reference " + input + ": is a cloud; give --tolerance as planecastd was given it"};
      }
    }
    if (const auto added = out.add(frame); !added.ok()) return added.error();
  }
  if (out.frames_.empty())
    return Error{Status::kUnreadable, "--reference " + input + ": holds no frame"};
  return out;
}

Result<Done> ReferenceCheck::add(const SensorFrame& frame) {
  Frame kept;
  const StageOptions& stages = setup_.encoder.stages;
  if (setup_.encoder.stream.kind == FrameKind::kDepth) {
    if (const auto done = to_depth(setup_, frame, kept.depth); !done.ok()) return done.error();
    apply_range_gate(kept.depth, stages.range_min, stages.range_max);
  }
  if (setup_.encoder.stream.kind == FrameKind::kRawCloud) {
    const auto gated = to_raw_points(setup_, frame, kept.points);
    if (!gated.ok()) return gated.error();
  } else if (setup_.cloud_input) {
    kept.points = frame.cloud.points;
  }
  bytes_ += kept.depth.size() * sizeof(std::uint16_t) + kept.points.size() * sizeof(Point3f);
  if (bytes_ > kMaxReferenceBytes) {
    return Error{Status::kUsage,
                 fmt::format("--reference: its first {} frames take {} GiB of memory already; "
                             "name fewer frames",
                             frames_.size() + 1, kMaxReferenceBytes >> 30U)};
  }
  frames_.push_back(std::move(kept));
  return Done{};
}

FrameCheck ReferenceCheck::check(std::uint64_t frame, const Decoder& decoder) const noexcept {
  FrameCheck out;
  if (!decoder.ready()) return out;
  const Frame& original = frames_[frame % frames_.size()];
  const StreamConfig& stream = decoder.config();
  const StreamConfig& expected = setup_.encoder.stream;
  out.comparable = stream.kind == expected.kind && stream.camera.width == expected.camera.width &&
                   stream.camera.height == expected.camera.height &&
                   stream.camera.unit_pm == expected.camera.unit_pm;
  if (!out.comparable) return out;
  if (stream.kind == FrameKind::kRawCloud) {
    check_raw(original, decoder, out);
  } else {
    check_depth(original, decoder, out);
  }
  return out;
}

// Raw clouds are lossless whatever the tolerance: every float comes back, "no reading" as NaN.
void ReferenceCheck::check_raw(const Frame& original, const Decoder& decoder,
                               FrameCheck& out) const noexcept {
  const auto cloud = decoder.cloud();
  for (std::size_t i = 0; i < cloud.size(); ++i) {
    const Point3f& a = original.points[i];
    const Point3f& b = cloud[i];
    const bool reading = valid(a);
    out.expected += reading;
    if (reading != valid(b)) {
      ++(reading ? out.missing : out.invented);
    } else if (reading && !(same_bits(a.x, b.x) && same_bits(a.y, b.y) && same_bits(a.z, b.z))) {
      out.max_ratio = FrameCheck::kBeyond;
      out.max_error_m = std::max(out.max_error_m, std::sqrt(Offset(a, b).m2()));
    }
  }
}

void ReferenceCheck::check_depth(const Frame& original, const Decoder& decoder,
                                 FrameCheck& out) const noexcept {
  const StreamConfig& stream = decoder.config();
  const Bound bound(tolerance_, stream);
  const RayTable& rays = decoder.tables().rays();
  const auto cloud = decoder.cloud();
  const auto depth = decoder.depth();
  const double unit_m = static_cast<double>(stream.camera.unit_pm) * 1e-12;
  const bool may_drop = stream.drop_off_surface || outliers_dropped_;
  Worst worst;
  std::size_t i = 0;
  for (std::uint32_t v = 0; v < rays.height; ++v) {
    for (std::uint32_t u = 0; u < rays.width; ++u, ++i) {
      const std::uint16_t count = original.depth[i];
      out.expected += count != 0;
      if ((count == 0) != (depth[i] == 0)) {
        ++(count == 0 ? out.invented : may_drop ? out.dropped : out.missing);
        continue;
      }
      if (count == 0) continue;
      const double z = count * unit_m;
      const Offset off = setup_.cloud_input ? Offset(original.points[i], cloud[i])
                                            : Offset(rays.x(u, v) * kRayUnit * z,
                                                     rays.y(u, v) * kRayUnit * z, z, cloud[i]);
      if (bound.exact()) {
        // A cloud's z comes back to the bit; its x and y follow from the camera within 2 um.
        const bool fine = !setup_.cloud_input || (off.sideways() <= kExactSideways && off.z == 0);
        worst.take_exact(off, count == depth[i] && fine);
      } else {
        worst.take(off, bound.at(z));
      }
    }
  }
  out.max_error_m = std::sqrt(worst.m2);
  out.max_ratio = std::sqrt(worst.ratio2);
}

std::vector<float> ReferenceCheck::depth_m(std::uint64_t frame) const {
  const Frame& original = frames_[frame % frames_.size()];
  if (!original.depth.empty()) {
    return metres(original.depth,
                  static_cast<double>(setup_.encoder.stream.camera.unit_pm) * 1e-12);
  }
  std::vector<float> z_m;
  z_m.reserve(original.points.size());
  for (const Point3f& p : original.points) z_m.push_back(p.z);
  return z_m;
}

}  // namespace planecast
