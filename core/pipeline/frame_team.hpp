// A second thread that helps one pipeline thread with the pieces of a frame. Nobody waits for it to
// wake: whoever is free takes the next piece, so a helper that comes late, or has no core, costs
// nothing but its share. No allocation, no lock; it sleeps on a futex between frames.
#pragma once

#include <atomic>
#include <cstdint>

#include "core/base/work_team.hpp"
#include "core/pipeline/worker_thread.hpp"
#include "core/ring/shared_pieces.hpp"

namespace planecast {

/// Caller and helper. start() and stop() by one control thread, neither while run() is under way;
/// run() by one thread at a time.
class FrameTeam {
 public:
  FrameTeam() noexcept = default;
  ~FrameTeam() { stop(); }
  FrameTeam(const FrameTeam&) = delete;
  FrameTeam& operator=(const FrameTeam&) = delete;

  /// Starts the helper. Returns 0, or the errno of mmap or pthread_create: the caller then works
  /// alone. `wishes.name` must outlive the helper; `on_start` and `on_stop` as in RunnerConfig.
  int start(const ThreadWishes& wishes, void (*on_start)(const char* name) = nullptr,
            void (*on_stop)(const char* name) = nullptr) noexcept;

  /// Ends the helper; run() goes on alone.
  void stop() noexcept;

  /// What to give to an algorithm; valid as long as this object.
  WorkTeam work() noexcept { return {this, &FrameTeam::run}; }

 private:
  static void run(void* self, std::uint32_t pieces, WorkTeam::Piece piece, void* job) noexcept;
  static void* enter(void* self) noexcept;

  WorkerThread thread_;
  ThreadWishes wishes_;
  void (*on_start_)(const char*) = nullptr;
  void (*on_stop_)(const char*) = nullptr;
  std::atomic<std::uint32_t> ready_{0};
  SharedPieces pieces_;
};

}  // namespace planecast
