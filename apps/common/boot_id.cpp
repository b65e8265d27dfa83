#include "apps/common/boot_id.hpp"

#include <fstream>
#include <string>

#include "core/base/crc32c.hpp"

namespace planecast {

std::uint32_t boot_id_hash() {
  std::ifstream file("/proc/sys/kernel/random/boot_id");
  std::string id;
  if (!std::getline(file, id) || id.empty()) return 0;
  return crc32c({reinterpret_cast<const std::uint8_t*>(id.data()), id.size()});
}

}  // namespace planecast
