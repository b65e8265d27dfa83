#include "apps/recv/result_picture.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "apps/common/live_line.hpp"
#include "apps/common/options.hpp"
#include "apps/recv/caption.hpp"
#include "core/io/depth_png.hpp"

namespace planecast {
namespace {

constexpr Rgb kPaper{24, 24, 28};
constexpr Rgb kInk{235, 235, 235};
constexpr std::uint32_t kMargin = 6;    // [px] round words
constexpr std::uint32_t kBarPx = 200;   // [px] length of the colour scale
constexpr std::uint32_t kWidePx = 480;  // [px] from here on letters are drawn twice as large

std::uint32_t letters_for(std::uint32_t width) {
  return width >= kWidePx ? 2 : 1;
}

bool reading(float z) {
  return std::isfinite(z) && z > 0;
}

/// The picture with a strip of words above it.
Picture captioned(const Picture& picture, const std::string& words) {
  const std::uint32_t scale = letters_for(picture.width);
  const std::uint32_t strip = text_height(scale) + 2 * kMargin;
  Picture out(picture.width, picture.height + strip, kPaper);
  std::copy(picture.rgb.begin(), picture.rgb.end(),
            out.rgb.data() + std::size_t{strip} * picture.width * 3);
  draw_text(out, kMargin, kMargin, scale, kInk, words);
  return out;
}

Picture labels_of(const ResultViews& views) {
  Picture out = label_picture(views.labels, views.width, views.height, std::uint8_t{0});
  for (std::size_t i = 0; i < views.labels.size(); ++i) {
    if (!reading(views.regenerated[i])) out.set(i, {});
  }
  return out;
}

std::string words_of_labels(const ResultViews& views) {
  std::uint64_t on = 0, points = 0;
  std::uint8_t highest = 0;
  for (std::size_t i = 0; i < views.labels.size(); ++i) {
    points += reading(views.regenerated[i]);
    on += reading(views.regenerated[i]) && views.labels[i] != 0;
    highest = std::max(highest, views.labels[i]);
  }
  const double share =
      points == 0 ? 0 : 100.0 * static_cast<double>(on) / static_cast<double>(points);
  return fmt::format("Label map: {} surfaces, {:.0f} % of the points", highest, share);
}

std::string words_of_depth(const char* name, std::span<const float> z_m) {
  const auto points = static_cast<std::uint64_t>(std::count_if(z_m.begin(), z_m.end(), reading));
  return fmt::format("{}: {} points", name, with_thousands(points));
}

/// Colours from near to far, evenly in depth between their two figures, as the pictures use them.
std::uint32_t draw_scale(Picture& out, std::uint32_t y, std::uint32_t letters, ColourScale scale) {
  const std::string near_text = fmt::format("{:.2f} m", scale.near_m);
  const std::string far_text = fmt::format("{:.2f} m", scale.far_m);
  std::uint32_t x = kMargin;
  draw_text(out, x, y, letters, kInk, near_text);
  x += text_width(near_text, letters) + kMargin;
  std::vector<float> z_m(kBarPx);
  for (std::uint32_t i = 0; i < kBarPx; ++i)
    z_m[i] = static_cast<float>(scale.near_m + (scale.far_m - scale.near_m) * i / (kBarPx - 1));
  const Picture bar = depth_picture(z_m, kBarPx, 1, scale);
  for (std::uint32_t i = 0; i < kBarPx; ++i) {
    for (std::uint32_t row = 0; row < text_height(letters) && x + i < out.width; ++row)
      out.set(std::size_t{y + row} * out.width + x + i, bar.at(i, 0));
  }
  x += kBarPx + kMargin;
  draw_text(out, x, y, letters, kInk, far_text);
  return x + text_width(far_text, letters);
}

std::string words_of_bound(const StreamConfig& config) {
  if (config.kind == FrameKind::kRawCloud) return "0 (float coordinates as they are)";
  Tolerance tolerance{config.tolerance, config.tolerance_100nm * 1e-7};
  if (config.tolerance != ToleranceKind::kMetres) tolerance.value = config.sigmas_q16 / 65536.0;
  const bool sigmas =
      config.tolerance == ToleranceKind::kSigma || config.tolerance == ToleranceKind::kSurfaces;
  return to_string(tolerance) + (sigmas ? ", noise " + to_string(config.noise) : "");
}

}  // namespace

Picture draw_result(const ResultViews& views) {
  const ColourScale scale = scale_of(views.original.empty() ? views.regenerated : views.original);
  std::vector<Picture> panels;
  if (!views.original.empty()) {
    panels.push_back(captioned(depth_picture(views.original, views.width, views.height, scale),
                               words_of_depth("Original depth", views.original)));
  }
  if (!views.labels.empty()) panels.push_back(captioned(labels_of(views), words_of_labels(views)));
  panels.push_back(captioned(depth_picture(views.regenerated, views.width, views.height, scale),
                             words_of_depth("Regenerated depth", views.regenerated)));
  const Picture row = side_by_side(panels);
  const std::uint32_t letters = letters_for(views.width);
  Picture out(row.width, row.height + text_height(letters) + 2 * kMargin, kPaper);
  std::copy(row.rgb.begin(), row.rgb.end(), out.rgb.begin());
  const std::uint32_t end = draw_scale(out, row.height + kMargin, letters, scale);
  draw_text(out, end + 4 * kMargin, row.height + kMargin, letters, kInk, views.footer);
  return out;
}

Result<Done> write_result_picture(const SinkFrame& frame, const ReferenceCheck* reference,
                                  const std::filesystem::path& path) {
  if (frame.list()) {
    return Error{Status::kUsage, path.string() +
                                     ": the stream carries lists of points, which have no image; "
                                     "leave out --picture, or write them with --last FILE.ply"};
  }
  ResultViews views;
  views.width = frame.config.camera.width;
  views.height = frame.config.camera.height;
  std::vector<float> regenerated;
  if (frame.raw()) {
    for (const Point3f& p : frame.cloud.first(frame.pixels)) regenerated.push_back(p.z);
  } else {
    regenerated = metres(frame.depth.first(frame.pixels),
                         static_cast<double>(frame.config.camera.unit_pm) * 1e-12);
    views.labels = frame.labels.first(frame.pixels);
  }
  views.regenerated = regenerated;
  std::vector<float> original;
  if (reference != nullptr) original = reference->depth_m(frame.frame);
  if (original.size() == regenerated.size()) views.original = original;
  views.footer = fmt::format("frame {}   tolerance {}", frame.frame, words_of_bound(frame.config));
  const Picture picture = draw_result(views);
  return write_rgb_png(path, picture.width, picture.height, picture.rgb);
}

}  // namespace planecast
