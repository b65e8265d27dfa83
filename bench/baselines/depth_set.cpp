#include "bench/baselines/depth_baselines.hpp"

namespace planecast::baselines {
namespace {

constexpr int kSteps[] = {2, 5, 10, 20, 50, 100};  // counts: millimetres on the usual sensors
constexpr int kNear[] = {1, 2, 5, 10, 25, 50};     // counts
constexpr int kNearIndex[] = {1, 2, 4};            // levels of the lattice

// `make()` lossless and at every step.
template <class Make>
void add_steps(DepthBaselines& set, Make make) {
  set.push_back(make());
  for (const int step : kSteps) set.push_back(z_step(step, make()));
}

}  // namespace

DepthBaselines depth_set(std::vector<std::string>& skipped) {
  DepthBaselines set;
  const struct {
    ByteCoder coder;
    int level;
    const char* package;
  } coders[] = {{ByteCoder::kZstd, 3, "zstd (libzstd-dev)"},
                {ByteCoder::kBzip2, 9, "bzip2 (libbz2-dev)"},
                {ByteCoder::kXz, 6, "xz (liblzma-dev)"}};
  for (const auto& c : coders) {
    if (available(c.coder)) {
      add_steps(set, [&c] { return byte_depth(c.coder, c.level); });
    } else {
      skipped.emplace_back(c.package);
    }
  }
  add_steps(set, [] { return rvl(0); });
  if (available(ByteCoder::kZstd)) {
    for (const int level : {1, 3}) add_steps(set, [level] { return rvl(level); });
  }
  add_steps(set, [] { return png_depth(1); });
  add_steps(set, [] { return png_depth(6); });
  if (charls_available()) {
    set.push_back(charls_depth(0));
    for (const int near : kNear) set.push_back(charls_depth(near));
    set.push_back(lattice_index(charls_depth(0)));
    for (const int near : kNearIndex) set.push_back(lattice_index(charls_depth(near)));
  } else {
    skipped.emplace_back("CharLS (libcharls-dev)");
  }
  if (jpeg2000_available()) {
    add_steps(set, [] { return jpeg2000_depth(); });
  } else {
    skipped.emplace_back("JPEG 2000 (libopenjp2-7-dev)");
  }
  return set;
}

}  // namespace planecast::baselines
