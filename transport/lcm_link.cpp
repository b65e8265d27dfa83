#include "transport/lcm_link.hpp"

#include <lcm/lcm.h>
#include <sys/select.h>

#include <algorithm>
#include <array>
#include <cctype>
#include <deque>
#include <thread>
#include <vector>

#include "transport/envelope.hpp"
#include "transport/wake.hpp"

namespace planecast {
namespace {

constexpr std::uint32_t kMaxLcmMessageBytes = 1U << 28U;  // liblcm's own limit
constexpr auto kWarmUpPause = std::chrono::microseconds(500);
constexpr std::int64_t kWarmUpLimitNs = 2'000'000'000;

/// A burst of messages that makes liblcm's ring of received bytes grow to its final size.
struct WarmUpBurst {
  int messages;
  std::size_t bytes;  ///< each
};

// liblcm asks its ring for 64 KiB in one piece for every datagram, wherever the ring's start
// happens to be; so beside the queue itself twice that must be free, or the ring grows in
// mid-stream. A burst 64 KiB shorter than that, with the 64 KiB asked for after it, forces the
// growth now.
WarmUpBurst warm_up_burst(int queue, std::size_t message_bytes) {
  constexpr std::size_t kBookkeeping = 128;  // of liblcm, with the channel name, a message
  constexpr std::size_t kReserve = 72 * 1024;
  constexpr std::size_t kLargest = 60'000;
  const std::size_t wanted =
      static_cast<std::size_t>(queue) * (message_bytes + kBookkeeping) + kReserve;
  const std::size_t fewest = (wanted + kLargest - 1) / kLargest;
  const std::size_t messages =
      std::min(std::max<std::size_t>(fewest, 16), static_cast<std::size_t>(queue));
  return {static_cast<int>(messages), std::min(kLargest, (wanted + messages - 1) / messages)};
}

struct Binding {
  LcmLink::Handler handler;
  void* user;
};

void on_message(const lcm_recv_buf_t* buffer, const char* /*channel*/, void* user) {
  const auto* binding = static_cast<const Binding*>(user);
  // A datagram without a NUL after its channel arrives with a size of -13 and the like.
  const bool sane = buffer->data != nullptr && buffer->data_size <= kMaxLcmMessageBytes;
  const auto* data = static_cast<const std::uint8_t*>(buffer->data);
  binding->handler(binding->user, {data, sane ? buffer->data_size : 0U});
}

// liblcm reads a channel as a regular expression; we mean the name itself.
std::string escaped(std::string_view channel) {
  std::string text;
  for (const char c : channel) {
    if (std::string_view(".[]{}()*+?^$|\\").find(c) != std::string_view::npos) text += '\\';
    text += c;
  }
  return text;
}

std::array<std::uint8_t, kEnvelopeOverheadBytes> greeting() noexcept {
  std::array<std::uint8_t, kEnvelopeOverheadBytes> message{};
  write_envelope_header(0, message);
  return message;
}

void count_message(void* user, std::span<const std::uint8_t> /*message*/) noexcept {
  ++*static_cast<int*>(user);
}

}  // namespace

Result<Done> check_channel(std::string_view channel) {
  bool printable = !channel.empty() && channel.size() <= kMaxChannelBytes;
  for (const char c : channel)
    printable = printable && std::isgraph(static_cast<unsigned char>(c)) != 0;
  if (printable) return Done{};
  return {Status::kUsage, "LCM channel '" + std::string(channel) +
                              "' must be 1 to 63 printable characters without blanks"};
}

struct LcmLink::Impl {
  LcmUrl url;
  lcm_t* lcm = nullptr;
  std::deque<Binding> bindings;  // addresses must not move: liblcm holds them
  bool received_on = false;
};

LcmLink::LcmLink(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

LcmLink::~LcmLink() {
  if (impl_->lcm != nullptr) lcm_destroy(impl_->lcm);
}

const LcmUrl& LcmLink::url() const noexcept {
  return impl_->url;
}

Result<std::shared_ptr<LcmLink>> LcmLink::open(const LcmUrl& url, bool for_receiving) {
  const Result<Done> route = check_multicast_route(url);
  if (!route) return route.error();
  auto impl = std::make_unique<Impl>();
  impl->url = url;
  const std::string text = to_string(url, for_receiving);
  impl->lcm = lcm_create(text.c_str());
  if (impl->lcm == nullptr)
    return {Status::kNetwork, "liblcm cannot open " + text + "; 'planecast doctor' looks closer"};
  std::shared_ptr<LcmLink> link(new LcmLink(std::move(impl)));
  // liblcm makes its sending lock at the first message.
  if (!url.memory) (void)link->publish(kWarmUpChannel, greeting());
  return link;
}

Status LcmLink::publish(const char* channel, std::span<const std::uint8_t> message) noexcept {
  const int status =
      lcm_publish(impl_->lcm, channel, message.data(), static_cast<unsigned int>(message.size()));
  return status == 0 ? Status::kOk : Status::kNetwork;
}

Result<Done> LcmLink::subscribe(std::string_view channel, Handler handler, void* user, int queue) {
  const Result<Done> checked = check_channel(channel);
  if (!checked) return checked.error();
  if (impl_->received_on)
    return {Status::kBadConfig, "this LCM link has a receiver already; open another link"};
  Binding& binding = impl_->bindings.emplace_back(Binding{handler, user});
  lcm_subscription_t* subscription =
      lcm_subscribe(impl_->lcm, escaped(channel).c_str(), on_message, &binding);
  // A failed bind leaves no descriptor, and liblcm's select() has no room past FD_SETSIZE.
  const int fd = subscription == nullptr ? -1 : lcm_get_fileno(impl_->lcm);
  if (fd < 0 || fd >= FD_SETSIZE)
    return {Status::kNetwork,
            "liblcm cannot receive on " + to_string(impl_->url) +
                "; another program may hold the port, or too many files are open"};
  lcm_subscription_set_queue_capacity(subscription, queue);
  impl_->received_on = true;
  return Done{};
}

Result<Done> LcmLink::warm_up(std::string_view channel, int queue, std::size_t message_bytes) {
  if (impl_->url.memory) return Done{};
  LcmUrl quiet = impl_->url;
  quiet.ttl = 0;
  Result<std::shared_ptr<LcmLink>> sender = open(quiet, false);
  if (!sender) return sender.error();
  int received = 0;
  Binding binding{count_message, &received};
  lcm_subscription_t* subscription =
      lcm_subscribe(impl_->lcm, kWarmUpChannel, on_message, &binding);
  if (subscription == nullptr) return {Status::kNetwork, "liblcm refuses a second subscription"};
  lcm_subscription_set_queue_capacity(subscription, queue);

  (void)sender.value()->publish(std::string(channel).c_str(), greeting());
  const WarmUpBurst burst = warm_up_burst(queue, message_bytes);
  const std::vector<std::uint8_t> filler(burst.bytes);
  const std::int64_t limit_ns = monotonic_ns() + kWarmUpLimitNs;
  // Until one burst was in the queue as a whole.
  for (int before = 0; received - before < burst.messages && monotonic_ns() < limit_ns;) {
    before = received;
    for (int i = 0; i < burst.messages; ++i) {
      (void)sender.value()->publish(kWarmUpChannel, filler);
      if (i % 2 == 1) std::this_thread::sleep_for(kWarmUpPause);
    }
    // The stream itself may be running already, so the link need never fall silent.
    while (received - before < burst.messages && monotonic_ns() < limit_ns && handle(20) > 0) {
    }
  }
  lcm_unsubscribe(impl_->lcm, subscription);
  if (received > 0) return Done{};
  return {Status::kNetwork, "messages sent to " + to_string(impl_->url) +
                                " do not come back to this host; a firewall may drop UDP port " +
                                std::to_string(impl_->url.port) + " ('planecast doctor')"};
}

int LcmLink::handle(int timeout_ms) noexcept {
  return lcm_handle_timeout(impl_->lcm, timeout_ms);
}

}  // namespace planecast
