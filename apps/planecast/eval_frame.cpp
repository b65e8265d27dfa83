#include "apps/planecast/eval_frame.hpp"

#include <fmt/format.h>

#include <utility>

#include "apps/common/stream_sender.hpp"
#include "apps/planecast/list_check.hpp"
#include "core/metrics/compression.hpp"
#include "core/metrics/distance.hpp"
#include "transport/envelope.hpp"

namespace planecast {
namespace {

constexpr int kTimes = 5, kWarmUps = 2;

std::uint32_t dropped(const PointCounts& counts) {
  return counts.outliers_dropped + counts.off_surface_dropped;
}

// All LCM payload of a frame: its slices and its share of the key packets, enveloped.
std::uint64_t wire_bytes_of(const CodedFrame& coded, std::size_t key_bytes, double rate_hz) {
  const std::uint64_t slices = coded.report.bytes + coded.packets.size() * kEnvelopeOverheadBytes;
  const std::uint32_t every = key_interval(rate_hz);
  return slices + (key_bytes + kEnvelopeOverheadBytes + every - 1) / every;
}

}  // namespace

FrameEvaluator::FrameEvaluator(const CodecOptions& options, const SourceSensor& sensor)
    : options_(options),
      rate_hz_(options.rate_hz.value_or(sensor.rate_hz)),
      file_(options, sensor, kFileSliceBytes, false) {}

Result<Done> FrameEvaluator::begin() {
  const StreamSetup& setup = file_.setup();
  auto wire = FrameCodec::create(setup, max_packet_bytes(options_.slice_bytes));
  if (!wire.ok()) return wire.error();
  wire_ = std::move(*wire);
  const CameraModel& camera = setup.encoder.stream.camera;
  FrameLimits limits{camera.width, camera.height};
  limits.max_points = setup.encoder.stream.points.max_points;
  auto decoder = Decoder::create({limits});
  if (!decoder.ok()) return decoder.error();
  decoder_ = std::move(*decoder);
  return Done{};
}

Result<Done> FrameEvaluator::decode(const SensorFrame& frame, const CodedFrame& coded) {
  Status status = decoder_->set_key(file_.codec().key_packet(frame));
  if (status == Status::kOk) status = decoder_->begin();
  for (const auto& packet : coded.packets) {
    if (status == Status::kOk) status = decoder_->add(packet);
  }
  if (status == Status::kOk) status = decoder_->finish();
  if (status == Status::kOk) return Done{};
  return Error{status, fmt::format("{}: could not be decoded again ({}); this is a fault of "
                                   "planecast, please report it with the frame",
                                   frame.name, to_string(status))};
}

double FrameEvaluator::time_decode(const CodedFrame& coded) {
  std::vector<double> ms;
  for (int i = 0; i < kTimes + kWarmUps; ++i) {
    const double begin = thread_cpu_ms();
    (void)decoder_->begin();
    for (const auto& packet : coded.packets) (void)decoder_->add(packet);
    (void)decoder_->finish();
    if (i >= kWarmUps) ms.push_back(thread_cpu_ms() - begin);
  }
  return median_ms(std::move(ms));
}

Result<EvaluatedFrame> FrameEvaluator::evaluate(const SensorFrame& frame) {
  bool fresh = false;
  const auto coded = file_.encode(frame, fresh);
  if (!coded.ok()) return coded.error();
  if (fresh) {
    if (const auto done = begin(); !done.ok()) return done.error();
  }
  const StreamSetup& setup = file_.setup();
  const auto wire = wire_->encode(setup, frame);
  if (!wire.ok()) return wire.error();

  EvaluatedFrame out;
  out.name = frame.name;
  out.counts = coded->counts;
  out.report = coded->report;
  out.effort = coded->effort;
  out.wire_slices = wire->report.slices;
  out.wire_bytes = wire_bytes_of(*wire, wire_->key_packet(frame).size(), rate_hz_);

  out.list = setup.encoder.stream.kind == FrameKind::kPoints;
  const auto judged =
      out.list ? judge_list(frame, *coded, *wire, out) : judge_grid(frame, *coded, *wire, out);
  if (!judged.ok()) return judged.error();
  out.encode_ms = file_.codec().time_encode(setup, frame, kTimes, kWarmUps);
  out.decode_ms = time_decode(*coded);
  out.decoded.assign(decoder_->cloud().begin(), decoder_->cloud().end());
  return out;
}

Result<Done> FrameEvaluator::judge_grid(const SensorFrame& frame, const CodedFrame& coded,
                                        const CodedFrame& wire, EvaluatedFrame& out) {
  const StreamSetup& setup = file_.setup();
  if (const auto done = decode(frame, wire); !done.ok()) return done.error();
  auto original = original_of(setup, frame, *decoder_);
  if (!original.ok()) return original.error();
  out.wire_broken = check_frame(setup, *original, *decoder_, dropped(wire.counts)).broken;
  if (const auto done = decode(frame, coded); !done.ok()) return done.error();
  out.verdict = check_frame(setup, *original, *decoder_, dropped(coded.counts));
  out.original = std::move(original->points);
  return Done{};
}

Result<Done> FrameEvaluator::judge_list(const SensorFrame& frame, const CodedFrame& coded,
                                        const CodedFrame& wire, EvaluatedFrame& out) {
  const StreamSetup& setup = file_.setup();
  if (const auto done = decode(frame, wire); !done.ok()) return done.error();
  out.wire_broken = check_list(setup, wire.list, decoder_->cloud()).broken;
  if (const auto done = decode(frame, coded); !done.ok()) return done.error();
  out.verdict = check_list(setup, coded.list, decoder_->cloud());
  out.original = coded.list.points;
  if (dropped(coded.counts) == 0) return Done{};
  for (std::size_t i = 0; i < coded.list.points.size(); ++i) {
    const PointFate fate = coded.list.fates[i];
    if (fate == PointFate::kCoded || fate == PointFate::kOnSurface)
      out.filtered.push_back(coded.list.points[i]);
  }
  return Done{};
}

nlohmann::ordered_json figures_of(const EvaluatedFrame& frame) {
  const PointCounts& counts = frame.counts;
  const std::uint64_t points = counts.input - counts.out_of_range;
  CloudDistance far;  // all zero: nothing to search where every bit came back
  if (!frame.verdict.identical) far = cloud_distance(frame.original, frame.decoded);
  const double max_m = frame.list ? far.hausdorff : frame.verdict.max_m;
  nlohmann::ordered_json out = {{"name", frame.name},
                                {"points_in", points},
                                {"points_out", frame.verdict.points_out},
                                {"points_dropped", dropped(counts)},
                                {"points_out_of_range", counts.out_of_range},
                                {"bytes", frame.report.bytes},
                                {"bits_per_point", bits_per_point(frame.report.bytes, points)},
                                {"wire_bytes", frame.wire_bytes},
                                {"slices", frame.wire_slices},
                                {"ratio_percent", ratio_percent(frame.report.bytes, points)},
                                {"d1_ab_mm", far.d1_ab * 1e3},
                                {"d1_ba_mm", far.d1_ba * 1e3},
                                {"d1_mm", far.d1 * 1e3},
                                {"d2_mm", far.d2 * 1e3},
                                {"max_mm", max_m * 1e3},
                                {"bound_utilisation", frame.verdict.utilisation},
                                {"encode_ms", frame.encode_ms},
                                {"decode_ms", frame.decode_ms},
                                {"surfaces", frame.report.surfaces},
                                {"corrections", frame.report.corrections},
                                {"outliers", counts.outliers},
                                {"outliers_dropped", counts.outliers_dropped},
                                {"on_surface", counts.on_surface},
                                {"off_surface", counts.off_surface},
                                {"off_surface_dropped", counts.off_surface_dropped}};
  if (frame.filtered.empty()) return out;
  // The paper's reference is the cloud after its filter: points that were dropped do not count.
  const CloudDistance kept = cloud_distance(frame.filtered, frame.decoded, {false, 16});
  out["filtered_points"] = frame.filtered.size();
  out["filtered_d1_ab_mm"] = kept.d1_ab * 1e3;
  out["filtered_d1_ba_mm"] = kept.d1_ba * 1e3;
  out["filtered_d1_mm"] = kept.d1 * 1e3;
  out["filtered_max_mm"] = kept.hausdorff * 1e3;
  return out;
}

}  // namespace planecast
