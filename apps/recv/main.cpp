// planecast-recv: receives streams of planecastd and regenerates their clouds.
#include <fmt/format.h>

#include <CLI/CLI.hpp>

#include "apps/common/command_line.hpp"
#include "apps/recv/receiver.hpp"

int main(int argc, char** argv) {
  CLI::App app{
      "planecast-recv receives what planecastd sends and regenerates the clouds, point by "
      "point.\n\n"
      "Examples:\n"
      "  planecast-recv --stats\n"
      "  planecast-recv --out clouds --format pcd --frames 100\n"
      "  planecast-recv --publish-plain front\n"
      "  planecast-recv --reference depth/ --camera 525,525,319.5,239.5 --noise kinect1 "
      "--frames 300 --picture result.png",
      "planecast-recv"};
  app.footer(planecast::kExitCodesHelp);
  planecast::RecvOptions recv;
  planecast::CodecOptions codec;
  planecast::add_recv_options(app, recv);
  planecast::add_codec_options(app, codec);
  if (const auto code = planecast::parse_command_line(app, argc, argv, codec))
    return planecast::to_int(*code);
  if (const auto checked = planecast::check_recv_options(recv); !checked.ok()) {
    fmt::print(stderr, "planecast-recv: {}\n", checked.error().message);
    return planecast::to_int(planecast::ExitCode::kUsage);
  }
  return planecast::to_int(planecast::run_receiver(recv, codec));
}
