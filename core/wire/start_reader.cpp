#include "core/wire/start_reader.hpp"

namespace planecast {

template class StartWords<StartReader>;
template class ResidualStarts<StartReader>;

}  // namespace planecast
