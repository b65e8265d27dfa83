#include "transport/doctor.hpp"

#include <sys/resource.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdio>
#include <random>

#include "core/base/bytes.hpp"
#include "transport/envelope.hpp"
#include "transport/lcm_link.hpp"
#include "transport/lcm_url.hpp"
#include "transport/wake.hpp"

namespace planecast {
namespace {

constexpr std::int64_t kRoundTripLimitNs = 2'000'000'000;
constexpr std::uint32_t kDatagramOverheadBytes = 20 + 8 + 8;  // IPv4, UDP, LCM's short header
constexpr std::uint64_t kWantedLockBytes = 256ULL << 20U;

DoctorLine ok(std::string subject, std::string text) {
  return {DoctorLevel::kOk, std::move(subject), std::move(text), {}};
}

DoctorLine warn(std::string subject, std::string text, std::string mend) {
  return {DoctorLevel::kWarn, std::move(subject), std::move(text), std::move(mend)};
}

DoctorLine fail(std::string subject, std::string text, std::string mend) {
  return {DoctorLevel::kFail, std::move(subject), std::move(text), std::move(mend)};
}

/// The message that is awaited; others on the channel are not ours.
struct Arrival {
  std::uint32_t nonce = 0;
  std::int64_t ns = 0;
  bool right = false;
};

void note_arrival(void* user, std::span<const std::uint8_t> message) noexcept {
  auto* arrival = static_cast<Arrival*>(user);
  std::span<const std::uint8_t> packet;
  if (decode_envelope(message, packet) != Status::kOk || packet.size() != 4) return;
  if (load_be<std::uint32_t>(packet.data()) != arrival->nonce) return;
  arrival->ns = monotonic_ns();
  arrival->right = true;
}

DoctorLine check_round_trip(const LcmUrl& url) {
  const std::string subject = "round trip";
  LcmUrl quiet = url;
  quiet.ttl = 0;
  const std::string mend = "sudo iptables -I INPUT -p udp --dport " + std::to_string(url.port) +
                           " -j ACCEPT   (or the same in this host's firewall)";
  Result<std::shared_ptr<LcmLink>> link = LcmLink::open(quiet, true);
  if (!link) return fail(subject, link.error().message, mend);
  Arrival arrival;
  const Result<Done> subscribed =
      link.value()->subscribe(kWarmUpChannel, note_arrival, &arrival, 100);
  if (!subscribed) return fail(subject, subscribed.error().message, mend);
  // The first message makes the channel known; the second is timed.
  std::int64_t sent_ns = 0;
  for (int i = 0; i < 2; ++i) {
    arrival = {std::random_device()(), 0, false};
    std::array<std::uint8_t, 4> packet{};
    store_be(packet.data(), arrival.nonce);
    std::array<std::uint8_t, kEnvelopeOverheadBytes + 4> message{};
    std::size_t size = 0;
    (void)encode_envelope(packet, message, size);
    sent_ns = monotonic_ns();
    if (link.value()->publish(kWarmUpChannel, message) != Status::kOk)
      return fail(subject, "the kernel refuses to send to the group", mend);
    while (!arrival.right && monotonic_ns() - sent_ns < kRoundTripLimitNs)
      (void)link.value()->handle(50);
    if (!arrival.right)
      return fail(subject, "a message sent to the group did not come back within 2 s", mend);
  }
  return ok(subject,
            "a message came back in " + std::to_string((arrival.ns - sent_ns) / 1000) + " us");
}

DoctorLine check_receive_buffer(const LcmUrl& url) {
  const std::uint32_t wanted = std::max(url.receive_buffer_bytes, kDefaultReceiveBufferBytes);
  const std::uint32_t granted = granted_receive_buffer_bytes();
  const std::string text = "the kernel grants " + std::to_string(granted) + " bytes, " +
                           std::to_string(wanted) + " are wanted";
  if (granted >= wanted) return ok("receive buffer", text);
  return warn("receive buffer", text + "; bursts of large frames may be lost",
              "sudo sysctl -w net.core.rmem_max=" + std::to_string(wanted));
}

DoctorLine check_datagram(const LcmUrl& url) {
  const std::uint32_t mtu = path_mtu_bytes(url);
  const auto needed = static_cast<std::uint32_t>(kDefaultMessageBytes + kDatagramOverheadBytes +
                                                 sizeof("PLANECAST"));
  if (mtu == 0) return warn("datagram size", "the path's MTU cannot be read", "ip link show");
  const std::string text = "slices of " + std::to_string(kDefaultMessageBytes) + " bytes need " +
                           std::to_string(needed) + ", the path carries " + std::to_string(mtu);
  if (mtu >= needed) return ok("datagram size", text);
  return warn("datagram size", text + "; slices would be cut up and lost more often",
              "--slice-bytes " + std::to_string(mtu > 400 ? mtu - 100 : 300));
}

DoctorLine check_memory_lock() {
  rlimit limit{};
  if (::getrlimit(RLIMIT_MEMLOCK, &limit) != 0 || limit.rlim_cur == RLIM_INFINITY ||
      limit.rlim_cur >= kWantedLockBytes)
    return ok("locked memory", "enough may be locked to keep frames out of swap");
  return warn("locked memory",
              "at most " + std::to_string(limit.rlim_cur >> 10U) +
                  " KiB may be locked; under memory pressure frames may wait for the disk",
              "echo \"$USER - memlock unlimited\" | sudo tee /etc/security/limits.d/planecast.conf"
              "   (then log in again)");
}

DoctorLine check_priority() {
  rlimit limit{};
  const bool allowed = ::getrlimit(RLIMIT_RTPRIO, &limit) == 0 && limit.rlim_cur > 0;
  if (allowed || ::geteuid() == 0) return ok("real-time priority", "may be asked for");
  return warn("real-time priority", "not permitted; on a busy host latency has outliers",
              "echo \"$USER - rtprio 80\" | sudo tee -a /etc/security/limits.d/planecast.conf"
              "   (then log in again)");
}

}  // namespace

std::vector<DoctorLine> run_doctor(std::string_view url_text) {
  std::vector<DoctorLine> lines;
  const Result<LcmUrl> url = url_text.empty() ? default_lcm_url() : parse_lcm_url(url_text);
  if (!url) {
    lines.push_back(
        fail("LCM URL", url.error().message,
             "--lcm-url '" + std::string(kDefaultLcmUrl) + "', or set LCM_DEFAULT_URL"));
    return lines;
  }
  lines.push_back(ok("LCM URL", to_string(*url)));
  if (url->memory) {
    lines.push_back(warn("LCM URL", "memq:// never leaves the process; nothing to examine",
                         "--lcm-url '" + std::string(kDefaultLcmUrl) + "'"));
    return lines;
  }
  const Result<Done> route = check_multicast_route(*url);
  if (route) {
    lines.push_back(ok("multicast route", "the group " + url->group + " can be reached"));
    lines.push_back(check_round_trip(*url));
    lines.push_back(check_datagram(*url));
  } else {
    lines.push_back(fail("multicast route", "no way to send to the group " + url->group,
                         std::string(multicast_route_mend())));
  }
  if (url->ttl > 1)
    lines.push_back(warn("ttl", "ttl " + std::to_string(url->ttl) + " crosses routers",
                         "ttl=1 stays on the local network, ttl=0 on this host"));
  lines.push_back(check_receive_buffer(*url));
  lines.push_back(check_memory_lock());
  lines.push_back(check_priority());
  return lines;
}

Status doctor_verdict(const std::vector<DoctorLine>& lines) noexcept {
  const bool failed = std::any_of(lines.begin(), lines.end(), [](const DoctorLine& line) {
    return line.level == DoctorLevel::kFail;
  });
  return failed ? Status::kNetwork : Status::kOk;
}

}  // namespace planecast
