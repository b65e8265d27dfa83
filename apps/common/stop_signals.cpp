#include "apps/common/stop_signals.hpp"

#include <ctime>

#include "transport/wake.hpp"

namespace planecast {

StopSignals::StopSignals() noexcept {
  sigemptyset(&set_);
  for (const int number : {SIGINT, SIGTERM, SIGHUP}) sigaddset(&set_, number);
  pthread_sigmask(SIG_BLOCK, &set_, nullptr);
}

bool StopSignals::wait(std::int64_t timeout_ns) noexcept {
  if (signal_ != 0) return true;
  const timespec timeout = to_timespec(timeout_ns > 0 ? timeout_ns : 0);
  const int number = sigtimedwait(&set_, nullptr, &timeout);
  if (number > 0) signal_ = number;
  return signal_ != 0;
}

}  // namespace planecast
