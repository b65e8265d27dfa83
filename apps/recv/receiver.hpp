// planecast-recv from its options to its exit code.
#pragma once

#include "apps/common/exit_codes.hpp"
#include "apps/common/options.hpp"
#include "apps/recv/recv_options.hpp"

namespace planecast {

/// Runs until a signal, --frames or --timeout ends it. Talks on standard error; the table of
/// --stats goes to standard output.
ExitCode run_receiver(const RecvOptions& options, const CodecOptions& codec);

}  // namespace planecast
