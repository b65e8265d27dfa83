#include "core/pipeline/stage_runner.hpp"

#include <time.h>

#include <array>
#include <atomic>
#include <cassert>
#include <cstring>
#include <mutex>
#include <string>

#include "core/pipeline/worker_thread.hpp"
#include "core/ring/slot_pool.hpp"
#include "core/ring/spsc_ring.hpp"

namespace planecast {
namespace {

constexpr std::int64_t kMaxSpinNs = 1'000'000'000;
constexpr int kMaxFifoPriority = 99;

bool valid(const RunnerConfig& config, std::size_t stage_count) noexcept {
  return config.slots >= 1 && config.slots <= SlotPool::kMaxSlots && stage_count >= 1 &&
         stage_count <= StageRunner::kMaxStages && config.spin_ns >= -1 &&
         config.spin_ns <= kMaxSpinNs && config.fifo_priority >= 0 &&
         config.fifo_priority <= kMaxFifoPriority && config.first_core >= -1 &&
         config.deadline_ns >= 0;
}

// Only stop() waits this way, for a submit() that is under way; it is not a pipeline thread.
void nap() noexcept {
  const timespec pause{0, 50'000};
  nanosleep(&pause, nullptr);
}

}  // namespace

struct StageRunner::Core {
  struct Worker {
    Core* core = nullptr;
    std::uint32_t index = 0;
    WorkerThread thread;
  };

  Status lay_out(Arena& arena, const RunnerConfig& config, std::size_t stage_count) noexcept;
  void run_stage(std::uint32_t index, std::uint32_t handle, std::uint32_t waiting) noexcept;
  void finish(std::uint32_t handle) noexcept;
  void push(std::uint32_t index, std::uint32_t handle) noexcept;
  void work(std::uint32_t index) noexcept;
  void end_workers() noexcept;
  int start_team() noexcept;
  void open_rings() noexcept;
  SpscRing& done() noexcept { return rings[stage_count]; }

  RunnerConfig config;
  std::uint32_t stage_count = 0;
  std::array<StageRef, kMaxStages> stages{};
  std::array<Worker, kMaxStages> workers{};
  std::span<StageStats> stats;
  std::span<Status> statuses;  ///< of slot i; belongs to whoever holds handle i
  SlotPool pool;
  std::array<SpscRing, kMaxStages + 1> rings;  ///< ring i feeds stage i, the last one the consumer

  // Control thread's side.
  std::mutex control;
  FrameTeam* team = nullptr;
  const char* team_name = "";
  std::uint32_t threads_alive = 0;
  alignas(kCacheLineBytes) std::atomic<std::uint32_t> running{0};
  std::atomic<std::uint32_t> discard{0};
  std::atomic<std::uint32_t> threads_ready{0};
  std::atomic<std::uint32_t> fifo_refused{0};
  std::atomic<std::uint32_t> affinity_refused{0};

  // Source's side.
  alignas(kCacheLineBytes) std::atomic<std::uint32_t> submitting{0};

