// The rings' memory as relacy models it: a load may see any older value that the memory orders
// permit, every access is a place to switch threads, plain memory tells of races. Includes relacy
// last: its macros take `new`, `delete` and `assert`.
#pragma once

#include "core/ring/shared_pieces.hpp"
#include "core/ring/slot_pool.hpp"
#include "core/ring/spsc_ring.hpp"

// After everything else.
#include <relacy/relacy.hpp>

namespace planecast::model {

constexpr rl::memory_order order_of(std::memory_order order) {
  switch (order) {
    case std::memory_order::relaxed:
      return rl::mo_relaxed;
    case std::memory_order::consume:
      return rl::mo_consume;
    case std::memory_order::acquire:
      return rl::mo_acquire;
    case std::memory_order::release:
      return rl::mo_release;
    case std::memory_order::acq_rel:
      return rl::mo_acq_rel;
    default:
      return rl::mo_seq_cst;
  }
}

template <class T>
class ModelAtomic {
 public:
  ModelAtomic() = default;
  ModelAtomic(T value) : word_(value) {}
  T load(std::memory_order order) const { return word_.load(order_of(order), RL_INFO); }
  void store(T value, std::memory_order order) { word_.store(value, order_of(order), RL_INFO); }
  T exchange(T value, std::memory_order order) {
    return word_.exchange(value, order_of(order), RL_INFO);
  }
  bool compare_exchange_weak(T& expected, T value, std::memory_order order,
                             std::memory_order failed) {
    return word_.compare_exchange_weak(expected, value, order_of(order), RL_INFO, order_of(failed),
                                       RL_INFO);
  }
  T fetch_sub(T value, std::memory_order order) {
    return word_.fetch_sub(value, order_of(order), RL_INFO);
  }

  // As the kernel's futex: the look at the word and falling asleep are one step.
  void wait(T value) {
    rl::context& c = rl::ctx();
    c.sched();
    c.atomic_thread_fence_seq_cst();
    T seen{};
    {
      rl::preemption_disabler whole(c);
      seen = word_.load(rl::mo_acquire, RL_INFO);
    }
    if (seen == value) word_.wait(c, false, true, RL_INFO);
  }
  void wake_one() {
    rl::context& c = rl::ctx();
    c.sched();
    c.atomic_thread_fence_seq_cst();
    word_.wake(c, 1, RL_INFO);
  }

 private:
  mutable rl::atomic<T> word_;
};

/// Memory without order of its own; an access that races with another ends the simulation.
template <class T>
class ModelPlain {
 public:
  ModelPlain() = default;
  ModelPlain(T value) : cell_(value) {}
  operator T() const { return cell_(RL_INFO).load(); }
  ModelPlain& operator=(T value) {
    cell_(RL_INFO).store(value);
    return *this;
  }

 private:
  rl::var<T> cell_;
};

/// The threads of the running simulation, so that one can be made to pass a fence by another.
struct Threads {
  static constexpr int kMost = 4;
  rl::thread_info_base* known[kMost] = {};
  int count = 0;
  void enter() { known[count++] = rl::ctx().threadx_; }
};
inline Threads* threads = nullptr;

/// Orders as in the product; a mutant is a type derived from this that weakens one of them.
template <bool kAsymmetric>
struct ModelMemory : MachineMemory {
  template <class T>
  using Atomic = ModelAtomic<T>;
  template <class T>
  using Plain = ModelPlain<T>;
  static bool asymmetric() { return kAsymmetric; }
  static void light_fence() {}  // the compiler moves nothing here

  // What membarrier() promises: between the caller's two fences each other thread passes one.
  static bool heavy_fence() {
    rl::context& c = rl::ctx();
    c.sched();
    const rl::preemption_disabler whole(c);
    c.atomic_thread_fence_seq_cst();
    rl::thread_info_base* const self = c.threadx_;
    for (int i = 0; i < threads->count; ++i) {
      c.threadx_ = threads->known[i];
      c.atomic_thread_fence_seq_cst();
    }
    c.threadx_ = self;
    c.atomic_thread_fence_seq_cst();
    return true;
  }

  static void wait(ModelAtomic<std::uint32_t>& word, std::uint32_t value) { word.wait(value); }
  static void wake_one(ModelAtomic<std::uint32_t>& word) { word.wake_one(); }
  static void yield() { rl::yield(1, RL_INFO); }
};

}  // namespace planecast::model
