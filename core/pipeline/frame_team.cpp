#include "core/pipeline/frame_team.hpp"

namespace planecast {

int FrameTeam::start(const ThreadWishes& wishes, void (*on_start)(const char*),
                     void (*on_stop)(const char*)) noexcept {
  if (thread_.running) return 0;
  wishes_ = wishes;
  on_start_ = on_start;
  on_stop_ = on_stop;
  pieces_.reset();
  ready_.store(0);
  const int error = thread_.start(&FrameTeam::enter, this);
  if (error != 0) return error;
  while (ready_.load() == 0) ready_.wait(0);
  return 0;
}

void FrameTeam::stop() noexcept {
  if (!thread_.running) return;
  pieces_.end();
  thread_.join();
}

void* FrameTeam::enter(void* self) noexcept {
  auto* team = static_cast<FrameTeam*>(self);
  (void)prepare_worker(team->wishes_);
  if (team->on_start_ != nullptr) team->on_start_(team->wishes_.name);
  team->ready_.store(1);
  team->ready_.notify_one();
  team->pieces_.help();
  if (team->on_stop_ != nullptr) team->on_stop_(team->wishes_.name);
  return nullptr;
}

void FrameTeam::run(void* self, std::uint32_t pieces, WorkTeam::Piece piece, void* job) noexcept {
  auto& team = *static_cast<FrameTeam*>(self);
  if (team.thread_.running && pieces > 1) {
    team.pieces_.run(pieces, piece, job);
    return;
  }
  for (std::uint32_t i = 0; i < pieces; ++i) piece(job, i, 0);
}

}  // namespace planecast
