#include "core/wire/key_packet.hpp"

#include <cstring>

#include "core/base/bytes.hpp"
#include "core/base/crc32c.hpp"
#include "core/wire/packet_header.hpp"

namespace planecast {
namespace {

// Appends little-endian fields; the caller has made sure of the room.
class Writer {
 public:
  explicit Writer(std::uint8_t* out) noexcept : out_(out) {}
  template <class T>
  void put(T value) noexcept {
    store_le<std::make_unsigned_t<T>>(out_ + size_, static_cast<std::make_unsigned_t<T>>(value));
    size_ += sizeof(T);
  }
  std::size_t size() const noexcept { return size_; }

 private:
  std::uint8_t* out_;
  std::size_t size_ = 0;
};

// Reads little-endian fields; past the end every field is zero and ok() is false.
class Reader {
 public:
  explicit Reader(std::span<const std::uint8_t> in) noexcept : in_(in) {}
  template <class T>
  void get(T& value) noexcept {
    if (in_.size() - at_ < sizeof(T)) {
      ok_ = false;
      value = T{};
      return;
    }
    value = static_cast<T>(load_le<std::make_unsigned_t<T>>(in_.data() + at_));
    at_ += sizeof(T);
  }
  void skip(std::size_t bytes) noexcept {
    if (in_.size() - at_ < bytes) {
      ok_ = false;
    } else {
      at_ += bytes;
    }
  }
  bool ok() const noexcept { return ok_; }
  std::size_t left() const noexcept { return in_.size() - at_; }

