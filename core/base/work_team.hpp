// Independent pieces of one job, done by the caller alone or shared out: all that an algorithm sees
// of threads. Which worker does which piece is chance, so a piece may read and write nothing that
// another one writes, but for the scratch of its worker.
#pragma once

#include <cstdint>

namespace planecast {

/// Workers of a team at most, the caller counted: as many scratch sets an algorithm needs.
inline constexpr std::uint32_t kMaxTeamWorkers = 2;

/// Who does the pieces. The default is the caller alone, pieces in order.
struct WorkTeam {
  using Piece = void (*)(void* job, std::uint32_t piece, std::uint32_t worker) noexcept;
  using RunFn = void (*)(void* team, std::uint32_t pieces, Piece piece, void* job) noexcept;

  void* team = nullptr;
  RunFn run_fn = nullptr;

  bool shared() const noexcept { return run_fn != nullptr; }

  /// Runs piece(job, i, worker) once for each i below `pieces` (at most 255) and returns when all
  /// are done; worker is 0 on the caller's thread. What the pieces wrote is seen afterwards.
  void run(std::uint32_t pieces, Piece piece, void* job) const noexcept {
    if (run_fn != nullptr) {
      run_fn(team, pieces, piece, job);
      return;
    }
    for (std::uint32_t i = 0; i < pieces; ++i) piece(job, i, 0);
  }
};

}  // namespace planecast
