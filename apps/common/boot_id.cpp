#include "apps/common/boot_id.hpp"

#include <fstream>
#include <span>
#include <string>

#include "core/base/crc32c.hpp"

namespace planecast {

std::uint32_t host_boot_id() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string text;
  if (!(file >> text)) return 0;
  return crc32c({reinterpret_cast<const std::uint8_t*>(text.data()), text.size()});
}

}  // namespace planecast