 private:
  std::span<const std::uint8_t> in_;
  std::size_t at_ = 0;
  bool ok_ = true;
};

// Flag bits; the others are reserved.
constexpr std::uint8_t kDropOffSurface = 0x01;
constexpr std::uint8_t kEffortBest = 0x02;
constexpr std::uint8_t kLatticeTruncated = 0x04;
constexpr std::uint8_t kMirrorY = 0x08;
constexpr std::uint8_t kFlags = kDropOffSurface | kEffortBest | kLatticeTruncated | kMirrorY;

// One description of the fields for both directions: Field is Writer::put or Reader::get.
template <class Config, class Field>
void camera_fields(Config& c, Field&& field) noexcept {
  field(c.camera.width);
  field(c.camera.height);
  field(c.camera.fx_q16);
  field(c.camera.fy_q16);
  field(c.camera.cx_q16);
  field(c.camera.cy_q16);
  field(c.camera.k1_q24);
  field(c.camera.k2_q24);
  field(c.camera.p1_q24);
  field(c.camera.p2_q24);
  field(c.camera.k3_q24);
  field(c.camera.unit_pm);
}

template <class Config, class Field>
void points_fields(Config& c, Field&& field) noexcept {
  field(c.points.max_points);
  field(c.points.step_pm);
  field(c.points.tolerance_steps);
  field(c.points.patch_unit_nm);
  field(c.points.seed);
}

template <class Config, class Field>
void pose_fields(Config& c, Field&& field) noexcept {
  for (auto* pose : {&c.pose, &c.axes}) {
    for (auto& q : pose->q_q30) field(q);
    for (auto& t : pose->t_um) field(t);
  }
}

}  // namespace

std::size_t write_key_body(const StreamConfig& config, std::span<std::uint8_t> out) noexcept {
  if (out.size() < kMaxKeyBodyBytes) return 0;
  Writer w(out.data());
  const auto put = [&](auto value) { w.put(value); };
  put(kWireMinor);
  put(config.stream);
  const auto flags = static_cast<std::uint8_t>(
      (config.drop_off_surface ? kDropOffSurface : 0) | (config.effort_best ? kEffortBest : 0) |
      (config.lattice.truncated ? kLatticeTruncated : 0) | (config.mirror_y ? kMirrorY : 0));
  put(flags);
  put(static_cast<std::uint8_t>(config.kind));
  put(static_cast<std::uint8_t>(config.z_rule));
  put(static_cast<std::uint8_t>(config.clock));
  put(static_cast<std::uint8_t>(config.tolerance));
  put(static_cast<std::uint8_t>(config.noise.kind));
  put(config.session);
  put(config.epoch_ns);
  put(config.boot_id);
  put(config.period_ms);
  if (config.kind == FrameKind::kPoints) {
    points_fields(config, put);
    put(static_cast<std::uint8_t>(config.points.fill));
  } else {
    camera_fields(config, put);
    put(config.lattice.c_q8);
    put(static_cast<std::uint16_t>(config.lattice.offset_q16));
  }
  put(config.noise.s_e9);
  put(config.tolerance_100nm);
  put(config.sigmas_q16);
  pose_fields(config, put);
  const auto id_bytes =
      static_cast<std::uint8_t>(::strnlen(config.frame_id.data(), kMaxFrameIdBytes));
  put(id_bytes);
  for (std::uint8_t i = 0; i < id_bytes; ++i) put(static_cast<std::uint8_t>(config.frame_id[i]));
  put(std::uint8_t{0});  // attribute blocks: none in this version
  return w.size();
}

Status read_key_body(std::span<const std::uint8_t> body, StreamConfig& config) noexcept {
  config = {};
  Reader r(body);
  const auto get = [&](auto& value) { r.get(value); };
  std::uint8_t minor = 0, flags = 0, kind = 0, rule = 0, clock = 0, tolerance = 0, noise = 0,
               id_bytes = 0, blocks = 0, fill = 0;
  get(minor);
  get(config.stream);
  get(flags);
  for (std::uint8_t* field : {&kind, &rule, &clock, &tolerance, &noise}) get(*field);
  get(config.session);
  get(config.epoch_ns);
  get(config.boot_id);
  get(config.period_ms);
  std::uint16_t offset = 0;
  if (static_cast<FrameKind>(kind) == FrameKind::kPoints) {
    points_fields(config, get);
    get(fill);
  } else {
    camera_fields(config, get);
    get(config.lattice.c_q8);
    get(offset);
  }
  get(config.noise.s_e9);
  get(config.tolerance_100nm);
  get(config.sigmas_q16);
  pose_fields(config, get);
  get(id_bytes);
  if (!r.ok()) return Status::kTruncated;
  // Before 1.0 a minor version may change anything, the trained constants for one.
  if (minor != kWireMinor) return Status::kUnsupportedVersion;
  if ((flags & ~kFlags) != 0) return Status::kReservedBits;
  if (id_bytes > kMaxFrameIdBytes) return Status::kFieldRange;
  for (std::uint8_t i = 0; i < id_bytes; ++i) get(config.frame_id[i]);
  if (r.ok() && ::strnlen(config.frame_id.data(), id_bytes) != id_bytes) return Status::kFieldRange;
  get(blocks);
  for (std::uint8_t i = 0; i < blocks && r.ok(); ++i) {
    // An attribute block: type, then its length; types are skipped until a version defines them.
    std::uint8_t type = 0;
    std::uint16_t length = 0;
    get(type);
    get(length);
    r.skip(length);
  }
  if (!r.ok()) return Status::kTruncated;
  if (r.left() != 0) return Status::kTrailingBytes;
  config.drop_off_surface = (flags & kDropOffSurface) != 0;
  config.effort_best = (flags & kEffortBest) != 0;
  config.lattice.truncated = (flags & kLatticeTruncated) != 0;
  config.mirror_y = (flags & kMirrorY) != 0;
  config.lattice.offset_q16 = offset;
  config.kind = static_cast<FrameKind>(kind);
  config.points.fill = static_cast<FillMode>(fill);
  config.z_rule = static_cast<ZRule>(rule);
  config.clock = static_cast<ClockDomain>(clock);
  config.tolerance = static_cast<ToleranceKind>(tolerance);
  config.noise.kind = static_cast<NoiseModel::Kind>(noise);
  return check_config(config);
}

std::uint32_t key_hash(std::span<const std::uint8_t> body) noexcept {
  return crc32c(body);
}

}  // namespace planecast
