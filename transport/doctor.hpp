// Looks whether this host can carry the streams: LCM, the multicast route, a message that comes
// back, buffers and limits; and says for each what would mend it.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/status.hpp"

namespace planecast {

enum class DoctorLevel : std::uint8_t { kOk, kWarn, kFail };

/// One finding.
struct DoctorLine {
  DoctorLevel level = DoctorLevel::kOk;
  std::string subject;  ///< "LCM URL", "multicast route", ...
  std::string text;     ///< what was found, with figures
  std::string mend;     ///< the command or change that mends it; empty when ok
};

/// Examines this host with `url` (empty: LCM_DEFAULT_URL, else the default). Sends two small
/// messages with ttl 0 to the group; takes up to about twelve seconds where multicast is blocked.
/// Never fails itself: what does not work is a line of kFail, and kWarn is worth mending.
std::vector<DoctorLine> run_doctor(std::string_view url);

/// kNetwork when any line is kFail, else kOk.
Status doctor_verdict(const std::vector<DoctorLine>& lines) noexcept;

}  // namespace planecast
