#include "transport/drake_point_cloud.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <cstring>
#include <limits>

#include "core/base/bytes.hpp"

namespace planecast {
namespace {

constexpr std::uint8_t kFloat32 = 7;
constexpr std::uint64_t kBigEndian = 1;
constexpr std::uint64_t kStrictlyFinite = 2;
constexpr std::uint32_t kPointBytes = 12;
constexpr std::array<char, 3> kAxes = {'x', 'y', 'z'};
constexpr std::size_t kFieldBytes = 4 + 2 + 4 + 1 + 4;  // one-letter name with its NUL
constexpr std::size_t kFixedBytes = 8 + 8 + 4 + 1 + 8 + 8 + 4 + 3 * kFieldBytes + 8 + 4 + 8 + 2 + 8;
constexpr std::uint32_t kMaxFields = 64;

/// Appends big-endian values to memory that is known to be large enough.
class Writer {
 public:
  explicit Writer(std::uint8_t* at) noexcept : at_(at) {}
  template <class T>
  void put(T value) noexcept {
    store_be(at_, value);
    at_ += sizeof(T);
  }
  void put_string(std::string_view text) noexcept {
    put(static_cast<std::uint32_t>(text.size() + 1));
    std::memcpy(at_, text.data(), text.size());
    at_[text.size()] = 0;
    at_ += text.size() + 1;
  }
  void put_floats(const float* values, std::size_t count) noexcept {
    for (std::size_t i = 0; i < count; ++i, at_ += 4)
      store_le(at_, std::bit_cast<std::uint32_t>(values[i]));
  }
  const std::uint8_t* at() const noexcept { return at_; }

 private:
  std::uint8_t* at_;
};

/// Reads big-endian values; once the bytes run out everything reads as zero and ok() is false.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> bytes) noexcept : rest_(bytes) {}
  bool ok() const noexcept { return ok_; }
  std::size_t left() const noexcept { return rest_.size(); }

  template <class T>
  T get() noexcept {
    const std::span<const std::uint8_t> bytes = take(sizeof(T));
    return ok_ ? load_be<T>(bytes.data()) : T{0};
  }
  std::span<const std::uint8_t> take(std::uint64_t count) noexcept {
    if (!ok_ || count > rest_.size()) {
      ok_ = false;
      return {};
    }
    const auto bytes = rest_.first(static_cast<std::size_t>(count));
    rest_ = rest_.subspan(bytes.size());
    return bytes;
  }
  /// A length that counts the NUL, then the characters; kFieldRange without that NUL.
  std::string_view get_string(Status& status) noexcept {
    const auto length = get<std::uint32_t>();
    const std::span<const std::uint8_t> bytes = take(length);
    if (!ok_) return {};
    if (bytes.empty() || bytes.back() != 0) {
      status = Status::kFieldRange;
      return {};
    }
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size() - 1};
  }

 private:
  std::span<const std::uint8_t> rest_;
  bool ok_ = true;
};

bool finite(const float* point) noexcept {
  return std::isfinite(point[0]) && std::isfinite(point[1]) && std::isfinite(point[2]);
}

/// The field table; `found` gets a bit for each of x, y, z.
Status read_fields(Reader& reader, DrakePointCloud& out, unsigned& found) noexcept {
  const auto count = reader.get<std::uint32_t>();
  if (!reader.ok()) return Status::kTruncated;
  if (count > kMaxFields) return Status::kFieldRange;
  for (std::uint32_t i = 0; i < count; ++i) {
    Status status = Status::kOk;
    const std::string_view name = reader.get_string(status);
    if (status != Status::kOk) return status;
    const auto offset = reader.get<std::uint32_t>();
    const auto type = reader.get<std::uint8_t>();
    const auto elements = reader.get<std::uint32_t>();
    if (!reader.ok()) return Status::kTruncated;
    for (std::size_t axis = 0; axis < kAxes.size(); ++axis) {
      if (name.size() != 1 || name[0] != kAxes[axis]) continue;
      if (type != kFloat32 || elements != 1) return Status::kUnsupportedVersion;
      out.offset[axis] = offset;
      found |= 1U << axis;
    }
  }
  return Status::kOk;
}

/// Whether rows and points as announced lie within the data.
Status check_layout(const DrakePointCloud& cloud) noexcept {
  if (cloud.points() == 0) return Status::kOk;
  for (const std::uint32_t offset : cloud.offset)
    if (cloud.point_step < 4 || offset > cloud.point_step - 4) return Status::kFieldRange;
  const std::uint64_t row_bytes = std::uint64_t{cloud.width} * cloud.point_step;
  const std::uint64_t size = cloud.data.size();
  if (row_bytes > size) return Status::kFieldRange;
  if (cloud.height == 1) return Status::kOk;
  if (cloud.row_step < row_bytes || cloud.row_step > (size - row_bytes) / (cloud.height - 1U))
    return Status::kFieldRange;
  return Status::kOk;
}

}  // namespace

std::size_t drake_point_cloud_bytes(std::size_t points, std::string_view frame_name) noexcept {
  return kFixedBytes + frame_name.size() + points * kPointBytes;
}

