#include "core/io/natural_order.hpp"

#include <cstddef>

namespace planecast {
namespace {

bool is_digit(char c) noexcept {
  return c >= '0' && c <= '9';
}

// Takes the digit run at the front of `text`, without its leading zeros.
std::string_view take_digits(std::string_view& text) noexcept {
  std::size_t end = 0;
  while (end < text.size() && is_digit(text[end])) ++end;
  std::string_view run = text.substr(0, end);
  text.remove_prefix(end);
  while (run.size() > 1 && run.front() == '0') run.remove_prefix(1);
  return run;
}

}  // namespace

bool natural_less(std::string_view a, std::string_view b) noexcept {
  const std::string_view whole_a = a;
  const std::string_view whole_b = b;
  while (!a.empty() && !b.empty()) {
    if (is_digit(a.front()) && is_digit(b.front())) {
      const std::string_view run_a = take_digits(a);
      const std::string_view run_b = take_digits(b);
      if (run_a.size() != run_b.size()) return run_a.size() < run_b.size();
      if (const int order = run_a.compare(run_b); order != 0) return order < 0;
      continue;
    }
    if (a.front() != b.front()) {
      return static_cast<unsigned char>(a.front()) < static_cast<unsigned char>(b.front());
    }
    a.remove_prefix(1);
    b.remove_prefix(1);
  }
  if (a.empty() != b.empty()) return a.empty();
  if (whole_a.size() != whole_b.size()) return whole_a.size() < whole_b.size();
  return whole_a < whole_b;
}

}  // namespace planecast
