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
/// on a lattice and one for those that say every count. Overwrites all of `models`. Cold path, some
/// 10^8 instructions and 20 kB of stack: a stream's tables hold them (CodingTables::residuals).
void unpack_residuals(bool every_count, ResidualModels& models) noexcept;

}  // namespace planecast