Status encode_drake_point_cloud(std::int64_t utime, std::string_view frame_name,
                                std::span<const float> xyz, std::size_t max_points,
                                std::span<std::uint8_t> out, std::size_t& size) noexcept {
  size = 0;
  if (xyz.size() % 3 != 0 || frame_name.size() > kDrakeMaxFrameName) return Status::kFieldRange;
  std::size_t usable = 0;
  for (std::size_t i = 0; i < xyz.size(); i += 3) usable += finite(&xyz[i]) ? 1U : 0U;
  const std::size_t kept = std::min(usable, max_points);
  if (kept > std::numeric_limits<std::uint32_t>::max() / kPointBytes) return Status::kTooLarge;
  if (drake_point_cloud_bytes(kept, frame_name) > out.size()) return Status::kTooLarge;

  Writer writer(out.data());
  const std::uint64_t data_bytes = std::uint64_t{kept} * kPointBytes;
  writer.put(kDrakePointCloudFingerprint);
  writer.put(static_cast<std::uint64_t>(utime));
  writer.put_string(frame_name);
  writer.put(std::uint64_t{kept});  // width
  writer.put(std::uint64_t{1});     // height
  writer.put(static_cast<std::uint32_t>(kAxes.size()));
  for (std::uint32_t axis = 0; axis < kAxes.size(); ++axis) {
    writer.put_string({&kAxes[axis], 1});
    writer.put(4 * axis);
    writer.put(kFloat32);
    writer.put(std::uint32_t{1});
  }
  writer.put(kStrictlyFinite);
  writer.put(kPointBytes);
  writer.put(data_bytes);        // row_step
  writer.put(std::uint16_t{0});  // no filler
  writer.put(data_bytes);
  // Point j of those usable is kept when j * kept / usable steps up: evenly spread, exactly `kept`.
  std::uint64_t credit = 0;
  for (std::size_t i = 0; i < xyz.size(); i += 3) {
    if (!finite(&xyz[i])) continue;
    credit += kept;
    if (credit < usable) continue;
    credit -= usable;
    writer.put_floats(&xyz[i], 3);
  }
  size = static_cast<std::size_t>(writer.at() - out.data());
  return Status::kOk;
}

void DrakePointCloud::point(std::uint32_t row, std::uint32_t column, float out[3]) const noexcept {
  const std::uint8_t* at = data.data() + row * row_step + std::uint64_t{column} * point_step;
  for (int axis = 0; axis < 3; ++axis)
    out[axis] = std::bit_cast<float>(load_le<std::uint32_t>(at + offset[axis]));
}

Status decode_drake_point_cloud(std::span<const std::uint8_t> message, std::size_t max_points,
                                DrakePointCloud& out) noexcept {
  out = {};
  Reader reader(message);
  const auto fingerprint = reader.get<std::uint64_t>();
  if (!reader.ok()) return Status::kTruncated;
  if (fingerprint != kDrakePointCloudFingerprint) return Status::kBadMagic;
  DrakePointCloud cloud;
  Status status = Status::kOk;
  cloud.utime = static_cast<std::int64_t>(reader.get<std::uint64_t>());
  cloud.frame_name = reader.get_string(status);
  if (status != Status::kOk) return status;
  const auto width = reader.get<std::uint64_t>();
  const auto height = reader.get<std::uint64_t>();
  if (!reader.ok()) return Status::kTruncated;
  unsigned found = 0;
  status = read_fields(reader, cloud, found);
  if (status != Status::kOk) return status;
  const auto flags = reader.get<std::uint64_t>();
  cloud.point_step = reader.get<std::uint32_t>();
  cloud.row_step = reader.get<std::uint64_t>();
  const auto filler = reader.get<std::uint16_t>();
  (void)reader.take(filler);
  cloud.data = reader.take(reader.get<std::uint64_t>());
  if (!reader.ok()) return Status::kTruncated;
  if (reader.left() != 0) return Status::kTrailingBytes;
  if (filler > std::numeric_limits<std::int16_t>::max()) return Status::kFieldRange;
  if ((flags & ~(kBigEndian | kStrictlyFinite)) != 0) return Status::kReservedBits;
  if ((flags & kBigEndian) != 0 || found != 7U) return Status::kUnsupportedVersion;
  // Negative numbers are huge here; either side alone may be at most max_points.
  if (width > max_points || height > max_points || (height != 0 && width > max_points / height))
    return Status::kTooLarge;
  constexpr std::uint64_t kMaxSide = std::numeric_limits<std::uint32_t>::max();
  if (width > kMaxSide || height > kMaxSide) return Status::kTooLarge;
  cloud.width = static_cast<std::uint32_t>(width);
  cloud.height = static_cast<std::uint32_t>(height);
  cloud.strictly_finite = (flags & kStrictlyFinite) != 0;
  status = check_layout(cloud);
  if (status == Status::kOk) out = cloud;
  return status;
}

DrakePublisher::DrakePublisher(std::string channel, std::string frame_name, std::size_t max_points,
                               std::shared_ptr<LcmLink> link)
    : channel_(std::move(channel)),
      frame_name_(std::move(frame_name)),
      max_points_(max_points),
      link_(std::move(link)),
      buffer_(drake_point_cloud_bytes(max_points, frame_name_)) {}

Result<std::unique_ptr<DrakePublisher>> DrakePublisher::create(const std::string& channel,
                                                               const std::string& frame_name,
                                                               std::size_t max_points,
                                                               std::shared_ptr<LcmLink> link) {
  const Result<Done> checked = check_channel(channel);
  if (!checked) return checked.error();
  if (frame_name.size() > kDrakeMaxFrameName)
    return {Status::kUsage, "the frame name is longer than 255 bytes"};
  return std::unique_ptr<DrakePublisher>(
      new DrakePublisher(channel, frame_name, max_points, std::move(link)));
}

Status DrakePublisher::publish(std::int64_t utime, std::span<const float> xyz) noexcept {
  std::size_t size = 0;
  const Status status =
      encode_drake_point_cloud(utime, frame_name_, xyz, max_points_, buffer_, size);
  return status == Status::kOk ? link_->publish(channel_.c_str(), {buffer_.data(), size}) : status;
}

}  // namespace planecast
