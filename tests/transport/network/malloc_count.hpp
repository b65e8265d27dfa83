// Counts every allocation of the whole process, liblcm's and glib's threads included.
#pragma once

#include <cstdint>

namespace planecast::test {

/// False where a sanitizer owns malloc.
bool malloc_is_counted() noexcept;

/// Calls of malloc, calloc, realloc and their kin so far, in any thread.
std::uint64_t malloc_count() noexcept;

}  // namespace planecast::test
