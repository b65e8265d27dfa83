#include "core/wire/residual_models.hpp"

namespace planecast {
namespace {

// Written by bench/train_models; see there.
constexpr ResidualModels kStarts[2] = {
#include "core/wire/residual_models_trained.inc"
};

}  // namespace

const ResidualModels& trained_residuals(bool every_count) noexcept {
  return kStarts[every_count ? 1 : 0];
}

}  // namespace planecast
