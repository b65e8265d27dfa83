#include "tests/support/heap_guard.hpp"

#include <execinfo.h>

#include <array>
#include <atomic>
#include <cstdlib>

#include "tests/support/heap_guard_hooks.hpp"

namespace planecast::test {
namespace {

constexpr int kMaxFrames = 32;

// The counters of one thread. Trivial, so that it lies in static TLS and costs no allocation.
struct ThreadState {
  bool armed;
  bool inside;  ///< while the guard itself works, nothing counts
  const char* name;
  std::array<std::uint64_t, kOffenceKinds> counts;
};

constinit thread_local ThreadState tls_state{};

std::array<std::atomic<std::uint64_t>, kOffenceKinds> total_counts{};

struct FirstOffender {
  std::atomic<int> state{0};  ///< 0 none, 1 being written, 2 complete
  const char* thread = "";
  const char* call = "";
  std::array<void*, kMaxFrames> frames{};
  int frame_count = 0;
};
FirstOffender first;

HeapGuardTotals to_totals(const auto& counts) noexcept {
  const auto get = [&](Offence kind) -> std::uint64_t {
    return counts[static_cast<std::size_t>(kind)];
  };
  return {get(Offence::kAllocate), get(Offence::kFree), get(Offence::kMap), get(Offence::kBlock)};
}

// The first backtrace() of a process loads a library, hence allocates: do it before anything
// counts.
[[maybe_unused]] const int warmed_up = [] {
  std::array<void*, 4> frames{};
  return backtrace(frames.data(), static_cast<int>(frames.size()));
}();

}  // namespace

bool guard_armed() noexcept {
  return tls_state.armed && !tls_state.inside;
}

void guard_report(Offence kind, const char* call) noexcept {
  ThreadState& state = tls_state;
  if (!state.armed || state.inside) return;
  state.inside = true;
  ++state.counts[static_cast<std::size_t>(kind)];
  total_counts[static_cast<std::size_t>(kind)].fetch_add(1);
  int none = 0;
  if (first.state.compare_exchange_strong(none, 1)) {
    first.thread = state.name;
    first.call = call;
    first.frame_count = backtrace(first.frames.data(), kMaxFrames);
    first.state.store(2);
  }
  state.inside = false;
}

bool HeapGuard::available() noexcept {
  return kHooksCompiledIn;
}

void HeapGuard::arm_this_thread(const char* name) noexcept {
  tls_state.name = name;
  tls_state.counts = {};
  tls_state.armed = true;
}

void HeapGuard::disarm_this_thread(const char* /*name*/) noexcept {
  tls_state.armed = false;
}

HeapGuardTotals HeapGuard::totals() noexcept {
  return to_totals(total_counts);
}

HeapGuardTotals HeapGuard::this_thread() noexcept {
  return to_totals(tls_state.counts);
}

void HeapGuard::reset() noexcept {
  for (auto& count : total_counts) count.store(0);
  first.state.store(0);
}

std::string HeapGuard::first_offender() {
  if (first.state.load() != 2) return {};
  std::string text = std::string(first.call) + " on thread '" + first.thread + "'\n";
  char** symbols = backtrace_symbols(first.frames.data(), first.frame_count);
  for (int i = 0; symbols != nullptr && i < first.frame_count; ++i)
    text.append("  ").append(symbols[i]).append("\n");
  std::free(symbols);
  return text;
}

}  // namespace planecast::test
