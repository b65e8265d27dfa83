// What unpacks the starts of models (start_code.hpp): in one place, so that a board holds it once.
#pragma once

#include "core/wire/start_code.hpp"
#include "core/wire/start_io.hpp"

namespace planecast {

extern template class StartWords<StartReader>;
extern template class ResidualStarts<StartReader>;
using StartWordReader = StartWords<StartReader>;
using ResidualStartReader = ResidualStarts<StartReader>;

}  // namespace planecast
