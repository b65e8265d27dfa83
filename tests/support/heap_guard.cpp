#include "tests/support/heap_guard.hpp"

#include <execinfo.h>
#include <link.h>
#include <pthread.h>
#include <sys/resource.h>

#include <algorithm>
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
  std::uint64_t minor_faults, major_faults;  ///< before it was armed
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

std::atomic<std::uint64_t> total_minor_faults{0}, total_major_faults{0};
std::atomic<void (*)(const char*, const HeapGuardTotals&)> finish_call{nullptr};
std::atomic<std::uint64_t> mapped_bytes{0};
struct Range {
  std::uintptr_t first = UINTPTR_MAX, end = 0;
};

/// Where the main program lies; the first object that the linker lists.
Range main_program() noexcept {
  Range range;
  dl_iterate_phdr(
      [](dl_phdr_info* info, std::size_t, void* out) {
        auto& found = *static_cast<Range*>(out);
        for (int i = 0; i < info->dlpi_phnum; ++i) {
          const auto& part = info->dlpi_phdr[i];
          if (part.p_type != PT_LOAD) continue;
          const std::uintptr_t start = info->dlpi_addr + part.p_vaddr;
          found.first = std::min(found.first, start);
          found.end = std::max(found.end, start + part.p_memsz);
        }
        return 1;
      },
      &range);
  return range;
}

HeapGuardTotals to_totals(const auto& counts) noexcept {
  const auto get = [&](Offence kind) -> std::uint64_t {
    return counts[static_cast<std::size_t>(kind)];
  };
  return {get(Offence::kAllocate), get(Offence::kFree), get(Offence::kMap), get(Offence::kMutex),
          get(Offence::kWrite),    get(Offence::kWait), get(Offence::kIdle)};
}

// The first backtrace() of a process loads a library, hence allocates: do it before anything
// counts.
[[maybe_unused]] const int warmed_up = [] {
  std::array<void*, 4> frames{};
  return backtrace(frames.data(), static_cast<int>(frames.size()));
}();

void add_faults(HeapGuardTotals& totals, const ThreadState& state) noexcept {
  rusage now{};
  ::getrusage(RUSAGE_THREAD, &now);
  totals.minor_faults = static_cast<std::uint64_t>(now.ru_minflt) - state.minor_faults;
  totals.major_faults = static_cast<std::uint64_t>(now.ru_majflt) - state.major_faults;
}

// A thread that ends armed is finished by the destructor of its key.
void finish_thread(void* /*armed*/) noexcept {
  ThreadState& state = tls_state;
  if (!state.armed) return;
  state.armed = false;
  HeapGuardTotals totals = to_totals(state.counts);
  add_faults(totals, state);
  total_minor_faults.fetch_add(totals.minor_faults);
  total_major_faults.fetch_add(totals.major_faults);
  if (const auto call = finish_call.load(); call != nullptr) call(state.name, totals);
}

pthread_key_t end_key() noexcept {
  static const pthread_key_t key = [] {
    pthread_key_t made{};
    pthread_key_create(&made, finish_thread);
    return made;
  }();
  return key;
}
[[maybe_unused]] const pthread_key_t key_made_early = end_key();

}  // namespace

void guard_mapped(std::size_t bytes, const void* caller) noexcept {
  static const Range program = main_program();
  const auto at = reinterpret_cast<std::uintptr_t>(caller);
  if (at >= program.first && at < program.end) mapped_bytes.fetch_add(bytes);
}

bool guard_armed() noexcept {
  return tls_state.armed && !tls_state.inside;
}

void guard_report(Offence kind, const char* call) noexcept {
  ThreadState& state = tls_state;
  if (!state.armed || state.inside) return;
  ++state.counts[static_cast<std::size_t>(kind)];
  total_counts[static_cast<std::size_t>(kind)].fetch_add(1);
  if (kind == Offence::kIdle) return;
  state.inside = true;
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
  pthread_setspecific(end_key(), &tls_state);
  rusage now{};
  ::getrusage(RUSAGE_THREAD, &now);
  tls_state.minor_faults = static_cast<std::uint64_t>(now.ru_minflt);
  tls_state.major_faults = static_cast<std::uint64_t>(now.ru_majflt);
  tls_state.armed = true;
}

void HeapGuard::disarm_this_thread(const char* /*name*/) noexcept {
  finish_thread(nullptr);
}

void HeapGuard::on_finish(void (*call)(const char*, const HeapGuardTotals&)) noexcept {
  finish_call.store(call);
}

std::uint64_t HeapGuard::mapped_by_program() noexcept {
  return mapped_bytes.load();
}

HeapGuardTotals HeapGuard::totals() noexcept {
  HeapGuardTotals totals = to_totals(total_counts);
  totals.minor_faults = total_minor_faults.load();
  totals.major_faults = total_major_faults.load();
  return totals;
}

HeapGuardTotals HeapGuard::this_thread() noexcept {
  HeapGuardTotals totals = to_totals(tls_state.counts);
  if (tls_state.armed) add_faults(totals, tls_state);
  return totals;
}

void HeapGuard::reset() noexcept {
  for (auto& count : total_counts) count.store(0);
  total_minor_faults.store(0);
  total_major_faults.store(0);
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
