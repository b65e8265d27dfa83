// Reads flags, environment and configuration file in that order of strength, and says what is wrong
// in words that name the option, the place and the nearest known name.
#pragma once

#include <iosfwd>
#include <optional>

#include "apps/common/exit_codes.hpp"
#include "apps/common/options.hpp"

namespace CLI {
class App;
}

namespace planecast {

/// Parses the command line into whatever was bound to `app` and its subcommands.
/// An option without a flag takes PLANECAST_<NAME> from the environment (PLANECAST_OFF_SURFACE;
/// --lcm-url then LCM_DEFAULT_URL too), else the key of the file that --config names. Positionals
/// may stand in the file as well, so make none of them required(). Finishes and checks `options`.
/// Returns the exit code to leave with when there is nothing to run: help was printed to `out`, or
/// a mistake explained on `talk`.
std::optional<ExitCode> parse_command_line(CLI::App& app, int argc, const char* const* argv,
                                           CodecOptions& options, std::ostream& out,
                                           std::ostream& talk);

/// The same on standard output and standard error.
std::optional<ExitCode> parse_command_line(CLI::App& app, int argc, const char* const* argv,
                                           CodecOptions& options);

}  // namespace planecast
