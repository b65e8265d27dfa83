// The guard put into a program that knows nothing of it (LD_PRELOAD). A thread counts from the
// moment it bears a name of PLANECAST_GUARD_THREADS ("fit,pack"), which our threads take when they
// are ready. At the end one line a thread goes to the file PLANECAST_GUARD_REPORT, then the bytes
// that the program mapped, then the first offence with its backtrace.
#include <dlfcn.h>
#include <pthread.h>

#include <array>
#include <atomic>
#include <cstdio>
#include <cstdlib>
#include <cstring>

#include "tests/support/heap_guard.hpp"
#include "tests/support/heap_guard_hooks.hpp"

namespace planecast::test {
namespace {

struct Finished {
  std::array<char, 16> name{};
  HeapGuardTotals counts;
};
std::array<Finished, 64> finished;
std::atomic<std::size_t> finished_count{0};
std::array<std::array<char, 16>, 16> names;  // a thread's name must outlive it

void keep(const char* name, const HeapGuardTotals& counts) {
  const std::size_t i = finished_count.fetch_add(1);
  if (i >= finished.size()) return;
  std::strncpy(finished[i].name.data(), name, finished[i].name.size() - 1);
  finished[i].counts = counts;
}

/// The name as the guard may keep it; null when it is not on the list.
const char* listed(const char* name) {
  const char* list = std::getenv("PLANECAST_GUARD_THREADS");
  const std::size_t bytes = std::strlen(name);
  for (const char* at = list; at != nullptr && *at != 0;) {
    const char* comma = std::strchr(at, ',');
    const std::size_t length = comma == nullptr ? std::strlen(at) : std::size_t(comma - at);
    if (length == bytes && std::strncmp(at, name, bytes) == 0) {
      for (auto& kept : names) {
        if (kept[0] == 0) std::strncpy(kept.data(), name, kept.size() - 1);
        if (std::strcmp(kept.data(), name) == 0) return kept.data();
      }
    }
    at = comma == nullptr ? nullptr : comma + 1;
  }
  return nullptr;
}

void write_report() {
  const char* path = std::getenv("PLANECAST_GUARD_REPORT");
  std::FILE* file = path == nullptr ? nullptr : std::fopen(path, "w");
  if (file == nullptr) return;
  for (std::size_t i = 0; i < finished_count.load() && i < finished.size(); ++i) {
    const auto& [name, c] = finished[i];
    const auto n = [](std::uint64_t value) { return static_cast<unsigned long long>(value); };
    std::fprintf(file,
                 "thread %s allocations %llu frees %llu maps %llu mutex_waits %llu writes %llu "
                 "waits %llu idle %llu minor_faults %llu major_faults %llu\n",
                 name.data(), n(c.allocations), n(c.frees), n(c.maps), n(c.mutex_waits),
                 n(c.writes), n(c.waits), n(c.idle), n(c.minor_faults), n(c.major_faults));
  }
  std::fprintf(file, "mapped %llu\n",
               static_cast<unsigned long long>(HeapGuard::mapped_by_program()));
  std::fputs(HeapGuard::first_offender().c_str(), file);
  std::fclose(file);
}

[[maybe_unused]] const bool ready = [] {
  HeapGuard::on_finish(keep);
  std::atexit(write_report);
  return true;
}();

}  // namespace
}  // namespace planecast::test

extern "C" int pthread_setname_np(pthread_t thread, const char* name) noexcept {
  using Real = int (*)(pthread_t, const char*);
  static const auto real = reinterpret_cast<Real>(dlsym(RTLD_NEXT, "pthread_setname_np"));
  const int result = real(thread, name);
  if (pthread_equal(thread, pthread_self()) == 0) return result;
  const char* kept = planecast::test::listed(name);
  if (kept != nullptr) planecast::test::HeapGuard::arm_this_thread(kept);
  return result;
}
