// planecast doctor: can this host carry the streams, and what would mend it.
#include "transport/doctor.hpp"

#include <fmt/core.h>

#include <nlohmann/json.hpp>

#include "apps/planecast/commands.hpp"
#include "transport/lcm_url.hpp"

namespace planecast {
namespace {

const char* level_name(DoctorLevel level) {
  return level == DoctorLevel::kOk ? "ok" : level == DoctorLevel::kWarn ? "warn" : "FAIL";
}

void print_json(const std::vector<DoctorLine>& lines, bool usable) {
  nlohmann::ordered_json out = {{"usable", usable}, {"checks", nlohmann::ordered_json::array()}};
  for (const DoctorLine& line : lines) {
    out["checks"].push_back({{"level", level_name(line.level)},
                             {"subject", line.subject},
                             {"text", line.text},
                             {"mend", line.mend}});
  }
  fmt::print("{}\n", out.dump(2));
}

void print_table(const std::vector<DoctorLine>& lines) {
  for (const DoctorLine& line : lines) {
    fmt::print("{:<5} {:<18} {}\n", level_name(line.level), line.subject, line.text);
    if (!line.mend.empty()) fmt::print("{:<5} {:<18} mend: {}\n", "", "", line.mend);
  }
}

}  // namespace

ExitCode run_doctor(const CommandArguments& arguments, const CodecOptions& options) {
  const auto url = options.lcm_url.empty() ? default_lcm_url() : parse_lcm_url(options.lcm_url);
  if (!url.ok()) return complain({Status::kUsage, "--lcm-url: " + url.error().message});
  const auto lines = run_doctor(options.lcm_url);
  const Status verdict = doctor_verdict(lines);
  if (arguments.json) {
    print_json(lines, verdict == Status::kOk);
  } else {
    print_table(lines);
  }
  return exit_code(verdict);
}

}  // namespace planecast
