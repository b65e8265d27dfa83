#include "apps/common/lcm_source.hpp"

#include <fmt/format.h>

#include <condition_variable>
#include <deque>
#include <mutex>

#include "transport/drake_point_cloud.hpp"
#include "transport/plain_subscriber.hpp"

namespace planecast {
namespace {

constexpr std::size_t kWaiting = 2;  // clouds; one in hand at the taker beside them

void copy_cloud(const DrakePointCloud& from, PointCloud& to) {
  // A column of points is a list written sideways.
  const bool list = from.width < 2 || from.height < 2;
  to.width = list ? static_cast<std::uint32_t>(from.points()) : from.width;
  to.height = list ? 1 : from.height;
  to.points.resize(from.points());
  for (std::uint32_t row = 0; row < from.height; ++row) {
    for (std::uint32_t column = 0; column < from.width; ++column) {
      float xyz[3];
      from.point(row, column, xyz);
      to.points[std::size_t{row} * from.width + column] = {xyz[0], xyz[1], xyz[2]};
    }
  }
}

}  // namespace

struct LcmSource::Impl {
  std::string channel;
  mutable std::mutex mutex;
  std::condition_variable changed;
  std::deque<SensorFrame> waiting;
  LcmSourceCounts counts;
  std::string refusal;
  bool interrupted = false;
  std::unique_ptr<PlainSubscriber> subscriber;  // last: its thread uses the rest

  void take_message(std::span<const std::uint8_t> message);
  void refuse(std::uint64_t LcmSourceCounts::*cause, std::string why);
  bool wait(SensorFrame& frame, std::optional<std::chrono::nanoseconds> limit);
};

void LcmSource::Impl::refuse(std::uint64_t LcmSourceCounts::*cause, std::string why) {
  const std::lock_guard lock(mutex);
  ++counts.messages;
  ++(counts.*cause);
  refusal = fmt::format("lcm:{}: {}", channel, why);
}

void LcmSource::Impl::take_message(std::span<const std::uint8_t> message) {
  DrakePointCloud cloud;
  if (const Status status = decode_drake_point_cloud(message, kMaxPoints, cloud);
      status != Status::kOk) {
    refuse(&LcmSourceCounts::refused_malformed,
           fmt::format("a message of {} bytes is no drake.lcmt_point_cloud with float32 x, y, z "
                       "({}); check who publishes on the channel",
                       message.size(), to_string(status)));
    return;
  }
  SensorFrame frame;
  copy_cloud(cloud, frame.cloud);
  frame.stamp_ns = static_cast<std::int64_t>(static_cast<std::uint64_t>(cloud.utime) * 1000U);
  frame.frame_id = cloud.frame_name;
  const std::lock_guard lock(mutex);
  ++counts.messages;
  frame.number = counts.clouds++;
  frame.name = fmt::format("lcm:{}#{}", channel, frame.number);
  if (waiting.size() == kWaiting) {
    waiting.pop_front();
    ++counts.passed_over;
  }
  waiting.push_back(std::move(frame));
  changed.notify_one();
}

bool LcmSource::Impl::wait(SensorFrame& frame, std::optional<std::chrono::nanoseconds> limit) {
  std::unique_lock lock(mutex);
  const auto ready = [this] { return interrupted || !waiting.empty(); };
  if (limit) {
    changed.wait_for(lock, *limit, ready);
  } else {
    changed.wait(lock, ready);
  }
  if (interrupted || waiting.empty()) return false;
  frame = std::move(waiting.front());
  waiting.pop_front();
  return true;
}

LcmSource::LcmSource(std::unique_ptr<Impl> impl) : impl_(std::move(impl)) {}

LcmSource::~LcmSource() = default;

Result<std::unique_ptr<LcmSource>> LcmSource::open(const std::string& channel,
                                                   std::shared_ptr<LcmLink> link) {
  auto impl = std::make_unique<Impl>();
  impl->channel = channel;
  Impl* raw = impl.get();
  auto subscriber = PlainSubscriber::create(
      channel, std::move(link),
      [raw](std::span<const std::uint8_t> message, std::int64_t) { raw->take_message(message); });
  if (!subscriber) return subscriber.error();
  impl->subscriber = std::move(*subscriber);
  return std::unique_ptr<LcmSource>(new LcmSource(std::move(impl)));
}

Result<bool> LcmSource::next(SensorFrame& frame) {
  return impl_->wait(frame, std::nullopt);
}

bool LcmSource::next_within(SensorFrame& frame, std::int64_t timeout_ns) {
  return impl_->wait(frame, std::chrono::nanoseconds(timeout_ns));
}

void LcmSource::interrupt() {
  const std::lock_guard lock(impl_->mutex);
  impl_->interrupted = true;
  impl_->changed.notify_all();
}

LcmSourceCounts LcmSource::counts() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->counts;
}

std::string LcmSource::refusal() const {
  const std::lock_guard lock(impl_->mutex);
  return impl_->refusal;
}

}  // namespace planecast
