// Runs a fuzz target without libFuzzer, in any build: every file given, and mutants of each, always
// the same ones. A fault ends the process; the input that did it is left in the current folder.
//   NAME_replay [--mutants N] FILE-OR-FOLDER...
#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <csignal>
#include <cstring>
#include <filesystem>
#include <span>
#include <string>
#include <vector>

#include "core/base/random.hpp"
#include "core/io/file_bytes.hpp"
#include "tests/fuzz/fuzz_target.hpp"

namespace {

using namespace planecast;
namespace fs = std::filesystem;
using Bytes = std::vector<std::uint8_t>;

constexpr std::size_t kMaxBytes = 1U << 16U;

const Bytes* current = nullptr;

// Only calls that are safe in a signal handler.
void on_fault(int signal) {
  const int file = ::creat("replay-fault.bin", 0644);
  if (file >= 0 && current != nullptr) (void)!::write(file, current->data(), current->size());
  std::signal(signal, SIG_DFL);
  std::raise(signal);
}

void run(const Bytes& input) {
  current = &input;
  LLVMFuzzerTestOneInput(input.data(), input.size());
}

// One small change: what most often breaks a parser is a wrong byte, a length, a cut or a repeat.
void mutate(Bytes& bytes, const Bytes& other, Pcg32& random) {
  const auto below = [&](std::size_t n) {
    return static_cast<std::ptrdiff_t>(random.below(static_cast<std::uint32_t>(n)));
  };
  if (bytes.empty()) bytes.push_back(0);
  const std::ptrdiff_t at = below(bytes.size());
  const std::ptrdiff_t length = 1 + below(std::min<std::size_t>(bytes.size() - at, 64));
  switch (random.below(7)) {
    case 0:
      bytes[at] ^= static_cast<std::uint8_t>(1U << random.below(8));
      break;
    case 1: {
      constexpr std::uint8_t kOdd[] = {0, 1, 0x7f, 0x80, 0xff, '-', '9', ' ', '\n'};
      std::fill_n(bytes.begin() + at, std::min<std::ptrdiff_t>(length, 8),
                  kOdd[below(sizeof kOdd)]);
      break;
    }
    case 2:
      bytes[at] = static_cast<std::uint8_t>(random.next());
      break;
    case 3:
      bytes.erase(bytes.begin() + at, bytes.begin() + at + length);
      break;
    case 4: {
      const Bytes part(bytes.begin() + at, bytes.begin() + at + length);
      bytes.insert(bytes.begin() + below(bytes.size()), part.begin(), part.end());
      break;
    }
    case 5:
      bytes.resize(static_cast<std::size_t>(at));
      break;
    default:
      if (other.empty()) break;
      const std::ptrdiff_t from = below(other.size());
      const std::ptrdiff_t count = std::min<std::ptrdiff_t>(length, std::ssize(other) - from);
      bytes.insert(bytes.begin() + at, other.begin() + from, other.begin() + from + count);
  }
  if (bytes.size() > kMaxBytes) bytes.resize(kMaxBytes);
}

std::vector<Bytes> inputs(std::span<char*> places) {
  std::vector<fs::path> paths;
  for (const fs::path place : places) {
    if (fs::is_directory(place)) {
      for (const auto& entry : fs::directory_iterator(place))
        if (entry.is_regular_file()) paths.push_back(entry.path());
    } else {
      paths.push_back(place);
    }
  }
  std::sort(paths.begin(), paths.end());
  std::vector<Bytes> out;
  for (const fs::path& path : paths) {
    auto bytes = read_file_bytes(path);
    test::claim(bytes.ok(), path.c_str());
    out.push_back(std::move(*bytes));
  }
  return out;
}

}  // namespace

int main(int argc, char** argv) {
  std::span<char*> places(argv + 1, static_cast<std::size_t>(argc - 1));
  std::uint32_t mutants = 0;
  if (places.size() >= 2 && std::strcmp(places[0], "--mutants") == 0) {
    mutants = static_cast<std::uint32_t>(std::stoul(places[1]));
    places = places.subspan(2);
  }
  for (const int signal : {SIGABRT, SIGSEGV, SIGBUS, SIGFPE, SIGILL}) std::signal(signal, on_fault);
  const std::vector<Bytes> corpus = inputs(places);
  if (corpus.empty()) {
    std::fprintf(stderr, "usage: replay [--mutants N] FILE-OR-FOLDER... (nothing was found)\n");
    return 2;
  }
  for (const Bytes& input : corpus) run(input);
  for (std::size_t i = 0; i < corpus.size(); ++i) {
    Pcg32 random(i + 1);
    for (std::uint32_t k = 0; k < mutants; ++k) {
      Bytes input = corpus[i];
      const Bytes& other = corpus[random.below(static_cast<std::uint32_t>(corpus.size()))];
      for (std::uint32_t changes = 1 + random.below(4); changes > 0; --changes)
        mutate(input, other, random);
      run(input);
    }
  }
  std::printf("%zu inputs and %u mutants of each: no fault\n", corpus.size(), mutants);
  return 0;
}
