// The sub-commands of planecast; each parses its own arguments' meaning, runs, and returns the
// process's exit code. Data go to standard output, talk to standard error.
#pragma once

#include <string>
#include <vector>

#include "apps/common/exit_codes.hpp"
#include "apps/common/options.hpp"

namespace planecast {

struct CommandArguments {
  std::vector<std::string> inputs;
  std::string output;
  std::string format;  ///< decode: "" or an extension without its dot
  bool json = false;
  std::string max_error;  ///< compare: "" or a length
};

ExitCode run_encode(const CommandArguments& arguments, const CodecOptions& options);
ExitCode run_decode(const CommandArguments& arguments, const CodecOptions& options);
ExitCode run_eval(const CommandArguments& arguments, const CodecOptions& options);
ExitCode run_compare(const CommandArguments& arguments, const CodecOptions& options);
ExitCode run_info(const CommandArguments& arguments, const CodecOptions& options);
ExitCode run_doctor(const CommandArguments& arguments, const CodecOptions& options);

/// Prints "planecast: <message>" on standard error and returns the exit code of the status.
ExitCode complain(const Error& error);

/// Prints sentences for the user on standard error, one a line.
void tell(const std::vector<std::string>& notes);

}  // namespace planecast
