// The probability models of a tile, one set for each binary decision of docs/wire-format.md,
// "Tile". Both halves start every tile from the same trained constants.
#pragma once

#include <cstddef>
#include <cstdint>

#include "core/predict/pixel_predictor.hpp"
#include "core/wire/bit_model.hpp"

namespace planecast {

/// Longest correction coded in unary steps; longer ones are jumps.
inline constexpr int kMaxUnary = 12;
inline constexpr int kMaskContexts = 256;
inline constexpr int kLabelBits = 6;
inline constexpr int kJumpBits = 5;
/// Steps of a flat block's plane have at most kPlaneLengths - 1 bits.
inline constexpr int kPlaneLengths = 13;
inline constexpr int kPlaneContexts = 6;

struct TileModels {
  TileModels() noexcept;  ///< nothing known; not inline, which would be a kilobyte each

  BitModel block_any[9];   ///< the block has a reading; by left and above block
  BitModel block_full[9];  ///< ... and no hole
  BitModel
      block_corrected[18];  ///< ... and a correction that is not zero; by left, above, labelled
  BitModel label_as_left[4];
  BitModel label_as_above[4];
  BitModel label_index[1 << kLabelBits];
  BitModel block_second[3];    ///< surfaces kind: a second surface crosses the block
  BitModel block_uniform[3];   ///< surfaces kind: every reading is on the first surface
  BitModel on_surface[2][27];  ///< surfaces kind: by the labels of left, above, above-left
  BitModel mask[kMaskContexts];
  BitModel correction[kCorrectionContexts];
  BitModel sign[kSignContexts];
  BitModel magnitude[kMagnitudeContexts][kMaxUnary];
  BitModel jump_length[1 << kJumpBits];
  BitModel jump_top[17];
  BitModel block_flat[18];  ///< a flat block; by left, above, labelled
  BitModel plane_length[3][kPlaneContexts][kPlaneLengths];  ///< bits of offset, dx, dy, in unary
  BitModel plane_sign[3];
  BitModel plane_top[3][kPlaneLengths];  ///< second highest bit, by length
};

/// The models as one array, in the order of their declaration.
inline constexpr std::size_t kTileModelCount = sizeof(TileModels) / sizeof(BitModel);

/// Models at the start of a tile, for lossless and for bounded streams.
const TileModels& trained_models(bool lossless) noexcept;

}  // namespace planecast
