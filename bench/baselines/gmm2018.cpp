// Navarrete, Viejo, Cazorla, "Compression and registration of 3D point clouds using GMMs" (Pattern
// Recogn. Lett. 110, 2018), as read here: planar patches are the points of interest, expectation
// maximisation fits a mixture of Gaussians to each, and a Gaussian travels as 40 bytes: weight,
// mean and six terms of its covariance, float32; the decoder draws as many points. Points on no
// patch are kept as they are, which lands near the ratio that the seed paper reports.
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "bench/baselines/byte_io.hpp"
#include "bench/baselines/plane_patches.hpp"
#include "bench/baselines/point_baselines.hpp"
#include "core/base/random.hpp"

namespace planecast::baselines {
namespace {

constexpr std::size_t kPointsEach = 400;  // members that one Gaussian is to explain
constexpr std::size_t kMostEach = 64;     // Gaussians of a patch
constexpr int kRounds = 8;
constexpr double kLeastVariance = 1e-8;  // of the patch's own: keeps covariances invertible

struct Gaussian {
  double weight = 0;  // points it stands for
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  Eigen::Matrix3d covariance = Eigen::Matrix3d::Identity();
};

struct Packed {
  float weight, mean[3], covariance[6];
};

using Mixture = std::vector<Gaussian>;

// Means on members spread over the patch: each the farthest from those before, of a sample.
Mixture start(const std::vector<Eigen::Vector3d>& x, std::size_t count, double variance) {
  Mixture mixture(count);
  const std::size_t stride = std::max<std::size_t>(x.size() / 2048, 1);
  std::vector<double> nearest((x.size() + stride - 1) / stride, 1e300);
  std::size_t at = 0;
  for (Gaussian& g : mixture) {
    g.mean = x[at * stride];
    g.weight = static_cast<double>(x.size()) / static_cast<double>(count);
    g.covariance *= variance / static_cast<double>(count);
    std::size_t far = 0;
    for (std::size_t i = 0; i < nearest.size(); ++i) {
      nearest[i] = std::min(nearest[i], (x[i * stride] - g.mean).squaredNorm());
      if (nearest[i] > nearest[far]) far = i;
    }
    at = far;
  }
  return mixture;
}

// One round of expectation and maximisation.
void improve(const std::vector<Eigen::Vector3d>& x, double least, Mixture& mixture) {
  const std::size_t count = mixture.size();
  std::vector<Eigen::Matrix3d> inverse(count);
  std::vector<double> log_scale(count);
  for (std::size_t k = 0; k < count; ++k) {
    const auto& c = mixture[k].covariance;
    inverse[k] = c.inverse();
    log_scale[k] = std::log(std::max(mixture[k].weight, 1e-9)) - 0.5 * std::log(c.determinant());
  }
  Mixture next(count);
  std::vector<Eigen::Vector3d> shift(count);  // moments about the old means: no digits lost
  for (std::size_t k = 0; k < count; ++k) {
    shift[k] = mixture[k].mean;
    next[k].covariance.setZero();
  }
  std::vector<double> share(count);
  for (const Eigen::Vector3d& p : x) {
    double most = -1e300, sum = 0;
    for (std::size_t k = 0; k < count; ++k) {
      const Eigen::Vector3d d = p - shift[k];
      share[k] = log_scale[k] - 0.5 * d.dot(inverse[k] * d);
      most = std::max(most, share[k]);
    }
    for (double& s : share) sum += s = s < most - 30 ? 0 : std::exp(s - most);
    for (std::size_t k = 0; k < count; ++k) {
      if (share[k] == 0) continue;
      const double r = share[k] / sum;
      const Eigen::Vector3d d = p - shift[k];
      next[k].weight += r;
      next[k].mean += r * d;
      next[k].covariance += r * d * d.transpose();
    }
  }
  for (std::size_t k = 0; k < count; ++k) {
    Gaussian& g = next[k];
    if (g.weight < 4) {  // explains nothing any more: left where it was, without weight
      g = mixture[k];
      g.weight = 0;
      continue;
    }
    g.mean /= g.weight;
    g.covariance =
        g.covariance / g.weight - g.mean * g.mean.transpose() + least * Eigen::Matrix3d::Identity();
    g.mean += shift[k];
  }
  mixture = std::move(next);
}

// Whole numbers of points, `total` in all, as near to the weights as can be.
void round_weights(Mixture& mixture, std::size_t total) {
  double carry = 0;
  std::size_t given = 0;
  for (Gaussian& g : mixture) {
    const double exact = g.weight + carry;
    const double whole = std::max(std::floor(exact + 0.5), 0.0);
    carry = exact - whole;
    g.weight = whole;
    given += static_cast<std::size_t>(whole);
  }
  auto most = std::max_element(mixture.begin(), mixture.end(),
                               [](const auto& a, const auto& b) { return a.weight < b.weight; });
  most->weight += static_cast<double>(total) - static_cast<double>(given);
}

Mixture fit(const std::vector<Eigen::Vector3d>& x) {
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const auto& p : x) mean += p;
  mean /= static_cast<double>(x.size());
  double variance = 0;
  for (const auto& p : x) variance += (p - mean).squaredNorm();
  variance = std::max(variance / static_cast<double>(x.size()), 1e-12);
  Mixture mixture =
      start(x, std::clamp<std::size_t>(x.size() / kPointsEach, 1, kMostEach), variance);
  for (int round = 0; round < kRounds; ++round) improve(x, variance * kLeastVariance, mixture);
  std::erase_if(mixture, [](const Gaussian& g) { return g.weight == 0; });
  round_weights(mixture, x.size());
  return mixture;
}

Packed pack(const Gaussian& g) {
  const auto f = [](double value) { return static_cast<float>(value); };
  const auto& c = g.covariance;
  return {f(g.weight),
          {f(g.mean.x()), f(g.mean.y()), f(g.mean.z())},
          {f(c(0, 0)), f(c(0, 1)), f(c(0, 2)), f(c(1, 1)), f(c(1, 2)), f(c(2, 2))}};
}

// A normal deviate by Box and Muller.
double normal(Pcg32& random) {
  const double u = 1 - random.uniform(), v = random.uniform();
  return std::sqrt(-2 * std::log(u)) * std::cos(2 * std::numbers::pi * v);
}

void draw(const Packed& g, Pcg32& random, PointList& out) {
  const float* c = g.covariance;
  Eigen::Matrix3d covariance;
  covariance << c[0], c[1], c[2], c[1], c[3], c[4], c[2], c[4], c[5];
  // LDLT: rounding to float may have left a flat covariance not quite definite.
  const Eigen::LDLT<Eigen::Matrix3d> ldlt(covariance);
  const Eigen::Vector3d d = ldlt.vectorD().cwiseMax(0).cwiseSqrt();
  const Eigen::Matrix3d l = ldlt.matrixL();
  for (auto left = std::llround(g.weight); left > 0; --left) {
    const Eigen::Vector3d n(normal(random), normal(random), normal(random));
    const Eigen::Vector3d scaled = l * d.cwiseProduct(n);
    const Eigen::Vector3d p = ldlt.transpositionsP().transpose() * scaled;
    out.push_back({static_cast<float>(p.x() + g.mean[0]), static_cast<float>(p.y() + g.mean[1]),
                   static_cast<float>(p.z() + g.mean[2])});
  }
}

class Gmm2018 : public PointBaseline {
 public:
  Gmm2018() : PointBaseline("GMM2018", "a Gaussian for 400 points") {}

  Bytes encode(const PointList& points) const override {
    const PlanePatches found = find_patches(points);
    Mixture all;
    for (const PlanePatch& patch : found.patches) {
      std::vector<Eigen::Vector3d> x;
      for (const std::uint32_t i : patch.members)
        x.emplace_back(points[i].x, points[i].y, points[i].z);
      const Mixture mixture = fit(x);
      all.insert(all.end(), mixture.begin(), mixture.end());
    }
    Bytes out;
    put_varint(out, all.size());
    for (const Gaussian& g : all) put(out, pack(g));
    put_varint(out, found.rest.size());
    for (const std::uint32_t i : found.rest) put(out, points[i]);
    return out;
  }

  PointList decode(const Bytes& bytes) const override {
    ByteReader reader(bytes);
    Pcg32 random(1);
    PointList out;
    for (std::uint64_t left = reader.take_varint(); left > 0; --left)
      draw(reader.take<Packed>(), random, out);
    for (std::uint64_t left = reader.take_varint(); left > 0; --left)
      out.push_back(reader.take<Point3f>());
    return out;
  }
};

}  // namespace

std::unique_ptr<PointBaseline> gmm2018() {
  return std::make_unique<Gmm2018>();
}

}  // namespace planecast::baselines
