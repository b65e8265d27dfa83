// planecast: encode, decode, measure, compare and inspect point clouds coded by their surfaces.
#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <vector>

#include "apps/common/command_line.hpp"
#include "apps/planecast/commands.hpp"

namespace {

using planecast::CodecOptions;
using planecast::CommandArguments;
using planecast::ExitCode;

constexpr const char* kEvalHelp =
    "Figures (keys of --json): points_in: readings left by --range; points_out: points that come\n"
    "back; points_dropped: by --outliers drop and --off-surface drop; points_out_of_range: "
    "outside\n"
    "--range, not part of points_in. bytes: the frame in file form, packet headers included;\n"
    "bits_per_point: of bytes, by points_in; ratio_percent: bytes saved against 12 bytes a point.\n"
    "wire_bytes, slices: all LCM payload at --slice-bytes: slices, envelopes, and the frame's "
    "share\n"
    "of key packets, one each 0.25 s. d1_ab_mm: RMSE from each point in to its nearest point out,\n"
    "dropped ones included; d1_ba_mm: the other way; d1_mm: their mean; d2_mm: the same to "
    "planes;\n"
    "max_mm: largest distance of a point from its own reconstruction; bound_utilisation: the same\n"
    "over each point's bound (1 is the limit). encode_ms, decode_ms: CPU time of one thread, "
    "median\n"
    "of 5 after 2 warm-ups. Depth is checked count by count with --tolerance 0, raw clouds bit by\n"
    "bit; a broken promise exits with 5.\n";

constexpr const char* kEncodeHelp =
    "The file appears whole or not at all. Frames that do not follow the first one's camera or "
    "pose\n"
    "start a stream of their own in the file; frames of another size are refused (exit 3). Slices\n"
    "are as large as they come unless --slice-bytes asks for those of the wire.\n";

constexpr const char* kDecodeHelp =
    "The name's ending says the format: ply, pcd (keeps the grid and the sensor's pose), bin, "
    "xyz,\n"
    "png and raw (16-bit depth). Many frames need a folder (NAME_000000.ply ...; --format). A "
    "file\n"
    "that was cut gives its whole frames and exits with 0, naming what is missing; damaged "
    "packets\n"
    "leave holes or frames out, and exit with 3.\n";

constexpr const char* kInfoHelp =
    "Prints the file, each key packet and each slice: header fields, tile rectangle, surfaces "
    "with\n"
    "their coefficients (1/z = a x + b y + c on the rays (x, y, 1)), points and corrections.\n";

constexpr const char* kCompareHelp =
    "Prints d1 both ways (RMSE to the nearest point), d2 (point to plane), max (Hausdorff) and, "
    "for\n"
    "grids of one size, the same point by point. Depth images need --camera.\n";

struct Command {
  const char* name;
  const char* help;
  const char* footer;
  const char* inputs;  // what the positionals are; "" for none
  ExitCode (*run)(const CommandArguments&, const CodecOptions&);
  std::vector<std::string> options;  // shared options it has; empty: all
  CLI::App* app = nullptr;
};

std::vector<Command> commands() {
  const char* frames = "files, folders or sim:room[:FRAMES]";
  return {
      {"encode", "encode frames into a .plc file", kEncodeHelp, frames, planecast::run_encode, {}},
      {"decode",
       "decode a .plc file into ply, pcd, bin, xyz, depth png or raw",
       kDecodeHelp,
       "one .plc file",
       planecast::run_decode,
       {"config"}},
      {"eval",
       "encode and decode in memory and print sizes, errors and times",
       kEvalHelp,
       frames,
       planecast::run_eval,
       {}},
      {"compare",
       "distances between two clouds, both ways",
       kCompareHelp,
       "two clouds or depth images, A and B",
       planecast::run_compare,
       {"camera", "distortion", "size", "units", "config"}},
      {"info",
       "print what a .plc file holds, packet by packet",
       kInfoHelp,
       "one .plc file",
       planecast::run_info,
       {"config"}},
      {"doctor",
       "check LCM, the multicast route, buffers and limits",
       "",
       "",
       planecast::run_doctor,
       {"lcm-url", "config"}},
  };
}

// Takes away the shared options that would do nothing.
void keep_options(CLI::App& app, const std::vector<std::string>& kept) {
  if (kept.empty()) return;
  for (CLI::Option* option : app.get_options()) {
    const std::string name = option->get_single_name();
    if (name == "help" || std::find(kept.begin(), kept.end(), name) != kept.end()) continue;
    app.remove_option(option);
  }
}

void add_command(CLI::App& app, Command& command, CommandArguments& arguments,
                 CodecOptions& options) {
  CLI::App& sub = *app.add_subcommand(command.name, command.help);
  command.app = &sub;
  sub.footer(std::string(command.footer) + planecast::kExitCodesHelp);
  planecast::add_codec_options(sub, options);
  keep_options(sub, command.options);
  if (command.inputs[0] != '\0') sub.add_option("inputs", arguments.inputs, command.inputs);
  const bool writes = command.run == planecast::run_encode || command.run == planecast::run_decode;
  if (writes) {
    sub.add_option("-o,--output", arguments.output,
                   command.run == planecast::run_encode ? "the .plc file to write"
                                                        : "the file to write, or a folder")
        ->type_name("PATH");
  } else {
    sub.add_flag("--json", arguments.json, "print one JSON object on standard output");
  }
  if (command.run == planecast::run_decode) {
    sub.add_option("--format", arguments.format,
                   "of the files in a folder: ply (default), pcd, bin, png, raw, xyz or txt")
        ->type_name("EXT");
  }
  if (command.run == planecast::run_compare) {
    sub.add_option("--max-error", arguments.max_error,
                   "exit with 5 when the largest distance exceeds this, e.g. 10mm")
        ->type_name("LENGTH");
  }
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "planecast codes depth frames and point clouds by the surfaces they lie on.\n"
      "Every point stays within the bound that you name (--tolerance).\n\n"
      "Examples:\n"
      "  planecast eval sim:room:10 --tolerance 10mm\n"
      "  planecast encode depth/ -o depth.plc --camera 525,525,319.5,239.5 --tolerance 2sigma "
      "--noise kinect1\n"
      "  planecast decode depth.plc -o clouds/",
      "planecast"};
  app.footer(planecast::kExitCodesHelp);
  app.set_version_flag("--version", std::string("planecast ") + PLANECAST_VERSION);
  app.require_subcommand(1);
  CodecOptions options;
  CommandArguments arguments;
  std::vector<Command> all = commands();
  for (Command& command : all) add_command(app, command, arguments, options);
  if (const auto code = planecast::parse_command_line(app, argc, argv, options))
    return planecast::to_int(*code);
  for (const Command& command : all) {
    if (command.app->parsed()) return planecast::to_int(command.run(arguments, options));
  }
  return planecast::to_int(ExitCode::kUsage);
}
