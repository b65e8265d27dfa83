#include "tests/golden/golden_vectors.hpp"

#include <algorithm>
#include <bit>
#include <cstdio>

#include "core/base/bytes.hpp"
#include "core/base/crc32c.hpp"
#include "core/pipeline/decoder.hpp"
#include "core/pipeline/encoder.hpp"
#include "core/wire/key_packet.hpp"
#include "core/wire/plc_format.hpp"

namespace planecast::test {
namespace {

constexpr std::int64_t kPeriodNs = 33'333'333;

Bytes cloud_bytes(const std::vector<Point3f>& cloud) {
  Bytes out(cloud.size() * 12);
  std::uint8_t* p = out.data();
  for (const Point3f& point : cloud) {
    for (const float f : {point.x, point.y, point.z}) {
      store_le<std::uint32_t>(p, std::bit_cast<std::uint32_t>(f));
      p += 4;
    }
  }
  return out;
}

Bytes depth_bytes(const std::vector<std::uint16_t>& depth) {
  Bytes out(depth.size() * 2);
  for (std::size_t i = 0; i < depth.size(); ++i) store_le<std::uint16_t>(&out[2 * i], depth[i]);
  return out;
}

bool reading(const Point3f& p) {
  return p.x - p.x == 0.0F && p.y - p.y == 0.0F && p.z - p.z == 0.0F;
}

// Submits frame `i`, and appends its slices.
Status encode_frame(Encoder& encoder, const GoldenCase& c, std::size_t i, PlcWriter& writer) {
  const std::int64_t stamp = c.config.epoch_ns + static_cast<std::int64_t>(i) * kPeriodNs;
  const Status submitted = c.config.kind == FrameKind::kDepth
                               ? encoder.submit(DepthView{c.depth[i], i, stamp})
                               : encoder.submit(c.clouds[i], i, stamp);
  if (submitted != Status::kOk) return submitted;
  EncodedFrame frame;
  if (!encoder.try_next(frame)) return Status::kStopped;
  Status status = frame.status;
  for (std::uint32_t s = 0; s < frame.slot->report.slices && status == Status::kOk; ++s)
    status = writer.add_packet(frame.slot->slice(s));
  encoder.release(frame);
  return status;
}

// A clock for encoders that shall find no time left, ever.
std::int64_t racing_clock() noexcept {
  static std::int64_t now = 0;
  return now += 1'000'000'000;
}

}  // namespace

Result<Bytes> encode_golden(const GoldenCase& c) {
  EncoderConfig config;
  if (c.no_time) {
    config.budget_ms = 1;
    config.clock = racing_clock;
  }
  config.stream = c.config;
  config.stages.slice_bytes = c.slice_bytes;
  config.stages.surfaces = c.surfaces;
  config.stages.drop_outliers = config.stages.paper = c.drop_outliers;
  config.runner.mode = RunMode::kInline;
  config.runner.slots = 1;
  auto encoder = Encoder::create(config);
  if (!encoder.ok()) return encoder.error();
  if (const auto started = (*encoder)->start(); !started.ok()) return started.error();
  Bytes file;
  PlcWriter writer(file);
  Bytes key(kPacketHeaderBytes + kMaxKeyBodyBytes);
  key.resize((*encoder)->key_packet(0, c.config.epoch_ns, key));
  Status status = writer.add_packet(key);
  for (std::size_t i = 0; i < std::max(c.depth.size(), c.clouds.size()) && status == Status::kOk;
       ++i)
    status = encode_frame(**encoder, c, i, writer);
  if (status != Status::kOk) return Error{status, c.name + " cannot be encoded"};
  writer.finish();
  return file;
}

Result<std::vector<GoldenFrame>> decode_golden(std::span<const std::uint8_t> file,
                                               const FrameLimits& limits) {
  const auto contents = read_plc(file);
  if (!contents.ok()) return contents.error();
  if (!contents->complete || contents->damaged_packets + contents->orphan_slices != 0)
    return Error{Status::kTruncated, "packets are missing"};
  auto decoder = Decoder::create({.limits = limits});
  if (!decoder.ok()) return decoder.error();
  Decoder& d = **decoder;
  std::vector<GoldenFrame> out;
  for (const PlcFrame& frame : contents->frames) {
    Status status = d.set_key(frame.key);
    if (status == Status::kOk) status = d.begin();
    for (const auto slice : frame.slices)
      if (status == Status::kOk) status = d.add(slice);
    if (status == Status::kOk) status = d.finish();
    if (status != Status::kOk)
      return Error{status, "frame " + std::to_string(out.size()) + " cannot be decoded"};
    out.push_back({frame.slice_count,
                   {d.depth().begin(), d.depth().end()},
                   {d.labels().begin(), d.labels().end()},
                   {d.cloud().begin(), d.cloud().end()}});
  }
  return out;
}

std::string expected_lines(const std::string& name, const std::vector<GoldenFrame>& frames) {
  std::string out;
  for (std::size_t i = 0; i < frames.size(); ++i) {
    const GoldenFrame& f = frames[i];
    const auto readings = std::count_if(f.cloud.begin(), f.cloud.end(), reading);
    char depth[16] = "-", line[200];
    if (!f.depth.empty()) std::snprintf(depth, sizeof depth, "%08x", crc32c(depth_bytes(f.depth)));
    std::snprintf(line, sizeof line, "%s %zu %u %td %s %08x\n", name.c_str(), i, unsigned{f.slices},
                  readings, depth, crc32c(cloud_bytes(f.cloud)));
    out += line;
  }
  return out;
}

std::string dump_lines(const GoldenFrame& frame, std::uint32_t width) {
  if (width == 0) width = static_cast<std::uint32_t>(frame.cloud.size());  // a list: one row
  std::string out = "# u v count label x y z (the bits of float32; -1: the stream has none)\n";
  for (std::uint32_t i = 0; i < frame.cloud.size(); ++i) {
    const Point3f& p = frame.cloud[i];
    char line[120];
    std::snprintf(line, sizeof line, "%u %u %d %d %08x %08x %08x\n", i % width, i / width,
                  frame.depth.empty() ? -1 : int{frame.depth[i]},
                  frame.labels.empty() ? -1 : int{frame.labels[i]},
                  std::bit_cast<std::uint32_t>(p.x), std::bit_cast<std::uint32_t>(p.y),
                  std::bit_cast<std::uint32_t>(p.z));
    out += line;
  }
  return out;
}

}  // namespace planecast::test
