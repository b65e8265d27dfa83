// The replacements. Allocation goes on to glibc's own __libc_* entry points, which need no look-up
// and so work before main(); the rest is found by dlsym on first use. A symbol defined in the
// program takes precedence over libc's for every library in it, libstdc++ included, so operator
// new, std::mutex and std::condition_variable end here as well.
#include "tests/support/heap_guard_hooks.hpp"

#ifndef PLANECAST_GUARD_OFF

#include <dlfcn.h>
#include <poll.h>
#include <pthread.h>
#include <semaphore.h>
#include <sys/epoll.h>
#include <sys/mman.h>
#include <sys/select.h>
#include <sys/socket.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <time.h>
#include <unistd.h>

#include <cerrno>
#include <cstdarg>

using planecast::test::guard_armed;
using planecast::test::guard_report;
using planecast::test::Offence;

extern "C" {
void* __libc_malloc(std::size_t) noexcept;
void* __libc_calloc(std::size_t, std::size_t) noexcept;
void* __libc_realloc(void*, std::size_t) noexcept;
void* __libc_memalign(std::size_t, std::size_t) noexcept;
void __libc_free(void*) noexcept;
}

namespace {

// The next definition of a symbol: libc's. The condition variables exist in two versions and a
// plain look-up may give the old one, whose objects have another layout; so name the version first.
template <class F>
F next_symbol(const char* name, const char* version = nullptr) noexcept {
  void* found = version == nullptr ? nullptr : dlvsym(RTLD_NEXT, name, version);
  if (found == nullptr) found = dlsym(RTLD_NEXT, name);
  return reinterpret_cast<F>(found);
}

constexpr const char* kCondVersion = "GLIBC_2.3.2";

}  // namespace