  // Written by whoever fills the done ring.
  alignas(kCacheLineBytes) std::atomic<std::uint64_t> ok{0};
  std::atomic<std::uint64_t> failed{0};
};

Status StageRunner::Core::lay_out(Arena& arena, const RunnerConfig& wanted,
                                  std::size_t count) noexcept {
  config = wanted;
  stage_count = static_cast<std::uint32_t>(count);
  stats = arena.take<StageStats>(count);
  statuses = arena.take<Status>(wanted.slots);
  if (const Status status = pool.init(arena, wanted.slots); status != Status::kOk) return status;
  const std::uint32_t spin_ns = wanted.spin_ns >= 0 ? static_cast<std::uint32_t>(wanted.spin_ns)
                                                    : suitable_spin_ns(stage_count + 1);
  for (std::uint32_t i = 0; i <= stage_count; ++i) {
    if (const Status status = rings[i].init(arena, wanted.slots); status != Status::kOk)
      return status;
    rings[i].set_spin_ns(spin_ns);
  }
  return Status::kOk;
}

void StageRunner::Core::run_stage(std::uint32_t index, std::uint32_t handle,
                                  std::uint32_t waiting) noexcept {
  StageStats& own = stats[index];
  Status& status = statuses[handle];
  if (status == Status::kOk && discard.load(std::memory_order_relaxed) != 0)
    status = Status::kStopped;
  if (status != Status::kOk) {
    own.skip();
    return;
  }
  const StageRef& stage = stages[index];
  const std::int64_t begin_ns = own.begin(waiting);
  status = stage.process(stage.stage, stage.slots, handle);
  own.end(begin_ns, config.deadline_ns);
  add_one(status == Status::kOk ? own.ok : own.failed);
}

void StageRunner::Core::finish(std::uint32_t handle) noexcept {
  // Counted before the push, so that no consumer can see more frames than the totals.
  add_one(statuses[handle] == Status::kOk ? ok : failed);
  push(stage_count, handle);
}

void StageRunner::Core::push(std::uint32_t index, std::uint32_t handle) noexcept {
  [[maybe_unused]] const bool pushed = rings[index].try_push(handle);
  assert(pushed);  // the ring holds every handle and each exists once
  // A stage that had nothing to do is silent from now on, not from its last frame.
  if (index < stage_count && rings[index].size() <= 1) stats[index].mark_fed();
}

void StageRunner::Core::work(std::uint32_t index) noexcept {
  const char* name = stages[index].name;
  const int core = config.first_core < 0 ? -1 : config.first_core + static_cast<int>(index);
  const ThreadRefusals refused = prepare_worker({name, config.fifo_priority, core});
  if (refused.fifo) fifo_refused.store(1, std::memory_order_relaxed);
  if (refused.affinity) affinity_refused.store(1, std::memory_order_relaxed);
  if (config.on_thread_start != nullptr) config.on_thread_start(name);
  threads_ready.fetch_add(1);
  threads_ready.notify_one();

  const bool last = index + 1 == stage_count;
  SpscRing& input = rings[index];
  std::uint32_t handle = 0;
  while (input.pop_wait(handle)) {
    run_stage(index, handle, input.size() + 1);
    if (last) {
      finish(handle);
    } else {
      push(index + 1, handle);
    }
  }
  // The end travels down the chain behind the last frame.
  rings[index + 1].close();
  if (config.on_thread_stop != nullptr) config.on_thread_stop(name);
}

int StageRunner::Core::start_team() noexcept {
  if (team == nullptr || config.mode != RunMode::kThreads) return 0;
  const int before_last = static_cast<int>(stage_count) - 2;
  const int core =
      config.first_core < 0 ? -1 : config.first_core + (before_last > 0 ? before_last : 0);
  return team->start({team_name, config.fifo_priority, core}, config.on_thread_start,
                     config.on_thread_stop);
}

void StageRunner::Core::end_workers() noexcept {
  // Each worker closes the ring behind it once its own is closed and empty, so closing the first
  // one ends all of them in order. The done ring is closed again for inline mode and half a start.
  rings[0].close();
  for (std::uint32_t i = 0; i < threads_alive; ++i) workers[i].thread.join();
  threads_alive = 0;
  if (team != nullptr) team->stop();
  done().close();
}

void StageRunner::Core::open_rings() noexcept {
  for (std::uint32_t i = 0; i <= stage_count; ++i) rings[i].reopen();
  pool.reopen();
}

std::size_t StageRunner::memory_bytes(const RunnerConfig& config,
                                      std::size_t stage_count) noexcept {
  if (!valid(config, stage_count)) return 0;
  Arena arena = Arena::measuring();
  Core scratch;
  (void)arena.take<Core>(1);
  return scratch.lay_out(arena, config, stage_count) == Status::kOk ? arena.bytes_needed() : 0;
}

std::size_t StageRunner::stack_bytes(const RunnerConfig& config, std::size_t stage_count) noexcept {
  const bool threads = config.mode == RunMode::kThreads && valid(config, stage_count);
  return threads ? stage_count * stack_mapping_bytes() : 0;
}

StageRunner::~StageRunner() {
  stop(StopMode::kDiscard);
}

Status StageRunner::init(Arena& arena, const RunnerConfig& config,
                         std::span<const StageRef> stages) noexcept {
  if (core_ != nullptr || !valid(config, stages.size())) return Status::kBadConfig;
  for (const StageRef& stage : stages) {
    if (stage.process == nullptr || stage.name == nullptr) return Status::kBadConfig;
  }
  const std::span<Core> taken = arena.take<Core>(1);
  if (arena.is_measuring()) {
    Core scratch;
    return scratch.lay_out(arena, config, stages.size());
  }
  if (taken.empty()) return Status::kOutOfArena;
  Core& core = taken.front();
  if (const Status status = core.lay_out(arena, config, stages.size()); status != Status::kOk)
    return status;
  for (std::uint32_t i = 0; i < core.stage_count; ++i) {
    core.stages[i] = stages[i];
    core.workers[i].core = &core;
    core.workers[i].index = i;
  }
  core_ = &core;
  return Status::kOk;
}

void StageRunner::share(FrameTeam& team, const char* name) noexcept {
  if (core_ == nullptr) return;
  core_->team = &team;
  core_->team_name = name;
}

Result<Done> StageRunner::start() {
  if (core_ == nullptr) return {Status::kBadConfig, "pipeline: start() before a successful init()"};
  Core& core = *core_;
  const std::scoped_lock lock(core.control);
  if (core.running.load() != 0) return Done{};
  core.discard.store(0);
  core.threads_ready.store(0);
  core.open_rings();
  const std::uint32_t wanted = core.config.mode == RunMode::kThreads ? core.stage_count : 0;
  const auto entry = [](void* argument) -> void* {
    auto* worker = static_cast<Core::Worker*>(argument);
    worker->core->work(worker->index);
    return nullptr;
  };
  int error = core.start_team();
  for (std::uint32_t i = 0; i < wanted; ++i) {
    if (error == 0) error = core.workers[i].thread.start(entry, &core.workers[i]);
    if (error != 0) {
      core.end_workers();
      core.pool.close();
      return {Status::kStopped,
              "pipeline: the system refuses a thread for stage " + std::to_string(i + 1) + " of " +
                  std::to_string(wanted) + " (" + std::strerror(error) +
                  "); raise the limits of processes and of memory, or run inline"};
    }
    ++core.threads_alive;
  }
  for (std::uint32_t ready = 0; (ready = core.threads_ready.load()) < wanted;)
    core.threads_ready.wait(ready);
  core.running.store(1);
  return Done{};
}

// A submit() that saw `running` may be anywhere before its push. It writes `submitting`, then reads
// `running`; stop() writes `running`, then reads `submitting`, all seq_cst: either submit() sees
// the stop and withdraws, or stop() sees the submit and waits. So no frame enters after the rings
// close.
void StageRunner::stop(StopMode mode) noexcept {
  if (core_ == nullptr) return;
  Core& core = *core_;
  const std::scoped_lock lock(core.control);
  if (core.running.load() == 0) return;
  if (mode == StopMode::kDiscard) core.discard.store(1);
  core.running.store(0);
  core.pool.close();
  while (core.submitting.load() != 0) nap();
  core.end_workers();
}

bool StageRunner::running() const noexcept {
  return core_ != nullptr && core_->running.load() != 0;
}

std::optional<std::uint32_t> StageRunner::claim() noexcept {
  if (core_ == nullptr) return std::nullopt;
  return core_->pool.claim();
}

std::optional<std::uint32_t> StageRunner::claim_wait() noexcept {
  if (core_ == nullptr) return std::nullopt;
  return core_->pool.claim_wait();
}

Status StageRunner::submit(std::uint32_t handle, Status status) noexcept {
  if (core_ == nullptr || handle >= core_->statuses.size()) return Status::kBadConfig;
  Core& core = *core_;
  core.submitting.store(1);
  if (core.running.load() == 0) {
    core.submitting.store(0);
    core.pool.unclaim(handle);
    return Status::kStopped;
  }
  core.statuses[handle] = status;
  if (core.config.mode == RunMode::kThreads) {
    core.push(0, handle);
  } else {
    for (std::uint32_t i = 0; i < core.stage_count; ++i) core.run_stage(i, handle, 1);
    core.finish(handle);
  }
  core.submitting.store(0, std::memory_order_release);
  return Status::kOk;
}

bool StageRunner::try_pop_done(std::uint32_t& handle) noexcept {
  return core_ != nullptr && core_->done().try_pop(handle);
}

bool StageRunner::pop_done(std::uint32_t& handle) noexcept {
  return core_ != nullptr && core_->done().pop_wait(handle);
}

Status StageRunner::status(std::uint32_t handle) const noexcept {
  if (core_ == nullptr || handle >= core_->statuses.size()) return Status::kBadConfig;
  return core_->statuses[handle];
}

bool StageRunner::release(std::uint32_t handle) noexcept {
  return core_ != nullptr && core_->pool.release(handle);
}

FrameTotals StageRunner::totals() const noexcept {
  if (core_ == nullptr) return {};
  // What leaves is read before what enters, so in_flight() never turns negative.
  const std::uint64_t ok = core_->ok.load();
  const std::uint64_t failed = core_->failed.load();
  const std::uint64_t dropped = core_->pool.dropped();
  return {core_->pool.offered(), ok, failed, dropped};
}

std::uint32_t StageRunner::stage_count() const noexcept {
  return core_ == nullptr ? 0 : core_->stage_count;
}

StageReport StageRunner::report(std::uint32_t i) const noexcept {
  if (core_ == nullptr || i >= core_->stage_count) return {};
  return core_->stats[i].report(core_->stages[i].name);
}

bool StageRunner::stalled(std::uint32_t i, std::int64_t limit_ns) const noexcept {
  if (core_ == nullptr || i >= core_->stage_count) return false;
  const bool waiting = core_->rings[i].size() > 0;
  return running() && core_->stats[i].silent_ns(waiting, steady_now_ns()) > limit_ns;
}

bool StageRunner::fifo_refused() const noexcept {
  return core_ != nullptr && core_->fifo_refused.load() != 0;
}

bool StageRunner::affinity_refused() const noexcept {
  return core_ != nullptr && core_->affinity_refused.load() != 0;
}

}  // namespace planecast
