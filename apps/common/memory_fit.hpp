// Whether the memory that a program is about to take is there: asked before anything is taken, so
// that a configuration which does not fit ends with its figure and not in the middle of a stream.
#pragma once

#include <cstdint>
#include <string>

#include "core/base/status.hpp"

namespace planecast {

/// What this process may and can take [bytes], as the system says at this moment; the largest value
/// where it says nothing.
struct MemoryRoom {
  std::uint64_t address_space = UINT64_MAX;  ///< left below RLIMIT_AS
  std::uint64_t group = UINT64_MAX;          ///< left below the control group's memory.max
  std::uint64_t machine = UINT64_MAX;        ///< available without swapping
};

MemoryRoom memory_room();

/// kOutOfArena when `bytes` exceed `limit` (0: none) or the room there is; the message names the
/// figure, what stands against it, and `mend`.
Result<Done> check_memory_fits(std::uint64_t bytes, std::uint64_t limit, const MemoryRoom& room,
                               const std::string& mend);

/// Resident bytes of this process now; 0 where the system does not say.
std::uint64_t resident_bytes();

}  // namespace planecast
