// An LCM URL, checked before liblcm sees it. liblcm itself turns ttl=300 into 44, takes a missing
// port for port 0, and on a host without a multicast route prints a garbage address.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "core/base/status.hpp"

namespace planecast {

inline constexpr std::string_view kDefaultLcmUrl = "udpm://239.255.76.67:7667?ttl=0";

/// Receive buffer asked of the kernel when the URL names none: a few large frames in one burst.
inline constexpr std::uint32_t kDefaultReceiveBufferBytes = 2U << 20U;

/// A checked URL. `memory` is memq://, which never leaves the process and is for tests.
struct LcmUrl {
  bool memory = false;
  std::string group = "239.255.76.67";     ///< dotted IPv4 multicast address
  std::uint16_t port = 7667;               ///< 1 .. 65535
  std::uint8_t ttl = 0;                    ///< 0: this host only; at most 32
  std::uint32_t receive_buffer_bytes = 0;  ///< 0: not named in the URL
};

/// Reads udpm://[GROUP:PORT][?ttl=N&recv_buf_size=N] or memq://; "" and udpm:// are the default
/// group. kUsage, with a sentence that names the mistake and the mend.
Result<LcmUrl> parse_lcm_url(std::string_view text);

/// Reads LCM_DEFAULT_URL from the environment, else kDefaultLcmUrl. Errors as parse_lcm_url.
Result<LcmUrl> default_lcm_url();

/// The URL in the form liblcm reads, ttl always written out. With `for_receiving`, a receive buffer
/// is asked for as well: the one the URL names, else 2 MiB or as much as this host grants.
std::string to_string(const LcmUrl& url, bool for_receiving = false);

/// Checks that this host can send to the group. kNetwork names the two commands that mend it.
/// memq:// always passes.
Result<Done> check_multicast_route(const LcmUrl& url);

/// The commands that give a host a loopback multicast route, one a line.
std::string_view multicast_route_mend();

/// Largest receive buffer this host grants an ordinary user [bytes]; 0 where that cannot be read.
std::uint32_t granted_receive_buffer_bytes();

/// Largest IPv4 packet that reaches the group unfragmented [bytes]; 0 when unknown.
std::uint32_t path_mtu_bytes(const LcmUrl& url);

}  // namespace planecast
