#include "apps/common/reference_check.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <cmath>

#include "apps/common/frame_source.hpp"
#include "apps/common/picture.hpp"
#include "apps/common/points_setup.hpp"
#include "core/filter/outlier_filter.hpp"
#include "core/model/point_grid.hpp"

namespace planecast {
namespace {

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

// As the filter of lists decides it: the distance from the zero of the input's coordinates.
bool in_range(const StreamSetup& setup, const Point3f& p) {
  const StageOptions& stages = setup.encoder.stages;
  PointCloud zero;
  set_origin(setup.encoder.stream, zero);
  const double x = p.x + zero.origin_x, y = p.y + zero.origin_y, z = p.z + zero.origin_z;
  const double square = x * x + y * y + z * z;
  return square >= stages.range_min_m * stages.range_min_m &&
         square <= stages.range_max_m * stages.range_max_m;
}

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
      const bool list = out.setup_.encoder.stream.kind == FrameKind::kPoints;
      if (out.setup_.cloud_input && !out.tolerance_ && !list) {
        return Error{
            Status::kUsage,
            "--reference " + input + ": is a cloud; give --tolerance as planecastd was given it"};
      }
    }
    if (const auto added = out.add(frame); !added.ok()) return added.error();
  }
  if (out.frames_.empty())
    return Error{Status::kUnreadable, "--reference " + input + ": holds no frame"};
  const std::size_t most = out.setup_.encoder.stream.points.max_points;
  out.original_grid_.reserve(most);
  out.decoded_grid_.reserve(most);
  out.original_bits_.resize(most);
  out.decoded_bits_.resize(most);
  return out;
}

Result<Done> ReferenceCheck::add(const SensorFrame& frame) {
  Frame kept;
  const StageOptions& stages = setup_.encoder.stages;
  if (setup_.encoder.stream.kind == FrameKind::kDepth) {
    if (const auto done = to_depth(setup_, frame, kept.depth); !done.ok()) return done.error();
    apply_range_gate(kept.depth, stages.range_min, stages.range_max);
  }
  if (setup_.encoder.stream.kind == FrameKind::kPoints) {
    if (const auto done = to_points(setup_, frame, kept.points); !done.ok()) return done.error();
    std::erase_if(kept.points, [this](const Point3f& p) { return !in_range(setup_, p); });
  } else if (setup_.encoder.stream.kind == FrameKind::kRawCloud) {
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
  const Frame& original = original_of(frame);
  const StreamConfig& stream = decoder.config();
  const StreamConfig& expected = setup_.encoder.stream;
  out.comparable = stream.kind == expected.kind && stream.camera.width == expected.camera.width &&
                   stream.camera.height == expected.camera.height &&
                   stream.camera.unit_pm == expected.camera.unit_pm;
  if (stream.kind == FrameKind::kPoints)
    out.comparable = out.comparable && stream.axes == expected.axes;
  if (!out.comparable) return out;
  if (stream.kind == FrameKind::kPoints) {
    check_list(original, decoder, out);
    return out;
  }
  if (stream.kind == FrameKind::kRawCloud) {
    check_raw(original, decoder, out);
  } else {
    check_depth(original, decoder, out);
  }
  return out;
}

// No order, so each side is looked for in the other. Dropped points and points of surfaces have
// none that must be near: there the numbers are compared, and that nothing came that was not sent.
void ReferenceCheck::check_list(const Frame& original, const Decoder& decoder,
                                FrameCheck& out) const noexcept {
  const StreamConfig& stream = decoder.config();
  const std::span<const Point3f> in(original.points), back = decoder.cloud();
  const bool surfaces = stream.tolerance == ToleranceKind::kSurfaces;
  const bool may_drop = stream.drop_off_surface || outliers_dropped_;
  out.expected = static_cast<std::uint32_t>(in.size());
  const std::size_t lost = in.size() - std::min(in.size(), back.size());
  (may_drop ? out.dropped : out.missing) = static_cast<std::uint32_t>(lost);
  out.invented = static_cast<std::uint32_t>(back.size() - std::min(in.size(), back.size()));
  if (surfaces || out.missing > 0 || out.invented > 0) return;
  if (in.size() > original_bits_.size() || back.size() > decoded_bits_.size()) {
    out.comparable = false;
    return;
  }
  if (stream.tolerance == ToleranceKind::kLossless) {
    const auto sort_bits = [](std::span<const Point3f> points, auto& bits) {
      for (std::size_t i = 0; i < points.size(); ++i)
        bits[i] = {rank_of_float(points[i].x), rank_of_float(points[i].y),
                   rank_of_float(points[i].z)};
      std::sort(bits.begin(), bits.begin() + static_cast<std::ptrdiff_t>(points.size()));
    };
    sort_bits(in, original_bits_);
    sort_bits(back, decoded_bits_);
    const bool all = std::includes(
        original_bits_.begin(), original_bits_.begin() + static_cast<std::ptrdiff_t>(in.size()),
        decoded_bits_.begin(), decoded_bits_.begin() + static_cast<std::ptrdiff_t>(back.size()));
    if (!all) out.max_ratio = FrameCheck::kBeyond;
    return;
  }
  const double bound_m = Bound(tolerance_, stream).at(0);
  if (!original_grid_.fill(in, bound_m) || !decoded_grid_.fill(back, bound_m)) return;
  double worst = decoded_grid_.farthest_m(original_grid_);
  if (!may_drop) worst = std::max(worst, original_grid_.farthest_m(decoded_grid_));
  out.max_ratio = std::isfinite(worst) ? worst / bound_m : FrameCheck::kBeyond;
  out.max_error_m = std::isfinite(worst) ? worst : 0;
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
  const Frame& original = original_of(frame);
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
