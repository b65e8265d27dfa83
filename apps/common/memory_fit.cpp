#include "apps/common/memory_fit.hpp"

#include <fmt/format.h>
#include <sys/resource.h>
#include <unistd.h>

#include <fstream>

namespace planecast {
namespace {

constexpr std::uint64_t kUnknown = UINT64_MAX;

/// The number that stands first in a file, kUnknown when there is none ("max").
std::uint64_t number_in(const std::string& path) {
  std::uint64_t value = 0;
  return std::ifstream(path) >> value ? value : kUnknown;
}

/// Word `index` of /proc/self/statm: pages of all mappings, then of those resident.
std::uint64_t own_bytes(int index) {
  std::ifstream file("/proc/self/statm");
  std::uint64_t pages = 0;
  for (int i = 0; i <= index; ++i) {
    if (!(file >> pages)) return 0;
  }
  return pages * static_cast<std::uint64_t>(::sysconf(_SC_PAGESIZE));
}

std::uint64_t left(std::uint64_t limit, std::uint64_t used) {
  return limit == kUnknown ? kUnknown : limit - (used < limit ? used : limit);
}

std::uint64_t machine_room() {
  std::ifstream file("/proc/meminfo");
  std::string name, unit;
  std::uint64_t kilobytes = 0;
  while (file >> name >> kilobytes) {
    if (name == "MemAvailable:") return kilobytes * 1024;
    std::getline(file, unit);
  }
  return kUnknown;
}

// Version 2 of control groups alone: "0::/path" below /sys/fs/cgroup. Every group above counts too.
std::uint64_t group_room() {
  std::ifstream file("/proc/self/cgroup");
  std::uint64_t least = kUnknown;
  for (std::string line; std::getline(file, line);) {
    if (!line.starts_with("0::")) continue;
    for (std::string path = line.substr(3); !path.empty();
         path.resize(path.find_last_of('/') == std::string::npos ? 0 : path.find_last_of('/'))) {
      const std::string group = "/sys/fs/cgroup" + path;
      const std::uint64_t room =
          left(number_in(group + "/memory.max"), number_in(group + "/memory.current"));
      if (room < least) least = room;
    }
  }
  return least;
}

}  // namespace

MemoryRoom memory_room() {
  MemoryRoom room;
  rlimit limit{};
  if (::getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
    room.address_space = left(limit.rlim_cur, own_bytes(0));
  room.group = group_room();
  room.machine = machine_room();
  return room;
}

Result<Done> check_memory_fits(std::uint64_t bytes, std::uint64_t limit, const MemoryRoom& room,
                               const std::string& mend) {
  const auto refuse = [&](const std::string& against) {
    return Error{Status::kOutOfArena,
                 fmt::format("frames and stacks need {} bytes, {}; {}", bytes, against, mend)};
  };
  if (limit != 0 && bytes > limit) return refuse(fmt::format("--memory-limit allows {}", limit));
  if (bytes > room.address_space)
    return refuse(fmt::format("RLIMIT_AS (ulimit -v) leaves {}", room.address_space));
  if (bytes > room.group)
    return refuse(fmt::format("the control group's memory.max leaves {}", room.group));
  if (bytes > room.machine)
    return refuse(fmt::format("the machine has {} available", room.machine));
  return Done{};
}

std::uint64_t resident_bytes() {
  return own_bytes(1);
}

}  // namespace planecast
