// What the long-running programs may ask of the machine: memory that stays, a real-time scheduler,
// cores of their own, a watchdog, a limit of memory. What is refused costs one warning, never the
// stream.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/status.hpp"

namespace CLI {
class App;
}

namespace planecast {

struct RealtimeOptions {
  bool lock_memory = false;
  int fifo_priority = 0;           ///< SCHED_FIFO, 1..99; 0: the ordinary scheduler
  int first_core = -1;             ///< of the cores allowed; -1: anywhere
  double watchdog_ms = 0;          ///< 0: none
  std::uint64_t memory_limit = 0;  ///< [bytes]; 0: none

  std::int64_t watchdog_ns() const { return static_cast<std::int64_t>(watchdog_ms * 1e6); }
};

/// Adds --mlock, --fifo, --first-core, --watchdog-ms and --memory-limit; `options` must outlive the
/// parse.
void add_realtime_options(CLI::App& app, RealtimeOptions& options);

/// "64MiB", "64M", "67108864": bytes, at least 1. kUsage.
Result<std::uint64_t> parse_bytes(std::string_view text);

/// Keeps everything mapped now in RAM, and everything mapped later where no limit can make that
/// fail; the heap keeps its pages. Before the threads start, and once more when they run. Returns
/// the warning the first time that the system says no, else "". Main thread.
std::string lock_all_memory();

/// Says what threads dressed later shall have. Main thread, before it starts them.
void set_thread_wishes(const RealtimeOptions& options) noexcept;

/// Gives the calling thread its name and the scheduler asked for; the hook of every thread that is
/// not one of the pipeline's.
void dress_this_thread(const char* name) noexcept;

/// Warnings about what threads were refused, one line each: of those dressed so far, and of the
/// pipeline's as it says itself. Main thread, when all have started.
std::vector<std::string> refusals(bool fifo_refused, bool affinity_refused);

}  // namespace planecast
