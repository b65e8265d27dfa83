#include "core/ring/asymmetric_fence.hpp"

#if defined(__linux__)
#include <sys/syscall.h>
#include <unistd.h>
#endif

namespace planecast {
namespace {

// From linux/membarrier.h, which older headers lack in part.
constexpr int kPrivateExpedited = 1 << 3;
constexpr int kRegisterPrivateExpedited = 1 << 4;

bool membarrier([[maybe_unused]] int command) noexcept {
#if defined(SYS_membarrier)
  return ::syscall(SYS_membarrier, command, 0, 0) == 0;
#else
  return false;
#endif
}

}  // namespace

bool asymmetric_fence_available() noexcept {
  static const bool available = membarrier(kRegisterPrivateExpedited);
  return available;
}

bool heavy_fence() noexcept {
  return membarrier(kPrivateExpedited);
}

}  // namespace planecast
