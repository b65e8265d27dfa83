#include "bench/latency_svg.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

namespace planecast::bench {
namespace {

constexpr double kLeft = 60, kTop = 30, kWide = 620, kHigh = 360;
constexpr double kLeastMs = 0.01, kMostMs = 1000;
constexpr std::array kColours = {"#4477aa", "#ee6677", "#228833", "#ccbb44", "#66ccee", "#aa3377",
                                 "#222222", "#ee7733", "#0077bb", "#33bbee", "#009988", "#cc3311"};
constexpr std::array kPercents = {0.0, 50.0, 90.0, 99.0, 99.9, 99.99};

// 0 %, 90 %, 99 %, 99.9 % ... are equally far apart.
double x_of(double percent) {
  return kLeft + kWide * std::min(1.0, -std::log10(1 - percent / 100) / 4);
}

double y_of(double ms) {
  const double part =
      std::log10(std::clamp(ms, kLeastMs, kMostMs) / kLeastMs) / std::log10(kMostMs / kLeastMs);
  return kTop + kHigh * (1 - part);
}

std::string curve(const Step& step, const char* colour, bool dashed) {
  std::string points;
  for (double nines = 0; nines <= 4; nines += 0.05) {
    const double percent = 100 * (1 - std::pow(10, -nines));
    points += fmt::format("{:.1f},{:.1f} ", x_of(percent),
                          y_of(static_cast<double>(step.at(percent)) * 1e-6));
  }
  return fmt::format("<polyline fill='none' stroke='{}' stroke-width='1.5'{} points='{}'/>\n",
                     colour, dashed ? " stroke-dasharray='4 3'" : "", points);
}

std::string axes() {
  std::string out;
  for (double ms = kLeastMs; ms <= kMostMs * 1.01; ms *= 10) {
    out += fmt::format(
        "<line x1='{}' x2='{}' y1='{:.1f}' y2='{:.1f}' stroke='#ddd'/>"
        "<text x='{}' y='{:.1f}' text-anchor='end'>{:g}</text>\n",
        kLeft, kLeft + kWide, y_of(ms), y_of(ms), kLeft - 6, y_of(ms) + 4, ms);
  }
  for (const double percent : kPercents) {
    out += fmt::format(
        "<line x1='{0:.1f}' x2='{0:.1f}' y1='{1}' y2='{2}' stroke='#ddd'/>"
        "<text x='{0:.1f}' y='{3}' text-anchor='middle'>{4:g} %</text>\n",
        x_of(percent), kTop, kTop + kHigh, kTop + kHigh + 18, percent);
  }
  return out;
}

}  // namespace

std::string latency_svg(const std::vector<LatencyResult>& results) {
  std::string out = fmt::format(
      "<svg xmlns='http://www.w3.org/2000/svg' width='960' height='440' font-family='sans-serif' "
      "font-size='12'>\n<rect width='100%' height='100%' fill='white'/>\n<text x='{}' y='18'>frame "
      "in memory to cloud readable, ms, by percentile</text>\n",
      kLeft);
  out += axes();
  double y = kTop + 10;
  const auto entry = [&](const std::string& text, const char* colour) {
    out += fmt::format("<text x='{}' y='{}' fill='{}'>{}</text>\n", kLeft + kWide + 20, y, colour,
                       text);
    y += 18;
  };
  for (std::size_t i = 0; i < results.size(); ++i) {
    const LatencyResult& result = results[i];
    const char* colour = kColours[i % kColours.size()];
    out += curve(result.steps.back(), colour, false);
    entry(fmt::format("{:g} Hz, {}, {}", result.plan.rate_hz,
                      result.plan.lcm ? "LCM loopback" : "in process",
                      result.plan.loaded ? "one core busy" : "idle"),
          colour);
  }
  if (!results.empty()) {
    out += curve(results[0].timer, "#777777", true);
    entry("dashed: lateness of a timer", "#777777");
  }
  return out + "</svg>\n";
}

}  // namespace planecast::bench
