// What the programs that train depth images' starting probabilities share: a list of command lines
// encoded and decoded slice by slice, and the statistics of one context over all slices.
#pragma once

#include <cstdint>
#include <functional>
#include <span>
#include <string>

#include "apps/common/options.hpp"
#include "core/wire/frame_unpack.hpp"

namespace planecast::bench {

/// One context over all slices: the decoder's model at the end of each is a sample of what a start
/// should be. The mean is the probability, the spread between slices says how soon a tile should
/// trust itself instead.
struct Context {
  double weight = 0, sum = 0, squares = 0, noise = 0;

  /// Adds a slice that ended with probability `p` after `seen` decisions.
  void add(double p, double seen);
  double mean() const { return weight > 0 ? (sum + 0.4) / (weight + 0.8) : 0.5; }
  /// Decisions of its own after which a tile knows as much as the mean does.
  double trust() const;
};

/// A start as the tables of core/wire/*_trained.inc hold it: 12 bits of probability, 4 of age.
std::uint16_t start_of(const Context& context);

struct DepthTraining {
  const char* program = "";  ///< named in errors
  Effort effort = Effort::kFast;
  bool lossless_only = false;
  /// Each decoded tile: the decoder still has its models; depth [counts] and labels of the image.
  std::function<void(const CodingTables&, const TileUnpacker&, const TileContent&,
                     std::span<const std::uint16_t>, std::span<const std::uint8_t>)>
      tile = {};
  std::function<void()> end_input = [] {};
};

/// Goes through the command lines of a file: inputs and codec options a row, '#' begins a comment,
/// '@' stands for $PLANECAST_DATA (else ../shared/data). Returns an exit code; errors are printed.
int train_depth(const std::string& list, const DepthTraining& training);

}  // namespace planecast::bench
