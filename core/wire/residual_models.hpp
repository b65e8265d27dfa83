// The symbol models of a lossless tile's residuals and what they start from.
#pragma once

#include "core/predict/residual_context.hpp"
#include "core/wire/symbol_model.hpp"

namespace planecast {

struct ResidualModels {
  SymbolModel shape[kShapeContexts];
  SymbolModel errors[kErrorContexts];  ///< used where a sensor says every count
};

/// Models at the start of a lossless tile: trained constants, one set for sensors whose levels lie
/// on a lattice and one for those that say every count.
const ResidualModels& trained_residuals(bool every_count) noexcept;

}  // namespace planecast
