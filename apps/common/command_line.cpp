#include "apps/common/command_line.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <iostream>
#include <string>
#include <vector>

#include "apps/common/config_file.hpp"
#include "apps/common/suggestion.hpp"

namespace planecast {
namespace {

/// The innermost subcommand that was named, or the app itself.
CLI::App& innermost(CLI::App& app) {
  const auto parsed = app.get_subcommands();
  return parsed.empty() ? app : innermost(*parsed.front());
}

/// "planecast encode": what the user typed to get here.
std::string full_name(const CLI::App& app) {
  const CLI::App* parent = app.get_parent();
  return parent == nullptr ? app.get_name() : full_name(*parent) + " " + app.get_name();
}

bool settable(const CLI::Option& option) {
  const std::string name = option.get_single_name();
  return !name.empty() && name != "help" && name != "help-all" && name != "version" &&
         name != "config";
}

std::vector<CLI::Option*> settable_options(CLI::App& app) {
  std::vector<CLI::Option*> kept;
  for (CLI::Option* option : app.get_options()) {
    if (settable(*option)) kept.push_back(option);
  }
  return kept;
}

/// Names a user may have meant: options with their dashes, or subcommands.
std::vector<std::string> known_names(CLI::App& app, bool options) {
  std::vector<std::string> names;
  if (options) {
    for (const CLI::Option* option : app.get_options()) {
      for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
    }
  } else {
    for (const CLI::App* sub : app.get_subcommands({})) names.push_back(sub->get_name());
  }
  return names;
}

/// What CLI11 could not place, in words; its own message when everything had a place.
std::string explain(CLI::App& app, const CLI::ParseError& error) {
  CLI::App& active = innermost(app);
  for (const std::string& argument : app.remaining(true)) {
    if (argument.empty() || argument == "--") continue;
    const bool option = argument.front() == '-' && argument.size() > 1;
    const std::string written = argument.substr(0, argument.find('='));
    const std::string kind = option                               ? "unknown option"
                             : active.get_subcommands({}).empty() ? "unexpected argument"
                                                                  : "unknown command";
    return kind + " '" + written + "'" + did_you_mean(written, known_names(active, option));
  }
  return error.what();
}

/// Hands texts to an option as if they had stood on the command line. Throws CLI::ParseError.
void feed(CLI::Option& option, const std::vector<std::string>& values) {
  const bool flag = option.get_expected_min() == 0 && option.get_expected_max() <= 1;
  const bool many = option.get_items_expected_max() > 1;
  if (flag) {
    option.add_result(option.get_flag_value(option.get_single_name(), values.front()));
  } else if (many) {
    option.add_result(values);
  } else {
    std::string joined;  // camera = [525, 525, 320, 240] is --camera 525,525,320,240
    for (const std::string& value : values) joined += (joined.empty() ? "" : ",") + value;
    option.add_result(joined);
  }
  option.run_callback();
}

/// The variable's name and content; empty content counts as not set.
struct Variable {
  std::string name;
  std::string value;
};

Variable variable_of(const CLI::Option& option) {
  Variable found;
  found.name = "PLANECAST_";
  for (const char c : option.get_single_name()) {
    found.name += c == '-' ? '_' : static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  }
  const char* value = std::getenv(found.name.c_str());
  if ((value == nullptr || *value == '\0') && option.check_lname("lcm-url")) {
    found.name = "LCM_DEFAULT_URL";
    value = std::getenv(found.name.c_str());
  }
  if (value != nullptr) found.value = value;
  return found;
}

Error usage_error(std::string message) {
  return {Status::kUsage, std::move(message)};
}

/// Sets what no flag has set from the environment.
Result<Done> apply_environment(CLI::App& app) {
  for (CLI::Option* option : settable_options(app)) {
    if (option->count() > 0) continue;
    const Variable variable = variable_of(*option);
    if (variable.value.empty()) continue;
    try {
      feed(*option, {variable.value});
    } catch (const CLI::ParseError& error) {
      return usage_error("environment variable " + variable.name + ": " + error.what());
    }
  }
  return Done{};
}

/// The file --config or PLANECAST_CONFIG names, or "".
std::string config_path(CLI::App& app) {
  const CLI::Option* option = app.get_option_no_throw("--config");
  if (option == nullptr) return {};
  if (option->count() > 0) return option->results().back();
  return variable_of(*option).value;
}

/// Sets what neither a flag nor the environment has set from the file.
Result<Done> apply_config_file(CLI::App& app) {
  const std::string path = config_path(app);
  if (path.empty()) return Done{};
  const Result<std::vector<ConfigEntry>> entries = read_config_file(path);
  if (!entries) return entries.error();
  std::vector<std::string> names;
  for (const CLI::Option* option : settable_options(app))
    names.push_back(option->get_single_name());
  const std::vector<CLI::Option*> options = settable_options(app);
  for (const ConfigEntry& entry : *entries) {
    const auto place = std::find(names.begin(), names.end(), entry.name);
    if (place == names.end()) {
      return usage_error(entry.place + ": unknown key '" + entry.name + "'" +
                         did_you_mean(entry.name, names));
    }
    CLI::Option& option = *options[static_cast<std::size_t>(place - names.begin())];
    if (option.count() > 0 || entry.values.empty()) continue;
    try {
      feed(option, entry.values);
    } catch (const CLI::ParseError& error) {
      return usage_error(entry.place + ": " + error.what());
    }
  }
  return Done{};
}

Result<Done> apply_lesser_sources(CLI::App& app, CodecOptions& options) {
  CLI::App& active = innermost(app);
  const Result<Done> environment = apply_environment(active);
  if (!environment) return environment;
  const Result<Done> file = apply_config_file(active);
  if (!file) return file;
  return finish_codec_options(options);
}

}  // namespace

std::optional<ExitCode> parse_command_line(CLI::App& app, int argc, const char* const* argv,
                                           CodecOptions& options, std::ostream& out,
                                           std::ostream& talk) {
  try {
    app.parse(argc, argv);
  } catch (const CLI::Success& help) {  // --help, --version
    app.exit(help, out, talk);
    return ExitCode::kDone;
  } catch (const CLI::ParseError& error) {
    const std::string name = full_name(innermost(app));
    talk << name << ": " << explain(app, error) << "\nSee '" << name << " --help'.\n";
    return ExitCode::kUsage;
  }
  const Result<Done> done = apply_lesser_sources(app, options);
  if (done) return std::nullopt;
  talk << full_name(innermost(app)) << ": " << done.error().message << "\n";
  return exit_code(done.error().status);
}

std::optional<ExitCode> parse_command_line(CLI::App& app, int argc, const char* const* argv,
                                           CodecOptions& options) {
  return parse_command_line(app, argc, argv, options, std::cout, std::cerr);
}

}  // namespace planecast
