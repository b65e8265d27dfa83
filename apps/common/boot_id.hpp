// Which boot of which machine this is: two processes that agree on it share their clocks, so that
// times between them can be subtracted.
#pragma once

#include <cstdint>

namespace planecast {

/// CRC-32C of the kernel's boot id, as the key packet carries it (StreamConfig::boot_id); 0, which
/// equals no other, where the kernel tells none. Any thread; reads a file, so ask once.
std::uint32_t host_boot_id();

}  // namespace planecast
