// What the halves of FramePacker share: packing (frame_pack.cpp) and columns of full slices
// (frame_pack_columns.cpp). Encoder half, seen by these two files only.
#pragma once

#include <array>
#include <cstdint>
#include <span>

#include "core/wire/column_plan.hpp"
#include "core/wire/frame_pack.hpp"
#include "core/wire/frame_pack_cost.hpp"

namespace planecast {

/// Bits that the head of a tile takes, in estimates.
inline constexpr double kTileHeadBits = 120;

// What is fixed for the time of one call of pack().
struct FramePacker::Job {
  const CodingTables& tables;
  const FrameModel& frame;
  std::size_t slice_bytes;
  std::span<std::uint8_t> out;
  std::span<SlicePlace> places;
  FrameReport& report;
  const WorkTeam& team;
  bool one_slice = false;  ///< any frame fits: nothing to estimate
  PackDeadline deadline = {};
  std::uint32_t blocks = 0;
  FramePacker* packer = nullptr;
  std::uint32_t part_count = 0;
  std::array<Part, kMaxFrameParts>* parts = nullptr;
  ColumnPlan plan = {};
};

// A rectangle that one worker packs, into room of its own.
struct FramePacker::Part {
  const Job* job = nullptr;
  TileRect rect = {};
  std::uint32_t column = 0, columns = 0;  ///< of the plan; none: `rect` is cut as it falls
  TilePacker* tiles = nullptr;
  std::span<std::uint8_t> out = {};
  std::span<SlicePlace> places = {};
  FrameReport report = {};
  PackMoments moments = {};
  Status status = Status::kOk;
};

}  // namespace planecast
