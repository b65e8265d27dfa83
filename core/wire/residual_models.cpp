#include "core/wire/residual_models.hpp"

#include "core/wire/start_reader.hpp"

namespace planecast {
namespace {

// Written by bench/pack_starts from residual_models_trained.inc.
constexpr std::uint8_t kPackedResiduals[] = {
#include "core/wire/residual_models_packed.inc"
};

}  // namespace

void unpack_residuals(bool every_count, ResidualModels& models) noexcept {
  StartReader reader(kPackedResiduals);
  ResidualStartReader starts(reader);
  const auto next = [&] {
    const SymbolModel sets[2] = {starts.next(false).model(), starts.next(true).model()};
    return sets[every_count ? 1 : 0];
  };
  for (SymbolModel& model : models.shape) model = next();
  for (SymbolModel& model : models.errors) model = next();
}

}  // namespace planecast
