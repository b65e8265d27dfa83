#include "core/pipeline/frame_team.hpp"

namespace planecast {

int FrameTeam::start(const ThreadWishes& wishes, void (*on_start)(const char*),
                     void (*on_stop)(const char*)) noexcept {
  if (thread_.running) return 0;
  wishes_ = wishes;
  on_start_ = on_start;
  on_stop_ = on_stop;
  stopping_.store(0);
  ready_.store(0);
  const int error = thread_.start(&FrameTeam::enter, this);
  if (error != 0) return error;
  while (ready_.load() == 0) ready_.wait(0);
  return 0;
}

void FrameTeam::stop() noexcept {
  if (!thread_.running) return;
  stopping_.store(1);
  // Another round, without pieces: the word differs from the one that the helper sleeps on.
  tickets_.store((tickets_.load() | kPieceMask) + 1);
  tickets_.notify_one();
  thread_.join();
}

void* FrameTeam::enter(void* self) noexcept {
  auto* team = static_cast<FrameTeam*>(self);
  (void)prepare_worker(team->wishes_);
  if (team->on_start_ != nullptr) team->on_start_(team->wishes_.name);
  team->ready_.store(1);
  team->ready_.notify_one();
  team->help();
  if (team->on_stop_ != nullptr) team->on_stop_(team->wishes_.name);
  return nullptr;
}

void FrameTeam::help() noexcept {
  while (stopping_.load() == 0) {
    const std::uint32_t empty = take_pieces(1);
    if (stopping_.load() != 0) return;
    tickets_.wait(empty);
  }
}

// The job is read before the exchange and counts only if that succeeds: then no piece of the round
// can have been finished in between without this one, so the fields are still those of the round.
// (A round's number comes again after 2^24 frames, five days at 40 Hz, of which the helper would
// have to sleep all between its two steps.)
std::uint32_t FrameTeam::take_pieces(std::uint32_t worker) noexcept {
  std::uint32_t tickets = tickets_.load(std::memory_order_acquire);
  while ((tickets & kPieceMask) != 0) {
    const WorkTeam::Piece piece = piece_.load(std::memory_order_relaxed);
    void* job = job_.load(std::memory_order_relaxed);
    if (!tickets_.compare_exchange_weak(tickets, tickets - 1, std::memory_order_acq_rel,
                                        std::memory_order_acquire))
      continue;
    piece(job, (tickets & kPieceMask) - 1, worker);
    // Release: who sees the last piece finished sees what all of them wrote.
    if (unfinished_.fetch_sub(1, std::memory_order_acq_rel) == 1) unfinished_.notify_one();
    tickets = tickets_.load(std::memory_order_acquire);
  }
  return tickets;
}

void FrameTeam::run(void* self, std::uint32_t pieces, WorkTeam::Piece piece, void* job) noexcept {
  auto& team = *static_cast<FrameTeam*>(self);
  if (!team.thread_.running || pieces < 2) {
    for (std::uint32_t i = 0; i < pieces; ++i) piece(job, i, 0);
    return;
  }
  team.piece_.store(piece, std::memory_order_relaxed);
  team.job_.store(job, std::memory_order_relaxed);
  team.unfinished_.store(pieces, std::memory_order_relaxed);
  const std::uint32_t round = (team.tickets_.load(std::memory_order_relaxed) | kPieceMask) + 1;
  team.tickets_.store(round | pieces, std::memory_order_release);
  team.tickets_.notify_one();
  (void)team.take_pieces(0);
  for (std::uint32_t left = 0; (left = team.unfinished_.load(std::memory_order_acquire)) != 0;)
    team.unfinished_.wait(left);
}

}  // namespace planecast
