#include "core/sim/depth_noise.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace planecast {
namespace {

constexpr std::uint32_t kCell = 8;  // scale of the shared noise [px]
constexpr unsigned kTableBits = 14;
constexpr std::size_t kTableSize = std::size_t{1} << kTableBits;

// Quantiles of the normal distribution at the middle of 2^14 equal shares, scaled to variance 1:
// one table look-up draws a normal number (to 4 sigma) from 14 random bits.
std::vector<float> make_normal_table() {
  std::vector<double> table(kTableSize);
  double square = 0;
  for (std::size_t i = 0; i < kTableSize; ++i) {
    const double share = (static_cast<double>(i) + 0.5) / static_cast<double>(kTableSize);
    double low = -6;
    double high = 6;
    for (int step = 0; step < 40; ++step) {
      const double middle = 0.5 * (low + high);
      (0.5 * std::erfc(-middle * std::sqrt(0.5)) < share ? low : high) = middle;
    }
    table[i] = low;
    square += low * low;
  }
  const double scale = std::sqrt(static_cast<double>(kTableSize) / square);
  std::vector<float> out;
  for (const double value : table) out.push_back(static_cast<float>(scale * value));
  return out;
}

double normal(std::uint32_t bits) noexcept {
  static const std::vector<float> kTable = make_normal_table();
  return kTable[bits >> (32U - kTableBits)];
}

// Interpolation weights within a cell and the factor that keeps the variance at 1.
struct Blend {
  double near, far, scale;
};

std::array<Blend, kCell> make_blends() noexcept {
  std::array<Blend, kCell> out{};
  for (std::uint32_t i = 0; i < kCell; ++i) {
    const double far = static_cast<double>(i) / kCell;
    out[i] = {1 - far, far, 1 / std::sqrt((1 - far) * (1 - far) + far * far)};
  }
  return out;
}

}  // namespace

DepthNoise::DepthNoise(const DepthNoiseConfig& config, std::uint32_t width, std::uint32_t height)
    : config_(config),
      width_(width),
      height_(height),
      coarse_width_(width / kCell + 2),
      coarse_(std::size_t{coarse_width_} * (height / kCell + 2)),
      shadow_(width) {}

void DepthNoise::draw_coarse(Pcg32& random) {
  for (double& value : coarse_) value = normal(random.next());
}

double DepthNoise::coarse(std::uint32_t u, std::uint32_t v) const noexcept {
  static const std::array<Blend, kCell> kBlends = make_blends();
  const double* top = &coarse_[std::size_t{v / kCell} * coarse_width_ + u / kCell];
  const double* bottom = top + coarse_width_;
  const Blend& across = kBlends[u % kCell];
  const Blend& down = kBlends[v % kCell];
  const double upper = across.near * top[0] + across.far * top[1];
  const double lower = across.near * bottom[0] + across.far * bottom[1];
  return across.scale * down.scale * (down.near * upper + down.far * lower);
}

// The second eye is to the right: it sees pixel u at u - f b / z. A pixel is lost when one further
// right is seen at the same place or left of it: hidden, or (behind a thin object) out of the order
// that stereo matchers rely on.
void DepthNoise::cast_shadows(std::span<const double> true_z_m, std::uint32_t v) {
  double leftmost = 1e30;
  for (std::uint32_t i = width_; i-- > 0;) {
    const double z = true_z_m[std::size_t{v} * width_ + i];
    const double seen_at = z > 0 ? i - config_.shadow_px_m / z : 1e30;
    shadow_[i] = seen_at >= leftmost ? 1 : 0;
    leftmost = std::min(leftmost, seen_at);
  }
}

std::uint16_t DepthNoise::reading(double z_m, double gauss) const noexcept {
  const bool stereo = config_.noise.kind == NoiseModel::Kind::kStereo;
  double z = z_m;
  if (stereo) {
    const double inverse = 1 / z_m + config_.noise.s() * gauss;
    if (!(inverse > 0)) return 0;
    z = 1 / inverse;
  } else {
    z += config_.noise.sigma_m(z_m) * gauss;
  }
  if (config_.lattice_c_m > 0) {
    const double level = std::floor(config_.lattice_c_m / z + 0.5);
    if (!(level >= 1)) return 0;
    z = config_.lattice_c_m / level;
  }
  if (!(z >= config_.min_m && z <= config_.max_m)) return 0;
  const double count = std::floor(z / config_.metres_per_unit + 0.5);
  return count >= 1 && count <= 65535 ? static_cast<std::uint16_t>(count) : std::uint16_t{0};
}

void DepthNoise::apply(std::span<const double> true_z_m, Pcg32& random,
                       std::span<std::uint16_t> counts) {
  const double own = std::sqrt(1 - config_.correlated_share);
  const double shared = std::sqrt(config_.correlated_share);
  // The low 18 bits of each draw decide the drop-out, the high 14 the noise.
  const auto dropped_below = static_cast<std::uint32_t>(config_.dropout * 262144.0 + 0.5);
  draw_coarse(random);
  for (std::uint32_t v = 0; v < height_; ++v) {
    if (config_.shadow_px_m > 0) cast_shadows(true_z_m, v);
    for (std::uint32_t u = 0; u < width_; ++u) {
      const std::size_t i = std::size_t{v} * width_ + u;
      const std::uint32_t bits = random.next();
      const bool lost = (bits & 0x3FFFFU) < dropped_below || true_z_m[i] <= 0 || shadow_[u] != 0;
      counts[i] = lost ? std::uint16_t{0}
                       : reading(true_z_m[i], own * normal(bits) + shared * coarse(u, v));
    }
  }
}

}  // namespace planecast
