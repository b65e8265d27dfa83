#include "core/wire/patch_pack.hpp"

#include <algorithm>
#include <cmath>

#include "core/wire/encode_io.hpp"
#include "core/wire/range_encoder.hpp"

namespace planecast {
namespace {

constexpr std::size_t kCoderEnd = 8;      // bytes that a coder holds back
constexpr std::size_t kMostWaiting = 64;  // a cut halves a side: twice 12, and one each

std::int32_t round_coefficient(double value) noexcept {
  const double limit = kMaxPatchCoefficient;
  return static_cast<std::int32_t>(std::lround(std::clamp(value, -limit, limit)));
}

void begin_slice(RangeEncoder& coder, PatchModels& models, std::uint32_t patches,
                 std::uint8_t height_log2) noexcept {
  models = PatchModels{};
  EncodeIo io{coder};
  io.raw(kPatchSliceBody, 2);
  PatchCode<EncodeIo>(io, models).head(patches, height_log2);
}

}  // namespace

/// A part of a draft, ready to be coded; its cells are in cells_.
struct PatchPacker::Part {
  Patch patch;
  Rect rect;  ///< cut to what is inside
};

struct PatchPacker::Job {
  std::span<const PatchDraft> drafts;
  std::span<const DraftCell> cells;
  const PatchPackOptions& options;
  std::size_t body;  ///< bytes of a slice behind its header
  std::span<std::uint8_t> out;
  std::span<SlicePlace> places;
  FrameReport& report;
  RangeEncoder coder{{}};
  PatchModels models = {};
};

Patch round_patch(const PatchDraft& draft, std::uint32_t i0, std::uint32_t j0, std::uint32_t i1,
                  std::uint32_t j1, std::uint8_t height_log2) noexcept {
  Patch p;
  p.degree = draft.degree;
  p.axis = draft.axis;
  p.pitch_log2 = draft.pitch_log2;
  p.height_log2 = height_log2;
  p.cell_u = draft.cell_u + static_cast<std::int32_t>(i0);
  p.cell_v = draft.cell_v + static_cast<std::int32_t>(j0);
  p.wide = i1 - i0;
  p.high = j1 - j0;
  const PatchSurface frame(p);
  const auto u = static_cast<double>(frame.centre_u()), v = static_cast<double>(frame.centre_v());
  const auto& c = draft.coefficients;
  const double slope = std::ldexp(1.0, static_cast<int>(frame.slope_shift()));
  const double curve = std::ldexp(1.0, static_cast<int>(frame.curve_shift() + 2 * frame.cut()));
  const double middle = c[0] + c[1] * u + c[2] * v + c[3] * u * u + c[4] * u * v + c[5] * v * v;
  p.coefficients[0] = round_coefficient(std::ldexp(middle, -static_cast<int>(height_log2)));
  p.coefficients[1] = round_coefficient((c[1] + 2 * c[3] * u + c[4] * v) * slope);
  p.coefficients[2] = round_coefficient((c[2] + 2 * c[5] * v + c[4] * u) * slope);
  for (std::size_t i = 3; i < 6; ++i) p.coefficients[i] = round_coefficient(c[i] * curve);
  for (std::size_t i = kPatchCoefficients[p.degree]; i < 6; ++i) p.coefficients[i] = 0;
  return p;
}

void PatchPacker::layout(Arena& arena) noexcept {
  cells_ = arena.take<std::uint8_t>(kMaxPatchCells);
  trial_ = arena.take<std::uint8_t>(std::size_t{1} << 17U);
  slice_ = arena.take<Rect>(kMaxPatchesInSlice);
  waiting_ = arena.take<Rect>(kMostWaiting);
}

Status PatchPacker::pack(std::span<const PatchDraft> drafts, std::span<const DraftCell> cells,
                         const PatchPackOptions& options, std::size_t slice_bytes,
                         std::span<std::uint8_t> out, std::span<SlicePlace> places,
                         FrameReport& report) noexcept {
  if (slice_bytes < kMinSliceBytes || options.height_log2 > kMaxHeightLog2)
    return Status::kBadConfig;
  const std::size_t body = std::min(slice_bytes - kPacketHeaderBytes, trial_.size());
  Job job{drafts, cells, options, body, out, places, report};
  in_slice_ = 0;
  for (std::uint32_t d = 0; d < drafts.size(); ++d) {
    const PatchDraft& draft = drafts[d];
    if (draft.first_cell + std::size_t{draft.wide} * draft.high > cells.size())
      return Status::kFieldRange;
    waits_ = 0;
    waiting_[waits_++] = {d, 0, 0, draft.wide, draft.high};
    while (waits_ > 0) {
      const Rect rect = waiting_[--waits_];
      if (const Status status = add(job, rect); status != Status::kOk) return status;
    }
  }
  return in_slice_ > 0 ? close(job) : Status::kOk;
}

/// Cuts the rectangle to its cells inside and counts; points 0 when nothing is to be sent.
PatchPacker::Part PatchPacker::make_part(const Job& job, const Rect& rect) noexcept {
  const PatchDraft& draft = job.drafts[rect.draft];
  Part part;
  Rect& r = part.rect = {rect.draft, rect.i1, rect.j1, rect.i0, rect.j0};
  std::uint32_t points = 0;
  for (std::uint32_t j = rect.j0; j < rect.j1; ++j) {
    const DraftCell* row = &job.cells[draft.first_cell + std::size_t{j} * draft.wide];
    for (std::uint32_t i = rect.i0; i < rect.i1; ++i) {
      if (!row[i].inside()) continue;
      points += row[i].count();
      r.i0 = std::min(r.i0, i);
      r.i1 = std::max(r.i1, i + 1);
      r.j0 = std::min(r.j0, j);
      r.j1 = j + 1;
    }
  }
  if (points == 0) return part;
  part.patch = round_patch(draft, r.i0, r.j0, r.i1, r.j1, job.options.height_log2);
  part.patch.points = points;
  return part;
}

/// Puts two halves of the rectangle, with about as many points each, on the list of those waiting.
bool PatchPacker::split(const Job& job, const Rect& rect) noexcept {
  const PatchDraft& draft = job.drafts[rect.draft];
  const std::uint32_t wide = rect.i1 - rect.i0, high = rect.j1 - rect.j0;
  if ((wide < 2 && high < 2) || waits_ + 2 > waiting_.size()) return false;
  const bool along_u = wide >= high;
  const std::uint32_t side = along_u ? wide : high;
  const auto count_line = [&](std::uint32_t n) {
    std::uint64_t count = 0;
    for (std::uint32_t k = 0; k < (along_u ? high : wide); ++k) {
      const std::uint32_t i = along_u ? rect.i0 + n : rect.i0 + k;
      const std::uint32_t j = along_u ? rect.j0 + k : rect.j0 + n;
      count += job.cells[draft.first_cell + std::size_t{j} * draft.wide + i].count();
    }
    return count;
  };
  std::uint64_t total = 0, before = 0;
  for (std::uint32_t n = 0; n < side; ++n) total += count_line(n);
  // Within the middle half, so that every cut halves the cells too, more or less.
  std::uint32_t cut = 0;
  const std::uint32_t least = std::max(1U, side / 4), most = side - std::max(1U, side / 4);
  for (; cut < most && (cut < least || 2 * before < total); ++cut) before += count_line(cut);
  Rect first = rect, second = rect;
  (along_u ? first.i1 : first.j1) = (along_u ? rect.i0 : rect.j0) + cut;
  (along_u ? second.i0 : second.j0) = (along_u ? rect.i0 : rect.j0) + cut;
  waiting_[waits_++] = second;
  waiting_[waits_++] = first;
  return true;
}

Status PatchPacker::add(Job& job, const Rect& rect) noexcept {
  const std::uint32_t wide = rect.i1 - rect.i0, high = rect.j1 - rect.j0;
  const unsigned pitch = job.drafts[rect.draft].pitch_log2;
  const bool in_range = wide <= kMaxPatchSide && high <= kMaxPatchSide &&
                        std::uint64_t{wide} * high <= kMaxPatchCells &&
                        (std::uint64_t{std::max(wide, high)} << pitch) <= kMaxPatchExtent;
  if (!in_range) return split(job, rect) ? Status::kOk : Status::kFieldRange;
  const Part part = make_part(job, rect);
  if (part.patch.points == 0) return Status::kOk;
  if (const Status status = check_patch(part.patch); status != Status::kOk) return status;
  if (in_slice_ == 0) {
    job.coder = RangeEncoder(trial_.first(job.body));
    begin_slice(job.coder, job.models, 1, job.options.height_log2);
  }
  code_part(job, part, job.coder);
  const bool fits = !job.coder.overflow() && job.coder.size() + kCoderEnd <= job.body;
  if (fits && in_slice_ < slice_.size()) {
    slice_[in_slice_++] = part.rect;
    return Status::kOk;
  }
  if (in_slice_ == 0) return split(job, part.rect) ? Status::kOk : Status::kTooLarge;
  // The slice ends before this part, which begins the next one.
  if (const Status status = close(job); status != Status::kOk) return status;
  return add(job, part.rect);
}

void PatchPacker::code_part(Job& job, const Part& part, RangeEncoder& coder) noexcept {
  const PatchDraft& draft = job.drafts[part.rect.draft];
  Patch patch = part.patch;
  for (std::uint32_t j = 0; j < patch.high; ++j) {
    const DraftCell* row =
        &job.cells[draft.first_cell + std::size_t{part.rect.j0 + j} * draft.wide];
    for (std::uint32_t i = 0; i < patch.wide; ++i)
      cells_[std::size_t{j} * patch.wide + i] = row[part.rect.i0 + i].inside() ? 1 : 0;
  }
  EncodeIo io{coder};
  PatchCode<EncodeIo> code(io, job.models);
  (void)code.fields(patch);
  (void)code.cells(patch, cells_.first(std::size_t{patch.wide} * patch.high));
}

/// Codes the parts of the slice once more, now that their number is known.
Status PatchPacker::close(Job& job) noexcept {
  FrameReport& report = job.report;
  const std::size_t start = report.bytes + kPacketHeaderBytes;
  if (report.slices >= job.places.size() || report.slices >= 65535 || job.out.size() < start)
    return Status::kTooLarge;
  RangeEncoder coder(job.out.subspan(start, std::min(job.body, job.out.size() - start)));
  begin_slice(coder, job.models, in_slice_, job.options.height_log2);
  for (std::uint32_t s = 0; s < in_slice_; ++s) {
    const Part part = make_part(job, slice_[s]);
    code_part(job, part, coder);
    report.points += part.patch.points;
    ++report.surfaces;
  }
  const std::size_t bytes = coder.finish();
  if (coder.overflow()) return Status::kTooLarge;
  const auto total = static_cast<std::uint32_t>(kPacketHeaderBytes + bytes);
  job.places[report.slices++] = {static_cast<std::uint32_t>(report.bytes), total};
  report.bytes += total;
  in_slice_ = 0;
  return Status::kOk;
}

}  // namespace planecast
