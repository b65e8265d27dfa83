// planecast: encode, decode, measure, compare and inspect point clouds coded by their surfaces.
#include <fmt/core.h>

#include <CLI/CLI.hpp>

#include "apps/common/command_line.hpp"
#include "apps/planecast/commands.hpp"

namespace {

using planecast::CodecOptions;
using planecast::CommandArguments;
using planecast::ExitCode;

struct Command {
  const char* name;
  const char* help;
  ExitCode (*run)(const CommandArguments&, const CodecOptions&);
  bool takes_inputs;
  CLI::App* app = nullptr;
};

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "planecast codes depth frames and point clouds by the surfaces they lie on.\n"
      "Every point stays within the bound that you name (--tolerance).\n\n"
      "Examples:\n"
      "  planecast eval sim:room:10 --tolerance 10mm\n"
      "  planecast encode depth/ -o depth.plc --camera 525,525,319.5,239.5 --tolerance 2sigma "
      "--noise kinect1\n"
      "  planecast decode depth.plc -o clouds/"};
  app.footer(planecast::kExitCodesHelp);
  app.require_subcommand(1);
  CodecOptions options;
  CommandArguments arguments;
  Command commands[] = {
      {"encode", "encode frames into a .plc file", planecast::run_encode, true},
      {"decode", "decode a .plc file into ply, pcd, bin or depth png", planecast::run_decode, true},
      {"eval", "encode and decode in memory and print sizes, errors and times", planecast::run_eval,
       true},
      {"compare", "distances between two clouds, both ways", planecast::run_compare, true},
      {"info", "print what a .plc file holds, packet by packet", planecast::run_info, true},
      {"doctor", "check LCM, the multicast route, buffers and limits", planecast::run_doctor,
       false},
  };
  for (Command& command : commands) {
    command.app = app.add_subcommand(command.name, command.help);
    command.app->footer(planecast::kExitCodesHelp);
    if (command.takes_inputs) {
      command.app->add_option(
          "inputs", arguments.inputs,
          "files, folders or sim:room[:FRAMES] (compare: two clouds; decode, info: one .plc)");
    }
    if (command.run == planecast::run_encode || command.run == planecast::run_decode) {
      command.app
          ->add_option("-o,--output", arguments.output,
                       "where to write; a folder takes one file a frame")
          ->type_name("PATH");
    }
    if (command.run != planecast::run_encode && command.run != planecast::run_decode) {
      command.app->add_flag("--json", arguments.json, "print one JSON object on standard output");
    }
    if (command.run == planecast::run_compare) {
      command.app
          ->add_option("--max-error", arguments.max_error,
                       "exit with 5 when the largest distance exceeds this, e.g. 10mm")
          ->type_name("LENGTH");
    }
    planecast::add_codec_options(*command.app, options);
  }
  if (const auto code = planecast::parse_command_line(app, argc, argv, options))
    return planecast::to_int(*code);
  for (const Command& command : commands) {
    if (command.app->parsed()) return planecast::to_int(command.run(arguments, options));
  }
  return planecast::to_int(ExitCode::kUsage);
}
