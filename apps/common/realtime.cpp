#include "apps/common/realtime.hpp"

#include <fmt/format.h>
#include <malloc.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/resource.h>

#include <CLI/CLI.hpp>
#include <array>
#include <atomic>
#include <cerrno>
#include <charconv>
#include <cstdio>
#include <cstring>
#include <limits>
#include <memory>
#include <utility>

#include "core/pipeline/worker_thread.hpp"

namespace planecast {
namespace {

constexpr std::size_t kForeignStackBytes = std::size_t{1} << 20U;  // of threads that libraries make
constexpr unsigned kCapIpcLock = 14;

std::atomic<int> wished_priority{0};
std::atomic<bool> any_fifo_refused{false};

// A process without this capability may lock up to RLIMIT_MEMLOCK, and then every later mapping
// fails that would go beyond.
bool may_lock_anything() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_MEMLOCK, &limit) == 0 && limit.rlim_cur == RLIM_INFINITY) return true;
  const std::unique_ptr<std::FILE, int (*)(std::FILE*)> file(std::fopen("/proc/self/status", "r"),
                                                             std::fclose);
  std::array<char, 256> line{};
  while (file != nullptr && std::fgets(line.data(), line.size(), file.get()) != nullptr) {
    unsigned long long set = 0;
    if (std::sscanf(line.data(), "CapEff: %llx", &set) == 1) return (set >> kCapIpcLock & 1U) != 0;
  }
  return false;
}

}  // namespace

Result<std::uint64_t> parse_bytes(std::string_view text) {
  constexpr std::array kUnits = {std::pair{"", 0U},     std::pair{"B", 0U},   std::pair{"K", 10U},
                                 std::pair{"KiB", 10U}, std::pair{"M", 20U},  std::pair{"MiB", 20U},
                                 std::pair{"G", 30U},   std::pair{"GiB", 30U}};
  std::uint64_t value = 0;
  const char* end = text.data() + text.size();
  const auto [stop, code] = std::from_chars(text.data(), end, value);
  const std::string_view unit(stop, static_cast<std::size_t>(end - stop));
  for (const auto& [name, shift] : kUnits) {
    if (code != std::errc() || unit != name || value == 0) continue;
    if (value > std::numeric_limits<std::uint64_t>::max() >> shift) break;
    return value << shift;
  }
  return {Status::kUsage,
          fmt::format("'{}' is not a number of bytes above 0; give it as in 64MiB", text)};
}

void add_realtime_options(CLI::App& app, RealtimeOptions& options) {
  constexpr const char* kGroup = "Real time";
  app.add_flag("--mlock", options.lock_memory, "Keep all memory in RAM (mlockall)")->group(kGroup);
  app.add_option("--fifo", options.fifo_priority,
                 "Real-time scheduling (SCHED_FIFO) with priority N, 1 to 99, for all\n"
                 "threads that touch frames. Default: the ordinary scheduler")
      ->option_text("N")
      ->check(CLI::Range(1, 99))
      ->group(kGroup);
  app.add_option("--first-core", options.first_core,
                 "Stage i runs on core N + i of those allowed. Default: anywhere")
      ->option_text("N")
      ->check(CLI::Range(0, 4095))
      ->group(kGroup);
  app.add_option("--watchdog-ms", options.watchdog_ms,
                 "Count frames that keep a stage busy for longer, and say so when a\n"
                 "stage is silent for so long. Default: no watchdog")
      ->option_text("MS")
      ->check(CLI::Range(0.1, 1e6))
      ->group(kGroup);
  const auto set_limit = [&options](const std::string& text) {
    const auto bytes = parse_bytes(text);
    if (!bytes) throw CLI::ValidationError("--memory-limit", bytes.error().message);
    options.memory_limit = *bytes;
  };
  app.add_option_function<std::string>(
         "--memory-limit", set_limit,
         "Refuse to start when frames and stacks need more than this, as in\n"
         "64MiB. What the system allows and has is always looked at")
      ->option_text("BYTES")
      ->group(kGroup)
      ->take_last();
}

std::string lock_all_memory() {
  // The heap neither gives pages back nor maps large blocks by themselves: what was locked stays.
  ::mallopt(M_TRIM_THRESHOLD, std::numeric_limits<int>::max());
  ::mallopt(M_MMAP_MAX, 0);
  // Libraries' threads would have their 8 MiB of stack locked, all of it.
  pthread_attr_t attributes;
  if (pthread_getattr_default_np(&attributes) == 0) {
    if (pthread_attr_setstacksize(&attributes, kForeignStackBytes) == 0)
      (void)pthread_setattr_default_np(&attributes);
    pthread_attr_destroy(&attributes);
  }
  static bool told = false;
  if (::mlockall(may_lock_anything() ? MCL_CURRENT | MCL_FUTURE : MCL_CURRENT) == 0 ||
      std::exchange(told, true))
    return {};
  return fmt::format(
      "memory is not locked ({}); raise RLIMIT_MEMLOCK (ulimit -l), or give the "
      "program CAP_IPC_LOCK",
      std::strerror(errno));
}

void set_thread_wishes(const RealtimeOptions& options) noexcept {
  wished_priority.store(options.fifo_priority, std::memory_order_relaxed);
}

void dress_this_thread(const char* name) noexcept {
  const int priority = wished_priority.load(std::memory_order_relaxed);
  if (prepare_worker({.name = name, .fifo_priority = priority}).fifo)
    any_fifo_refused.store(true, std::memory_order_relaxed);
}

std::vector<std::string> refusals(bool fifo_refused, bool affinity_refused) {
  std::vector<std::string> lines;
  if (fifo_refused || any_fifo_refused.load(std::memory_order_relaxed))
    lines.emplace_back(
        "SCHED_FIFO is refused, the ordinary scheduler stays; raise RLIMIT_RTPRIO (ulimit -r), or "
        "give the program CAP_SYS_NICE");
  if (affinity_refused)
    lines.emplace_back("the choice of cores is refused, threads run anywhere; see 'taskset -p'");
  return lines;
}

}  // namespace planecast
