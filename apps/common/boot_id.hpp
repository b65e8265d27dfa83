// Which boot of which machine this is: monotonic clocks of two processes agree only where it is the
// same, so latency is measured between those alone.
#pragma once

#include <cstdint>

namespace planecast {

/// CRC-32C of the kernel's boot id (36 characters, no newline), as StreamConfig::boot_id carries
/// it; 0 where there is none to read, which equals no other.
std::uint32_t boot_id_hash();

}  // namespace planecast
