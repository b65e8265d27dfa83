#include "core/filter/statistical_outliers.hpp"

#include <algorithm>
#include <cmath>

namespace planecast {

Status flag_statistical_outliers(std::span<const float> mean_distance, double deviations,
                                 std::span<std::uint8_t> flags, StatisticalCut& cut) noexcept {
  cut = {};
  if (flags.size() != mean_distance.size()) return Status::kWrongSize;
  if (!(deviations >= 0) || !std::isfinite(deviations)) return Status::kBadConfig;
  std::fill(flags.begin(), flags.end(), std::uint8_t{0});
  const auto n = static_cast<double>(mean_distance.size());
  if (mean_distance.size() < 2) return Status::kOk;
  double sum = 0;
  for (const float d : mean_distance) sum += d;
  cut.mean = sum / n;
  double squares = 0;  // around the mean: two passes keep what one pass of squares would cancel
  for (const float d : mean_distance) squares += (d - cut.mean) * (d - cut.mean);
  cut.deviation = std::sqrt(squares / (n - 1));
  cut.cut = cut.mean + deviations * cut.deviation;
  for (std::size_t i = 0; i < flags.size(); ++i) {
    flags[i] = mean_distance[i] > cut.cut ? 1 : 0;
    cut.outliers += flags[i];
  }
  return Status::kOk;
}

}  // namespace planecast
