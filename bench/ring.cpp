// core/ring/spsc_ring.hpp beside boost::lockfree::spsc_queue and moodycamel::ReaderWriterQueue, in
// the form of rigtorp/SPSCQueue's table: throughput of 32-bit items through one queue, and round
// trips through two.
//   ring [ROUNDS]      medians over ROUNDS (21), the queues taking turns in every round
// Two threads pinned on the first two cores allowed; all queues hold 65,536 items at least.
#include <fmt/core.h>
#include <readerwriterqueue.h>
#include <sched.h>

#include <algorithm>
#include <atomic>
#include <boost/lockfree/spsc_queue.hpp>
#include <chrono>
#include <cstdlib>
#include <memory>
#include <thread>
#include <vector>

#include "core/base/arena.hpp"
#include "core/ring/spsc_ring.hpp"

namespace {

using Clock = std::chrono::steady_clock;
using Item = std::uint32_t;
constexpr std::uint32_t kCapacity = 65'536;
constexpr Item kItems = 2'000'000, kTrips = 50'000;

struct Ours {
  planecast::Arena arena =
      std::move(planecast::Arena::map(kCapacity * sizeof(Item) + 4096).value());
  planecast::SpscRing ring;
  Ours() {
    if (ring.init(arena, kCapacity) != planecast::Status::kOk) std::abort();
  }
  bool push(Item item) { return ring.try_push(item); }
  bool pop(Item& item) { return ring.try_pop(item); }
};

struct Boost {
  boost::lockfree::spsc_queue<Item> queue{kCapacity};
  bool push(Item item) { return queue.push(item); }
  bool pop(Item& item) { return queue.pop(item); }
};

struct ReaderWriter {
  moodycamel::ReaderWriterQueue<Item> queue{kCapacity};
  bool push(Item item) { return queue.try_enqueue(item); }
  bool pop(Item& item) { return queue.try_dequeue(item); }
};

const cpu_set_t kAllowed = [] {
  cpu_set_t allowed;
  CPU_ZERO(&allowed);
  sched_getaffinity(0, sizeof(allowed), &allowed);
  return allowed;
}();

// The n-th core that the process may use, modulo their number; read before any thread is pinned.
void pin(int n) {
  int skip = n % std::max(1, CPU_COUNT(&kAllowed));
  for (int core = 0; core < CPU_SETSIZE; ++core) {
    if (!CPU_ISSET(core, &kAllowed) || skip-- > 0) continue;
    cpu_set_t one;
    CPU_ZERO(&one);
    CPU_SET(core, &one);
    sched_setaffinity(0, sizeof(one), &one);
    return;
  }
}

/// Runs `work` on the second core; returns when it is there.
template <class F>
std::thread on_second_core(F work) {
  std::atomic<bool> there{false};
  std::thread thread([&there, work] {
    pin(1);
    there = true;
    there.notify_one();
    work();
  });
  there.wait(false);
  return thread;
}

double ns_since(Clock::time_point begin) {
  return std::chrono::duration<double, std::nano>(Clock::now() - begin).count();
}

/// Items a millisecond. A wrong item ends the program: a fast queue that errs is none.
template <class Queue>
double throughput() {
  const auto queue = std::make_unique<Queue>();
  std::thread consumer = on_second_core([&queue] {
    Item item = 0;
    for (Item expected = 0; expected < kItems;) {
      if (!queue->pop(item)) continue;
      if (item != expected++) std::abort();
    }
  });
  const auto begin = Clock::now();
  for (Item i = 0; i < kItems;) i += queue->push(i) ? 1 : 0;
  consumer.join();
  return kItems / (ns_since(begin) * 1e-6);
}

/// Nanoseconds for there and back.
template <class Queue>
double round_trip() {
  const auto there = std::make_unique<Queue>();
  const auto back = std::make_unique<Queue>();
  std::thread echo = on_second_core([&there, &back] {
    Item item = 0;
    for (Item i = 0; i < kTrips; ++i) {
      while (!there->pop(item)) continue;
      while (!back->push(item)) continue;
    }
  });
  const auto begin = Clock::now();
  Item item = 0;
  for (Item i = 0; i < kTrips; ++i) {
    while (!there->push(i)) continue;
    while (!back->pop(item)) continue;
    if (item != i) std::abort();
  }
  echo.join();
  return ns_since(begin) / kTrips;
}

struct Row {
  const char* name;
  std::vector<double> ops_ms, trip_ns;
};

double quantile(std::vector<double> values, double q) {
  std::sort(values.begin(), values.end());
  return values[static_cast<std::size_t>(q * static_cast<double>(values.size() - 1) + 0.5)];
}

template <class Queue>
void round(Row& row) {
  row.ops_ms.push_back(throughput<Queue>());
  row.trip_ns.push_back(round_trip<Queue>());
}

}  // namespace

int main(int argc, char** argv) {
  const int rounds = argc > 1 ? std::max(1, std::atoi(argv[1])) : 21;
  pin(0);
  Row rows[] = {{"planecast::SpscRing", {}, {}},
                {"boost::lockfree::spsc_queue", {}, {}},
                {"moodycamel::ReaderWriterQueue", {}, {}}};
  for (int i = 0; i < rounds; ++i) {
    round<Ours>(rows[0]);
    round<Boost>(rows[1]);
    round<ReaderWriter>(rows[2]);
  }
  fmt::print("{} barrier in push; medians (quartiles) of {} rounds\n",
             planecast::asymmetric_fence_available() ? "no" : "a", rounds);
  fmt::print("| {:<30} | {:>26} | {:>22} |\n", "Queue", "Throughput (ops/ms)", "Latency RTT (ns)");
  for (const Row& row : rows) {
    fmt::print("| {:<30} | {:8.0f} ({:6.0f} to {:6.0f}) | {:6.0f} ({:4.0f} to {:4.0f}) |\n",
               row.name, quantile(row.ops_ms, 0.5), quantile(row.ops_ms, 0.25),
               quantile(row.ops_ms, 0.75), quantile(row.trip_ns, 0.5), quantile(row.trip_ns, 0.25),
               quantile(row.trip_ns, 0.75));
  }
  return 0;
}
