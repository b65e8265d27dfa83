#include "transport/subscriber.hpp"

#include <algorithm>
#include <atomic>
#include <thread>

#include "transport/service_thread.hpp"
#include "transport/wake.hpp"

namespace planecast {

struct Subscriber::Impl {
  ParseFn parse = nullptr;
  std::shared_ptr<LcmLink> link;
  std::unique_ptr<Assembler> assembler;
  std::atomic<bool> stopping{false};
  ServiceThread thread;

  static void on_message(void* user, std::span<const std::uint8_t> message) noexcept {
    static_cast<Impl*>(user)->receive(message);
  }
  void receive(std::span<const std::uint8_t> message) noexcept;
  void run() noexcept;
};

void Subscriber::Impl::receive(std::span<const std::uint8_t> message) noexcept {
  LinkStatistics& link_statistics = assembler->link();
  ++link_statistics.messages;
  link_statistics.bytes += message.size();
  std::span<const std::uint8_t> packet;
  PacketInfo info;
  Status status = decode_envelope(message, packet);
  const bool greeting = status == Status::kOk && packet.empty();
  if (status == Status::kOk && !greeting) status = parse(packet, info);
  if (greeting) {
    ++link_statistics.greetings;
  } else if (status != Status::kOk) {
    link_statistics.count_refused(status);
  }
  assembler->publish_link();
  if (status == Status::kOk && !greeting) assembler->push(packet, info, monotonic_ns());
}

void Subscriber::Impl::run() noexcept {
  while (!stopping.load(std::memory_order_acquire)) {
    const std::int64_t due_ns = assembler->next_deadline_ns() - monotonic_ns();
    // Rounded up: woken a moment early, the loop would spin until the deadline.
    const std::int64_t due_ms = due_ns > kIdleWaitMs * 1'000'000
                                    ? kIdleWaitMs
                                    : (std::max<std::int64_t>(due_ns, 0) + 999'999) / 1'000'000;
    if (link->handle(static_cast<int>(due_ms)) < 0) {
      ++assembler->link().receive_errors;
      assembler->publish_link();
      std::this_thread::sleep_for(kErrorPause);
    }
    assembler->poll(monotonic_ns());
  }
}

Subscriber::Subscriber(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

Subscriber::~Subscriber() {
  stop();
}

std::size_t Subscriber::memory_bytes(const SubscriberConfig& config) noexcept {
  return Assembler::memory_bytes(config.assembly);
}

Result<std::unique_ptr<Subscriber>> Subscriber::create(const SubscriberConfig& config,
                                                       std::shared_ptr<LcmLink> link,
                                                       Arena* arena) {
  if (config.parse == nullptr) return {Status::kBadConfig, "the subscriber has no packet parser"};
  if (config.lcm_queue < 1) return {Status::kBadConfig, "lcm_queue must be at least 1"};
  Result<std::unique_ptr<Assembler>> assembler = Assembler::create(config.assembly, arena);
  if (!assembler) return assembler.error();
  auto impl = std::make_unique<Impl>();
  impl->parse = config.parse;
  impl->link = std::move(link);
  impl->assembler = std::move(assembler.value());
  std::unique_ptr<Subscriber> subscriber(new Subscriber(std::move(impl)));
  Impl* raw = subscriber->impl_.get();
  Result<Done> subscribed =
      raw->link->subscribe(config.channel, &Impl::on_message, raw, config.lcm_queue);
  if (!subscribed) return subscribed.error();
  const std::size_t warm_up_bytes = std::min<std::size_t>(
      config.message_bytes, max_datagram_message_bytes(config.channel) - kMaxChannelBytes);
  Result<Done> warmed = raw->link->warm_up(config.channel, config.lcm_queue, warm_up_bytes);
  if (!warmed) return warmed.error();
  const auto entry = [](void* self) { static_cast<Impl*>(self)->run(); };
  const auto started = raw->thread.start("subscriber", config.on_thread_start, entry, raw);
  if (!started) return started.error();
  return subscriber;
}

Assembler& Subscriber::assembler() noexcept {
  return *impl_->assembler;
}

ReceiverStatistics Subscriber::statistics() const noexcept {
  return impl_->assembler->statistics();
}

void Subscriber::stop() noexcept {
  impl_->stopping.store(true, std::memory_order_release);
  impl_->thread.join();
  impl_->assembler->interrupt();
}

}  // namespace planecast
