#include "transport/plain_subscriber.hpp"

#include <atomic>
#include <thread>

#include "transport/snapshot_box.hpp"
#include "transport/wake.hpp"

namespace planecast {

struct PlainSubscriber::Impl {
  Callback callback;
  std::shared_ptr<LcmLink> link;
  PlainStatistics counts;
  SnapshotBox<PlainStatistics> box;
  std::atomic<bool> stopping{false};
  std::thread thread;

  static void on_message(void* user, std::span<const std::uint8_t> message) noexcept {
    Impl& self = *static_cast<Impl*>(user);
    ++self.counts.messages;
    self.counts.bytes += message.size();
    if (message.empty()) ++self.counts.bad_length;
    self.box.store(self.counts);
    if (!message.empty()) self.callback(message, monotonic_ns());
  }

  void run() noexcept {
    while (!stopping.load(std::memory_order_acquire)) {
      if (link->handle(static_cast<int>(kIdleWaitMs)) >= 0) continue;
      ++counts.receive_errors;
      box.store(counts);
      std::this_thread::sleep_for(kErrorPause);
    }
  }
};

PlainSubscriber::PlainSubscriber(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

PlainSubscriber::~PlainSubscriber() {
  stop();
}

Result<std::unique_ptr<PlainSubscriber>> PlainSubscriber::create(const std::string& channel,
                                                                 std::shared_ptr<LcmLink> link,
                                                                 Callback callback, int queue) {
  auto impl = std::make_unique<Impl>();
  impl->callback = std::move(callback);
  impl->link = std::move(link);
  std::unique_ptr<PlainSubscriber> subscriber(new PlainSubscriber(std::move(impl)));
  Impl* raw = subscriber->impl_.get();
  Result<Done> subscribed = raw->link->subscribe(channel, &Impl::on_message, raw, queue);
  if (!subscribed) return subscribed.error();
  raw->thread = std::thread([raw] { raw->run(); });
  return subscriber;
}

PlainStatistics PlainSubscriber::statistics() const noexcept {
  PlainStatistics out;
  impl_->box.load(out);
  return out;
}

void PlainSubscriber::stop() noexcept {
  impl_->stopping.store(true, std::memory_order_release);
  if (impl_->thread.joinable()) impl_->thread.join();
}

}  // namespace planecast
