// What a stage of the pipeline is: a plain type with a name and process(slot). The runner sees it
// type-erased as StageRef, so that threads, rings and counters need no templates.
#pragma once

#include <concepts>
#include <cstdint>
#include <span>

#include "core/base/status.hpp"

namespace planecast {

/// A stage over slots of type Slot. process() reads what earlier stages wrote into the slot, writes
/// its own fields, never allocates, blocks or throws, and is called by one thread at a time, in the
/// order of the frames. kName is a NUL-terminated constant of at most 15 characters (thread name).
template <class S, class Slot>
concept Stage = requires(S& stage, Slot& slot) {
  { S::kName } -> std::convertible_to<const char*>;
  { stage.process(slot) }
  noexcept->std::same_as<Status>;
};

/// A stage with its types erased. It owns nothing: stage, slots and name must outlive their runner.
struct StageRef {
  const char* name = "";
  void* stage = nullptr;
  void* slots = nullptr;  ///< the first slot; a handle is an index from here
  Status (*process)(void* stage, void* slots, std::uint32_t handle) noexcept = nullptr;
};

/// Erases a stage that works on `slots`, handle i being slots[i]; at least as many slots as the
/// runner is configured for.
template <class Slot, Stage<Slot> S>
StageRef make_stage_ref(S& stage, std::span<Slot> slots) noexcept {
  return {S::kName, &stage, slots.data(),
          [](void* s, void* first, std::uint32_t handle) noexcept -> Status {
            return static_cast<S*>(s)->process(static_cast<Slot*>(first)[handle]);
          }};
}

}  // namespace planecast
