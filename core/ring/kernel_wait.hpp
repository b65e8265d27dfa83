// Sleeping on a word of memory, and waking who sleeps there: the kernel's futex where there is one.
#pragma once

#include <atomic>
#include <cstdint>

namespace planecast {

/// Sleeps while `word` is `value`; may return early. Wake and sleep are ordered by the kernel: a
/// thread that changes the word and then wakes is not missed.
void kernel_wait(const std::atomic<std::uint32_t>& word, std::uint32_t value) noexcept;

/// Wakes one thread that sleeps on `word`, if any does. One system call; never blocks.
void kernel_wake_one(std::atomic<std::uint32_t>& word) noexcept;

}  // namespace planecast
