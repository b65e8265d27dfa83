// planecast encode: frames into one .plc file, which appears whole or not at all.
#include <fmt/core.h>

#include <filesystem>

#include "apps/common/live_line.hpp"
#include "apps/planecast/commands.hpp"
#include "apps/planecast/output_file.hpp"
#include "apps/planecast/stream_coder.hpp"
#include "core/io/file_bytes.hpp"
#include "core/metrics/compression.hpp"
#include "core/wire/plc_format.hpp"
#include "transport/envelope.hpp"

namespace planecast {
namespace {

struct EncodedTotals {
  std::uint64_t frames = 0, points = 0, kept = 0, surfaces = 0;
};

Result<Done> check_output(const std::string& output) {
  if (output.empty()) return Error{Status::kUsage, "encode: name the file to write, -o OUT.plc"};
  if (std::filesystem::path(output).extension() != ".plc") {
    return Error{Status::kUsage, "-o " + output +
                                     ": encode writes .plc files; end the name in .plc, or use "
                                     "planecast decode for other formats"};
  }
  return Done{};
}

Error write_error(const SensorFrame& frame, Status status) {
  return {status, fmt::format("{}: its packets do not fit a .plc file ({})", frame.name,
                              to_string(status))};
}

Result<Done> add_frame(StreamCoder& coder, const SensorFrame& frame, PlcWriter& writer,
                       EncodedTotals& totals) {
  bool fresh = false;
  const auto coded = coder.encode(frame, fresh);
  if (!coded.ok()) return coded.error();
  if (fresh) {
    const Status status = writer.add_packet(coder.codec().key_packet(frame));
    if (status != Status::kOk) return write_error(frame, status);
  }
  for (const auto& packet : coded->packets) {
    const Status status = writer.add_packet(packet);
    if (status != Status::kOk) return write_error(frame, status);
  }
  ++totals.frames;
  totals.points += coded->counts.input - coded->counts.out_of_range;
  totals.kept += coded->counts.kept;
  totals.surfaces += coded->report.surfaces;
  return Done{};
}

Result<Done> encode_all(FrameReader& reader, StreamCoder& coder, PlcWriter& writer,
                        EncodedTotals& totals) {
  const bool show = terminal_columns(stderr) > 0;
  LiveLine line(stderr, LiveLine::Style::kReplace);
  for (;;) {
    SensorFrame frame;
    const auto got = reader.next(frame);
    if (!got.ok()) return got.error();
    if (!*got) return Done{};
    if (const auto done = add_frame(coder, frame, writer, totals); !done.ok()) return done.error();
    if (show && line.due())
      line.print(fmt::format("{} of {} frames", totals.frames, reader.count()));
  }
}

}  // namespace

ExitCode run_encode(const CommandArguments& arguments, const CodecOptions& options) {
  if (const auto fine = check_output(arguments.output); !fine.ok()) return complain(fine.error());
  auto reader = FrameReader::open(arguments.inputs, options);
  if (!reader.ok()) return complain(reader.error());
  // The file form has slices as large as they come; --slice-bytes asks for those of the wire.
  const std::size_t slice_bytes =
      options.is_given("slice-bytes") ? max_packet_bytes(options.slice_bytes) : kFileSliceBytes;
  StreamCoder coder(options, reader->sensor(), slice_bytes, true);
  std::vector<std::uint8_t> bytes;
  PlcWriter writer(bytes);
  EncodedTotals totals;
  if (const auto done = encode_all(*reader, coder, writer, totals); !done.ok())
    return complain(done.error());
  writer.finish();
  const auto written = write_whole_file(
      arguments.output, [&](const auto& path) { return write_file_bytes(path, bytes); });
  if (!written.ok()) return complain(written.error());
  fmt::print(stderr, "{}: {} frames, {} points of {}, {} ({:.3f} bits a point)\n", arguments.output,
             totals.frames, with_thousands(totals.kept), with_thousands(totals.points),
             human_bytes(static_cast<double>(bytes.size())),
             bits_per_point(bytes.size(), totals.points));
  return ExitCode::kDone;
}

}  // namespace planecast
