#include "transport/lcm_url.hpp"

#include <arpa/inet.h>
#include <netinet/in.h>
#include <sys/socket.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <charconv>
#include <cstdlib>
#include <cstring>
#include <fstream>
#include <vector>

namespace planecast {
namespace {

constexpr std::array<std::string_view, 2> kOptions = {"ttl", "recv_buf_size"};
constexpr std::uint32_t kMaxTtl = 32;
constexpr std::uint32_t kMinReceiveBuffer = 4096;
constexpr std::uint32_t kMaxReceiveBuffer = 1U << 30U;

Error bad_url(std::string_view text, std::string_view why) {
  std::string message = "LCM URL '";
  message.append(text).append("': ").append(why);
  message.append("; write for example ").append(kDefaultLcmUrl);
  return {Status::kUsage, std::move(message)};
}

std::size_t edit_distance(std::string_view a, std::string_view b) {
  std::vector<std::size_t> row(b.size() + 1);
  for (std::size_t j = 0; j <= b.size(); ++j) row[j] = j;
  for (std::size_t i = 1; i <= a.size(); ++i) {
    std::size_t diagonal = row[0];
    row[0] = i;
    for (std::size_t j = 1; j <= b.size(); ++j) {
      const std::size_t above = row[j];
      const std::size_t swap = diagonal + (a[i - 1] == b[j - 1] ? 0U : 1U);
      row[j] = std::min({above + 1, row[j - 1] + 1, swap});
      diagonal = above;
    }
  }
  return row[b.size()];
}

std::string_view nearest_option(std::string_view name) {
  return *std::min_element(kOptions.begin(), kOptions.end(), [name](auto a, auto b) {
    return edit_distance(name, a) < edit_distance(name, b);
  });
}

// Digits only: no sign, no blank, no 0x, so that liblcm's strtol reads the same number.
bool parse_number(std::string_view text, std::uint32_t& out) {
  if (text.empty() || (text.size() > 1 && text.front() == '0')) return false;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), out);
  return error == std::errc() && end == text.data() + text.size();
}

/// Reads "GROUP:PORT"; returns the mistake, or nothing.
std::string parse_target(std::string_view target, LcmUrl& url) {
  const std::size_t colon = target.find(':');
  if (colon == std::string_view::npos) return "the port is missing after the group address";
  url.group = std::string(target.substr(0, colon));
  in_addr address{};
  if (inet_pton(AF_INET, url.group.c_str(), &address) != 1)
    return "'" + url.group + "' is not an IPv4 address";
  if ((ntohl(address.s_addr) >> 28U) != 0xEU)
    return "'" + url.group + "' is not a multicast address (224.0.0.0 to 239.255.255.255)";
  const std::string_view port_text = target.substr(colon + 1);
  std::uint32_t port = 0;
  if (!parse_number(port_text, port) || port < 1 || port > 65535)
    return "the port '" + std::string(port_text) + "' is not a number from 1 to 65535";
  url.port = static_cast<std::uint16_t>(port);
  return {};
}

std::string parse_option(std::string_view option, LcmUrl& url) {
  const std::size_t equals = option.find('=');
  const std::string name(option.substr(0, equals));
  const std::string value(equals == std::string_view::npos ? "" : option.substr(equals + 1));
  std::uint32_t number = 0;
  if (name == "ttl") {
    if (!parse_number(value, number) || number > kMaxTtl)
      return "ttl '" + value + "' is not a number from 0 (this host only) to 32";
    url.ttl = static_cast<std::uint8_t>(number);
    return {};
  }
  if (name == "recv_buf_size") {
    if (!parse_number(value, number) || number < kMinReceiveBuffer || number > kMaxReceiveBuffer)
      return "recv_buf_size '" + value + "' is not a number of bytes from 4096 to 1073741824";
    url.receive_buffer_bytes = number;
    return {};
  }
  return "unknown option '" + name + "', the nearest is '" + std::string(nearest_option(name)) +
         "'";
}

std::string parse_options(std::string_view options, LcmUrl& url) {
  while (!options.empty()) {
    const std::size_t end = options.find_first_of("&,");
    const std::string mistake = parse_option(options.substr(0, end), url);
    if (!mistake.empty()) return mistake;
    if (end == std::string_view::npos) break;
    options.remove_prefix(end + 1);
  }
  return {};
}