// Forwards a call after counting it. The look-up is repeated by racing threads at worst: a plain
// atomic pointer, because a guarded static would itself take a lock.
#define PLANECAST_FORWARD(kind, version, name, ...)     \
  using Real = decltype(&::name);                       \
  static Real real = nullptr;                           \
  Real call = __atomic_load_n(&real, __ATOMIC_ACQUIRE); \
  if (call == nullptr) {                                \
    call = next_symbol<Real>(#name, version);           \
    __atomic_store_n(&real, call, __ATOMIC_RELEASE);    \
  }                                                     \
  guard_report(kind, #name);                            \
  return call(__VA_ARGS__)

#define PLANECAST_BLOCKING(name, ...) PLANECAST_FORWARD(Offence::kWait, nullptr, name, __VA_ARGS__)
#define PLANECAST_WRITING(name, ...) PLANECAST_FORWARD(Offence::kWrite, nullptr, name, __VA_ARGS__)
#define PLANECAST_LOCKING(version, name, ...) \
  PLANECAST_FORWARD(Offence::kMutex, version, name, __VA_ARGS__)

extern "C" {

void* malloc(std::size_t size) noexcept {
  guard_report(Offence::kAllocate, "malloc");
  return __libc_malloc(size);
}

void* calloc(std::size_t n, std::size_t size) noexcept {
  guard_report(Offence::kAllocate, "calloc");
  return __libc_calloc(n, size);
}

void* realloc(void* block, std::size_t size) noexcept {
  guard_report(Offence::kAllocate, "realloc");
  return __libc_realloc(block, size);
}

void free(void* block) noexcept {
  if (block != nullptr) guard_report(Offence::kFree, "free");
  __libc_free(block);
}

void* memalign(std::size_t align, std::size_t size) noexcept {
  guard_report(Offence::kAllocate, "memalign");
  return __libc_memalign(align, size);
}

void* aligned_alloc(std::size_t align, std::size_t size) noexcept {
  guard_report(Offence::kAllocate, "aligned_alloc");
  return __libc_memalign(align, size);
}

void* valloc(std::size_t size) noexcept {
  guard_report(Offence::kAllocate, "valloc");
  return __libc_memalign(static_cast<std::size_t>(getpagesize()), size);
}

int posix_memalign(void** out, std::size_t align, std::size_t size) noexcept {
  guard_report(Offence::kAllocate, "posix_memalign");
  if (align < sizeof(void*) || (align & (align - 1)) != 0) return EINVAL;
  void* block = __libc_memalign(align, size);
  if (block == nullptr) return ENOMEM;
  *out = block;
  return 0;
}

void* mmap(void* at, std::size_t size, int protection, int flags, int fd, off_t offset) noexcept {
  planecast::test::guard_mapped(size, __builtin_return_address(0));
  PLANECAST_FORWARD(Offence::kMap, nullptr, mmap, at, size, protection, flags, fd, offset);
}

int munmap(void* at, std::size_t size) noexcept {
  PLANECAST_FORWARD(Offence::kMap, nullptr, munmap, at, size);
}

int madvise(void* at, std::size_t size, int advice) noexcept {
  PLANECAST_FORWARD(Offence::kMap, nullptr, madvise, at, size, advice);
}

void* mremap(void* at, std::size_t size, std::size_t new_size, int flags, ...) noexcept {
  va_list rest;
  va_start(rest, flags);
  void* new_at = (flags & MREMAP_FIXED) != 0 ? va_arg(rest, void*) : nullptr;
  va_end(rest);
  PLANECAST_FORWARD(Offence::kMap, nullptr, mremap, at, size, new_size, flags, new_at);
}

int brk(void* end) noexcept {
  PLANECAST_FORWARD(Offence::kMap, nullptr, brk, end);
}

void* sbrk(intptr_t delta) noexcept {
  PLANECAST_FORWARD(Offence::kMap, nullptr, sbrk, delta);
}

// Taking a free mutex does not block; only one that another thread holds counts.
int pthread_mutex_lock(pthread_mutex_t* mutex) noexcept {
  if (guard_armed() && pthread_mutex_trylock(mutex) == 0) return 0;
  PLANECAST_LOCKING(nullptr, pthread_mutex_lock, mutex);
}

int pthread_cond_wait(pthread_cond_t* condition, pthread_mutex_t* mutex) {
  PLANECAST_LOCKING(kCondVersion, pthread_cond_wait, condition, mutex);
}

int pthread_cond_timedwait(pthread_cond_t* condition, pthread_mutex_t* mutex,
                           const timespec* until) {
  PLANECAST_LOCKING(kCondVersion, pthread_cond_timedwait, condition, mutex, until);
}

int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const timespec* until) {
  PLANECAST_LOCKING(nullptr, pthread_cond_clockwait, condition, mutex, clock, until);
}

int pthread_join(pthread_t thread, void** result) {
  PLANECAST_BLOCKING(pthread_join, thread, result);
}

int sem_wait(sem_t* semaphore) {
  PLANECAST_BLOCKING(sem_wait, semaphore);
}

// Transport's wait for the next frame; the pipeline's own goes to the futex directly.
int sem_clockwait(sem_t* semaphore, clockid_t clock, const timespec* until) {
  PLANECAST_FORWARD(Offence::kIdle, nullptr, sem_clockwait, semaphore, clock, until);
}

int sem_timedwait(sem_t* semaphore, const timespec* until) {
  PLANECAST_FORWARD(Offence::kIdle, nullptr, sem_timedwait, semaphore, until);
}

int nanosleep(const timespec* time, timespec* left) {
  PLANECAST_BLOCKING(nanosleep, time, left);
}

int clock_nanosleep(clockid_t clock, int flags, const timespec* time, timespec* left) {
  PLANECAST_BLOCKING(clock_nanosleep, clock, flags, time, left);
}

int usleep(useconds_t time) {
  PLANECAST_BLOCKING(usleep, time);
}

unsigned sleep(unsigned seconds) {
  PLANECAST_BLOCKING(sleep, seconds);
}

int poll(pollfd* fds, nfds_t n, int timeout) {
  PLANECAST_BLOCKING(poll, fds, n, timeout);
}

int epoll_wait(int fd, epoll_event* events, int n, int timeout) {
  PLANECAST_BLOCKING(epoll_wait, fd, events, n, timeout);
}

int select(int n, fd_set* in, fd_set* out, fd_set* error, timeval* timeout) {
  PLANECAST_BLOCKING(select, n, in, out, error, timeout);
}

ssize_t read(int fd, void* bytes, std::size_t n) {
  PLANECAST_BLOCKING(read, fd, bytes, n);
}

ssize_t write(int fd, const void* bytes, std::size_t n) {
  PLANECAST_WRITING(write, fd, bytes, n);
}

ssize_t writev(int fd, const iovec* parts, int n) {
  PLANECAST_WRITING(writev, fd, parts, n);
}

int fsync(int fd) {
  PLANECAST_WRITING(fsync, fd);
}

int fdatasync(int fd) {
  PLANECAST_WRITING(fdatasync, fd);
}

ssize_t send(int fd, const void* bytes, std::size_t n, int flags) {
  PLANECAST_WRITING(send, fd, bytes, n, flags);
}

ssize_t sendmsg(int fd, const msghdr* message, int flags) {
  PLANECAST_WRITING(sendmsg, fd, message, flags);
}

ssize_t sendto(int fd, const void* bytes, std::size_t n, int flags, const sockaddr* to,
               socklen_t to_bytes) {
  PLANECAST_WRITING(sendto, fd, bytes, n, flags, to, to_bytes);
}

ssize_t recv(int fd, void* bytes, std::size_t n, int flags) {
  PLANECAST_BLOCKING(recv, fd, bytes, n, flags);
}

ssize_t recvmsg(int fd, msghdr* message, int flags) {
  PLANECAST_BLOCKING(recvmsg, fd, message, flags);
}

}  // extern "C"

#endif  // PLANECAST_GUARD_OFF
