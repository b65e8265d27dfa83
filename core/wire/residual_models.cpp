#include "core/wire/residual_models.hpp"

namespace planecast {
namespace {

// Written by bench/train_models; see there.
constexpr ResidualModels kStarts = {{
#include "core/wire/residual_models_trained.inc"
}};

}  // namespace

const ResidualModels& trained_residuals() noexcept {
  return kStarts;
}

}  // namespace planecast
