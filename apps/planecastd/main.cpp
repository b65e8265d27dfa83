// planecastd: streams depth frames and organised clouds over LCM, coded by their surfaces.
#include <CLI/CLI.hpp>
#include <string>

#include "apps/common/command_line.hpp"
#include "apps/planecastd/daemon.hpp"

namespace {

void add_daemon_options(CLI::App& app, planecast::DaemonOptions& daemon) {
  app.add_option("inputs", daemon.inputs,
                 "depth images, organised clouds or a folder of them, sim:room[:FRAMES], or\n"
                 "lcm:CHANNEL (organised drake.lcmt_point_cloud)");
  constexpr const char* kGroup = "Daemon";
  app.add_option("--stream", daemon.stream,
                 "Number of this stream, 0 to 255; daemons on one channel each take\n"
                 "their own. Default: 0")
      ->option_text("N")
      ->check(CLI::Range(0, 255))
      ->group(kGroup);
  app.add_option("--preload", daemon.preload,
                 "Inputs of up to N frames are decoded into memory before the start,\n"
                 "others are read as they are sent. Default: 300, up to 512 MiB")
      ->option_text("N")
      ->group(kGroup);
  app.add_flag("--wait", daemon.wait,
               "Replay without loss: wait for room instead of dropping frames")
      ->group(kGroup);
  app.add_option("--status", daemon.status_file, "Append a line of key=value once a second to FILE")
      ->option_text("FILE")
      ->group(kGroup);
  app.add_flag("--print-memory", daemon.print_memory,
               "Print how many bytes are taken for frames, by whom, and end")
      ->group(kGroup);
  planecast::add_realtime_options(app, daemon.realtime);
}

}  // namespace

int main(int argc, char** argv) {
  CLI::App app{
      "planecastd sends depth frames over LCM as the surfaces they lie on; planecast-recv\n"
      "regenerates the clouds. Every point stays within the bound you name (--tolerance).\n\n"
      "Examples:\n"
      "  planecastd sim:room --repeat 0\n"
      "  planecastd depth/ --camera 525,525,319.5,239.5 --noise kinect1 --rate 30\n"
      "  planecastd lcm:DRAKE_POINT_CLOUD_front --stream 1 --tolerance 10mm",
      "planecastd"};
  app.footer(planecast::kExitCodesHelp);
  planecast::CodecOptions options;
  planecast::DaemonOptions daemon;
  add_daemon_options(app, daemon);
  planecast::add_codec_options(app, options);
  if (const auto code = planecast::parse_command_line(app, argc, argv, options))
    return planecast::to_int(*code);
  daemon.preload_given = app.get_option("--preload")->count() > 0;
  return planecast::to_int(planecast::run_daemon(daemon, options));
}
