// A program of ours under the guard of tests/support/guard_preload.cpp, and what the guard wrote.
#pragma once

#include <unistd.h>

#include <map>
#include <memory>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "tests/system/planecastd/network/child.hpp"

namespace planecast::test {

/// The threads that touch frames and are there from start to end.
inline constexpr const char* kDaemonThreads = "source,filter,segment,fit,pack,sender,publisher";
inline constexpr const char* kReceiverThreads = "subscriber,receive,unpack2";
/// Helps to pack depth frames.
inline constexpr const char* kPackHelper = ",pack2";

/// The words of a command line, and those that follow.
using Words = std::vector<std::string>;

inline Words operator+(Words a, const Words& b) {
  a.insert(a.end(), b.begin(), b.end());
  return a;
}

/// Counts of one thread by name: "allocations", "writes", "minor_faults", ...
using ThreadCounts = std::map<std::string, long long>;

struct GuardReport {
  std::map<std::string, ThreadCounts> threads;
  long long mapped = -1;  ///< by the program itself [bytes]
  std::string offender;   ///< the first one with its backtrace
};

class Guarded {
 public:
  Guarded(std::vector<std::string> command, const std::string& threads,
          const std::string& plant = "")
      : report_("guard" + std::to_string(next_++)) {
    std::vector<std::string> words = {
        "env", "LD_PRELOAD=" GUARD_PRELOAD, "PLANECAST_GUARD_REPORT=" + report_.path(),
        "PLANECAST_GUARD_THREADS=" + threads, "PLANECAST_GUARD_PLANT=" + plant};
    words.insert(words.end(), command.begin(), command.end());
    child_ = std::make_unique<Child>(words);
  }

  Child& child() { return *child_; }

  /// After its end.
  GuardReport report() const {
    GuardReport out;
    std::istringstream lines(report_.text());
    for (std::string line; std::getline(lines, line);) {
      std::istringstream words(line);
      std::string first, name, key;
      words >> first;
      long long count = 0;
      if (first == "thread" && words >> name) {
        while (words >> key >> count) out.threads[name][key] += count;
      } else if (first == "mapped") {
        words >> out.mapped;
      } else {
        out.offender += line + "\n";
      }
    }
    return out;
  }

 private:
  static inline int next_ = 0;
  OwnFile report_;
  std::unique_ptr<Child> child_;
};

}  // namespace planecast::test
