// The exit codes of every command, and which Status leads to which.
#pragma once

#include "core/base/status.hpp"

namespace planecast {

/// What a command tells its caller. Written in --help and relied on by scripts: never renumbered.
enum class ExitCode : int {
  kDone = 0,
  kFailed = 1,         ///< failed while running
  kUsage = 2,          ///< wrong option or argument
  kBadInput = 3,       ///< input missing, unreadable or corrupt
  kNetwork = 4,        ///< LCM or the network not usable
  kBoundExceeded = 5,  ///< a point is further off than the bound
};

/// The exit code for a status that ends a command.
ExitCode exit_code(Status status) noexcept;

/// The number to return from main().
constexpr int to_int(ExitCode code) noexcept {
  return static_cast<int>(code);
}

/// The lines about exit codes that end every --help.
inline constexpr const char* kExitCodesHelp =
    "Exit codes: 0 done, 1 failed while running, 2 wrong usage, 3 unreadable or corrupt input,\n"
    "            4 LCM or network not usable, 5 a bound exceeded";

}  // namespace planecast
