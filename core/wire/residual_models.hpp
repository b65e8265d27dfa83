// The symbol models of a lossless tile's residuals and what they start from.
#pragma once

#include "core/predict/residual_context.hpp"
#include "core/wire/symbol_model.hpp"

namespace planecast {

struct ResidualModels {
  SymbolModel of[kResidualContexts];
};

/// Models at the start of a lossless tile: trained constants.
const ResidualModels& trained_residuals() noexcept;

}  // namespace planecast
