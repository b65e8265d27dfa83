#include "core/wire/patch_unpack.hpp"

#include "core/wire/decode_io.hpp"

namespace planecast {

void PatchUnpacker::layout(Arena& arena) noexcept {
  cells_ = arena.take<std::uint8_t>(kMaxPatchCells);
}

Status PatchUnpacker::begin(std::span<const std::uint8_t> body) noexcept {
  coder_ = RangeDecoder(body);
  models_ = PatchModels{};
  left_ = 0;
  if (coder_.raw(2) != kPatchSliceBody) return Status::kFieldRange;
  DecodeIo io{coder_};
  std::uint8_t height_log2 = 0;
  PatchCode<DecodeIo>(io, models_).head(left_, height_log2);
  return Status::kOk;
}

Status PatchUnpacker::next(Patch& patch, std::span<const std::uint8_t>& cells) noexcept {
  if (left_ == 0) return Status::kTruncated;
  const auto fail = [&](Status status) {
    left_ = 0;
    cells = {};
    return status;
  };
  DecodeIo io{coder_};
  PatchCode<DecodeIo> code(io, models_);
  patch = {};
  if (const Status status = code.fields(patch); status != Status::kOk)
    return fail(coder_.truncated() ? Status::kTruncated : status);
  const std::size_t count = std::size_t{patch.wide} * patch.high;
  if (cells_.size() < count) return fail(Status::kTooLarge);
  const bool any = code.cells(patch, cells_.first(count));
  if (coder_.truncated()) return fail(Status::kTruncated);
  if (!any) return fail(Status::kFieldRange);
  if (--left_ == 0 && coder_.trailing()) return fail(Status::kTrailingBytes);
  cells = cells_.first(count);
  return Status::kOk;
}

}  // namespace planecast
