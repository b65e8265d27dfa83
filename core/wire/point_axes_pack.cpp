#include "core/wire/point_axes_pack.hpp"

#include <algorithm>

namespace planecast {
namespace {

constexpr std::size_t kSamples = 8192;

std::uint32_t up_from(const GridPoint& p, std::size_t axis) noexcept {
  const std::int32_t value = axis == 0 ? p.x : (axis == 1 ? p.y : p.z);
  return static_cast<std::uint32_t>(value) ^ 0x80000000U;
}

// The pitch [Q16] of sorted values that lie within `off` of a lattice at least `least` wide, or 0.
// The pitch is drawn from ever longer runs, so that each index is certain before it is used.
std::uint64_t pitch_through(std::span<const std::uint32_t> values, std::uint32_t least,
                            std::uint32_t off) noexcept {
  std::uint64_t pitch = ~std::uint64_t{0};
  for (std::size_t i = 1; i < values.size(); ++i) {
    const std::uint64_t gap = values[i] - values[i - 1];
    if (gap <= 2 * std::uint64_t{off}) continue;
    if (gap <= least) return 0;
    pitch = std::min(pitch, gap);
  }
  if (pitch == ~std::uint64_t{0}) return 0;
  pitch <<= 16U;
  std::uint64_t steps = 0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const std::uint64_t gap = values[i] - values[i - 1];
    if (gap <= 2 * std::uint64_t{off}) continue;
    steps += ((gap << 16U) + pitch / 2) / pitch;
    const std::uint64_t length = values[i] - values.front();
    const std::uint64_t along = steps * pitch >> 16U;
    if ((along > length ? along - length : length - along) > 4 * off + (pitch >> 19U)) return 0;
    pitch = ((length << 16U) + steps / 2) / steps;
  }
  return pitch;
}

// Distance of the farthest point from its middle.
std::uint32_t reach_of(std::span<const GridPoint> points, std::size_t axis,
                       const FrameCells& cells) noexcept {
  std::uint32_t reach = 0;
  for (const GridPoint& p : points) {
    const std::uint32_t up = up_from(p, axis);
    const auto value = static_cast<std::int32_t>(up ^ 0x80000000U);
    const std::int64_t off = std::int64_t{cells.axes[axis].middle(cells.cell(axis, value))} - value;
    reach = std::max(reach, static_cast<std::uint32_t>(off < 0 ? -off : off));
  }
  return reach;
}

}  // namespace

void CellChooser::layout(Arena& arena) noexcept {
  sample_ = arena.take<std::uint32_t>(kSamples + 1);
}

bool CellChooser::find_lattice(std::span<const GridPoint> points, std::size_t axis,
                               std::uint32_t least_pitch, std::uint32_t most_off,
                               CellAxis& found) noexcept {
  const std::size_t stride = points.size() / kSamples + 1;
  std::size_t count = 0;
  sample_[count++] = found.base;  // the least coordinate of all
  for (std::size_t i = 0; i < points.size(); i += stride)
    sample_[count++] = up_from(points[i], axis);
  const auto values = sample_.first(count);
  std::sort(values.begin(), values.end());
  const std::uint64_t pitch = pitch_through(values, least_pitch, most_off);
  if (pitch <= std::uint64_t{least_pitch} << 16U || pitch > kMostPitch) return false;
  found.pitch = pitch;
  return true;
}

FrameCells CellChooser::choose(const PointCoding& coding,
                               std::span<const GridPoint> points) noexcept {
  FrameCells cells;
  const std::uint32_t half = cell_half(coding);
  for (std::size_t i = 0; i < 3; ++i) {
    std::uint32_t least = points.empty() ? 0 : ~0U;
    for (const GridPoint& p : points) least = std::min(least, up_from(p, i));
    cells.axes[i] = {least, pitch_of(half)};
    cells.reach[i] = half;
  }
  if (points.size() < 64) return cells;
  // A slice rounds its base, so that its middles may be one step off those of the frame.
  const std::uint32_t slack = coding.lossless() ? 0 : 1;
  const std::uint32_t most_off = coding.lossless() ? 0 : coding.tolerance / 16;
  std::uint64_t left = std::uint64_t{coding.tolerance} * coding.tolerance;
  unsigned others = 3;
  for (std::size_t i = 0; i < 3; ++i) {
    CellAxis axis = cells.axes[i];
    if (!find_lattice(points, i, 2 * half + 1, most_off, axis)) continue;
    if (coding.lossless() && (axis.pitch & 0xffffU) != 0) continue;
    FrameCells trial = cells;
    trial.axes[i] = axis;
    const std::uint64_t reach = reach_of(points, i, trial) + slack;
    if (reach > most_off + slack || reach * reach > left) continue;
    cells.axes[i] = axis;
    cells.own_pitch[i] = true;
    cells.reach[i] = static_cast<std::uint32_t>(reach);
    left -= reach * reach;
    --others;
  }
  if (others == 0 || others == 3) return cells;
  const std::uint32_t wider = floor_sqrt(left / others);
  for (std::size_t i = 0; i < 3; ++i) {
    if (cells.own_pitch[i]) continue;
    cells.axes[i].pitch = pitch_of(wider);
    cells.own_pitch[i] = wider != half;
    cells.reach[i] = wider;
  }
  return cells;
}

}  // namespace planecast