sockaddr_in group_address(const LcmUrl& url) {
  sockaddr_in address{};
  address.sin_family = AF_INET;
  address.sin_port = htons(url.port);
  inet_pton(AF_INET, url.group.c_str(), &address.sin_addr);
  return address;
}

/// A UDP socket connected to the group (which sends nothing), or -1 with errno set.
int connected_socket(const LcmUrl& url) {
  const int fd = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  if (fd < 0) return -1;
  const sockaddr_in address = group_address(url);
  if (::connect(fd, reinterpret_cast<const sockaddr*>(&address), sizeof address) == 0) return fd;
  const int reason = errno;
  ::close(fd);
  errno = reason;
  return -1;
}

}  // namespace

Result<LcmUrl> parse_lcm_url(std::string_view text) {
  LcmUrl url;
  if (text.empty()) return url;
  const std::size_t mark = text.find("://");
  if (mark == std::string_view::npos) return bad_url(text, "'://' is missing after the kind");
  const std::string_view scheme = text.substr(0, mark);
  const std::string_view rest = text.substr(mark + 3);
  if (scheme == "memq") {
    if (!rest.empty()) return bad_url(text, "memq:// takes nothing after it");
    url.memory = true;
    return url;
  }
  if (scheme != "udpm") return bad_url(text, "only udpm:// and memq:// are supported");
  const std::size_t question = rest.find('?');
  const std::string_view target = rest.substr(0, question);
  std::string mistake = target.empty() ? std::string() : parse_target(target, url);
  if (mistake.empty() && question != std::string_view::npos)
    mistake = parse_options(rest.substr(question + 1), url);
  if (!mistake.empty()) return bad_url(text, mistake);
  return url;
}

Result<LcmUrl> default_lcm_url() {
  const char* env = std::getenv("LCM_DEFAULT_URL");
  return parse_lcm_url(env != nullptr && *env != '\0' ? std::string_view(env) : kDefaultLcmUrl);
}

std::string to_string(const LcmUrl& url, bool for_receiving) {
  if (url.memory) return "memq://";
  std::string text =
      "udpm://" + url.group + ":" + std::to_string(url.port) + "?ttl=" + std::to_string(url.ttl);
  std::uint32_t buffer = url.receive_buffer_bytes;
  if (buffer == 0 && for_receiving) {
    // Asking for more than the host grants only makes liblcm warn; doctor says how to raise it.
    const std::uint32_t granted = granted_receive_buffer_bytes();
    buffer = granted == 0 ? 0 : std::min(granted, kDefaultReceiveBufferBytes);
  }
  if (buffer != 0) text += "&recv_buf_size=" + std::to_string(buffer);
  return text;
}

std::string_view multicast_route_mend() {
  return "sudo ip link set lo up multicast on\nsudo ip route add 224.0.0.0/4 dev lo";
}

Result<Done> check_multicast_route(const LcmUrl& url) {
  if (url.memory) return Done{};
  const int fd = connected_socket(url);
  if (fd >= 0) {
    ::close(fd);
    return Done{};
  }
  std::string message = "no way to send to the multicast group " + url.group + " (" +
                        std::strerror(errno) + "); for this host alone run:\n";
  message.append(multicast_route_mend());
  return {Status::kNetwork, std::move(message)};
}

std::uint32_t granted_receive_buffer_bytes() {
  std::ifstream file("/proc/sys/net/core/rmem_max");
  std::uint32_t bytes = 0;
  return file >> bytes ? bytes : 0;
}

std::uint32_t path_mtu_bytes(const LcmUrl& url) {
  if (url.memory) return 0;
  const int fd = connected_socket(url);
  if (fd < 0) return 0;
  int mtu = 0;
  socklen_t length = sizeof mtu;
  const int status = ::getsockopt(fd, IPPROTO_IP, IP_MTU, &mtu, &length);
  ::close(fd);
  return status == 0 && mtu > 0 ? static_cast<std::uint32_t>(mtu) : 0;
}

}  // namespace planecast
