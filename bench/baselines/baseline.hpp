// What every codec that we compare with looks like to the benchmarks: a name, a setting, data to
// bytes and bytes to data. Errors are exceptions: nothing here runs in the product.
#pragma once

#include <cstdint>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/cloud/sensor_frame.hpp"

namespace planecast::baselines {

using Bytes = std::vector<std::uint8_t>;
using PointList = std::vector<Point3f>;  ///< [m], every one finite

/// One codec at one setting. `Data` is DepthImage (0 = no reading) or PointList. One thread.
template <class Data>
class Baseline {
 public:
  Baseline(std::string name, std::string setting)
      : name_(std::move(name)), setting_(std::move(setting)) {}
  virtual ~Baseline() = default;

  const std::string& name() const { return name_; }
  const std::string& setting() const { return setting_; }
  /// Everything that decode() needs is in the bytes. Throws std::runtime_error.
  virtual Bytes encode(const Data& data) const = 0;
  virtual Data decode(const Bytes& bytes) const = 0;

 private:
  std::string name_, setting_;
};

using DepthBaseline = Baseline<DepthImage>;
using PointBaseline = Baseline<PointList>;
using DepthBaselines = std::vector<std::unique_ptr<DepthBaseline>>;
using PointBaselines = std::vector<std::unique_ptr<PointBaseline>>;

[[noreturn]] inline void fail(const std::string& codec, const std::string& what) {
  throw std::runtime_error(codec + ": " + what);
}

}  // namespace planecast::baselines
