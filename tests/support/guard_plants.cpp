// Faults planted from outside into a program under the guard: PLANECAST_GUARD_PLANT="malloc:fit"
// lets the thread "fit" call malloc once, in the midst of its work: when it looks at the clock for
// the 20th time, as every stage does before and after a frame. So the guard is shown to catch, in
// the real program, what it is there for.
#include <dlfcn.h>
#include <fcntl.h>
#include <pthread.h>
#include <sys/mman.h>
#include <sys/syscall.h>
#include <time.h>
#include <unistd.h>

#include <array>
#include <cstdlib>
#include <cstring>
#include <string_view>

#include "tests/support/heap_guard.hpp"
#include "tests/support/heap_guard_hooks.hpp"

namespace {

constexpr int kLooksBefore = 20;
constexpr std::size_t kPage = 4096;
void* volatile sink = nullptr;

struct Plant {
  std::string_view kind, thread;
};

Plant plant_asked() {
  const char* text = std::getenv("PLANECAST_GUARD_PLANT");
  const char* colon = text == nullptr ? nullptr : std::strchr(text, ':');
  if (colon == nullptr) return {};
  return {{text, static_cast<std::size_t>(colon - text)}, colon + 1};
}

pthread_mutex_t held = PTHREAD_MUTEX_INITIALIZER;

// Holds the mutex until somebody waits for it.
void* hold(void* taken) {
  pthread_mutex_lock(&held);
  __atomic_store_n(static_cast<int*>(taken), 1, __ATOMIC_RELEASE);
  while (planecast::test::HeapGuard::totals().mutex_waits == 0) sched_yield();
  pthread_mutex_unlock(&held);
  return nullptr;
}

// What the mutex and the page need, made while nothing counts yet.
struct Preparation {
  void* page = nullptr;
  Preparation() {
    page = reinterpret_cast<void*>(::syscall(SYS_mmap, nullptr, kPage, PROT_READ | PROT_WRITE,
                                             MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    if (plant_asked().kind != "mutex") return;
    static int taken = 0;
    pthread_t thread{};
    pthread_create(&thread, nullptr, hold, &taken);
    pthread_detach(thread);
    while (__atomic_load_n(&taken, __ATOMIC_ACQUIRE) == 0) sched_yield();
  }
} preparation;

void misbehave(std::string_view kind) {
  if (kind == "malloc") sink = std::malloc(8);
  if (kind == "mmap") sink = mmap(nullptr, kPage, PROT_READ, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0);
  if (kind == "fault") {
    // The page is taken away behind the guard's back, whatever is locked; then it is touched.
    ::syscall(SYS_munlock, preparation.page, kPage);
    ::syscall(SYS_madvise, preparation.page, kPage, MADV_DONTNEED);
    *static_cast<volatile char*>(preparation.page) = 1;
  }
  if (kind == "mutex") {
    pthread_mutex_lock(&held);
    pthread_mutex_unlock(&held);
  }
  if (kind == "write") {
    const int file = ::open("/dev/null", O_WRONLY);
    if (write(file, "x", 1) != 1) std::abort();
    ::syscall(SYS_close, file);
  }
  if (kind == "sleep") {
    const timespec pause{0, 150'000'000};  // three times: before, in and after the work
    nanosleep(&pause, nullptr);
  }
}

}  // namespace

extern "C" int clock_gettime(clockid_t clock, timespec* now) noexcept {
  using Real = int (*)(clockid_t, timespec*);
  static const auto real = reinterpret_cast<Real>(dlsym(RTLD_NEXT, "clock_gettime"));
  static const Plant plant = plant_asked();
  if (!plant.kind.empty() && planecast::test::guard_armed()) {
    static thread_local int looks = 0;
    std::array<char, 16> name{};
    const int times = plant.kind == "sleep" ? 3 : 1;
    if (++looks >= kLooksBefore && looks < kLooksBefore + times) {
      pthread_getname_np(pthread_self(), name.data(), name.size());
      if (plant.thread == name.data()) misbehave(plant.kind);
    }
  }
  return real(clock, now);
}
