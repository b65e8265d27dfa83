// The daemon: source thread -> pipeline -> sender thread -> publisher thread, in memory taken once;
// status once a second, and a balance at the end that accounts for every frame.
#pragma once

#include "apps/common/exit_codes.hpp"
#include "apps/common/options.hpp"
#include "apps/planecastd/daemon_options.hpp"

namespace planecast {

/// Streams the input until it ends or a signal comes, then drains, flushes and prints the balance
/// on standard error. With print_memory only prints the memory plan on standard output. Blocks
/// SIGINT, SIGTERM and SIGHUP for good: for main().
ExitCode run_daemon(const DaemonOptions& daemon, const CodecOptions& options);

}  // namespace planecast
