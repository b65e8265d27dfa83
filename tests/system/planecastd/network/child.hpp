// A program run by a test, with what it prints kept; ended by its own id when the test ends.
#pragma once

#include <fcntl.h>
#include <signal.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>
#include <thread>
#include <vector>

namespace planecast::test {

/// A file of this test's own, removed at the end.
class OwnFile {
 public:
  explicit OwnFile(const std::string& name)
      : path_((std::filesystem::temp_directory_path() /
               ("planecast_" + std::to_string(::getpid()) + "_" + name))
                  .string()) {}
  ~OwnFile() { std::filesystem::remove(path_); }
  OwnFile(const OwnFile&) = delete;
  OwnFile& operator=(const OwnFile&) = delete;
  const std::string& path() const { return path_; }
  std::string text() const {
    std::ostringstream out;
    out << std::ifstream(path_).rdbuf();
    return out.str();
  }

 private:
  std::string path_;
};

class Child {
 public:
  explicit Child(std::vector<std::string> command)
      : out_("out" + std::to_string(next_)), talk_("talk" + std::to_string(next_)) {
    ++next_;
    std::vector<char*> arguments;
    for (std::string& word : command) arguments.push_back(word.data());
    arguments.push_back(nullptr);
    posix_spawn_file_actions_t files;
    posix_spawn_file_actions_init(&files);
    constexpr int kFlags = O_WRONLY | O_CREAT | O_TRUNC;
    posix_spawn_file_actions_addopen(&files, 1, out_.path().c_str(), kFlags, 0600);
    posix_spawn_file_actions_addopen(&files, 2, talk_.path().c_str(), kFlags, 0600);
    if (posix_spawnp(&pid_, arguments[0], &files, nullptr, arguments.data(), environ) != 0)
      pid_ = -1;
    posix_spawn_file_actions_destroy(&files);
  }
  ~Child() {
    if (pid_ <= 0) return;
    ::kill(pid_, SIGKILL);
    ::waitpid(pid_, nullptr, 0);
  }
  Child(const Child&) = delete;
  Child& operator=(const Child&) = delete;

  pid_t pid() const { return pid_; }

  void signal(int number) const {
    if (pid_ > 0) ::kill(pid_, number);
  }

  /// The exit code, 128 + signal when one ended it, -1 when it still runs after `limit`.
  int wait(std::chrono::seconds limit = std::chrono::seconds(250)) {
    const auto end = std::chrono::steady_clock::now() + limit;
    while (pid_ > 0 && std::chrono::steady_clock::now() < end) {
      int status = 0;
      if (::waitpid(pid_, &status, WNOHANG) == pid_) {
        pid_ = -1;
        return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
      }
      std::this_thread::sleep_for(std::chrono::milliseconds(5));
    }
    return -1;
  }

  std::string out() const { return out_.text(); }    ///< standard output so far
  std::string talk() const { return talk_.text(); }  ///< standard error so far

 private:
  static inline int next_ = 0;
  OwnFile out_, talk_;
  pid_t pid_ = -1;
};

/// The number behind `name` at the start of a line of a table, -1 without such a line.
inline long long number_after(const std::string& text, const std::string& name) {
  std::istringstream lines(text);
  for (std::string line; std::getline(lines, line);) {
    const std::size_t at = line.find_first_not_of(' ');
    if (at == std::string::npos || line.compare(at, name.size(), name) != 0) continue;
    return std::strtoll(line.c_str() + at + name.size(), nullptr, 10);
  }
  return -1;
}

}  // namespace planecast::test
