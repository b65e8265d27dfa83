// Tables that are computed when the program starts.
#include "core/predict/blend_predictor.hpp"
#include "core/predict/pixel_predictor.hpp"

namespace planecast::detail {

const BlendWeights kBlendWeights{};
const ActivityTable kActivity{};

}  // namespace planecast::detail
