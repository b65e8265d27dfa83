#include "tests/core/ring/model/model_run.hpp"

#include <ostream>

#include "tests/core/ring/model/model_suites.hpp"

namespace planecast::model {
namespace {

template <class Suite>
Outcome simulate(std::uint64_t schedules) {
  std::ostream nowhere(nullptr);  // a growing buffer would clash with relacy's operator new
  rl::test_params params;
  params.iteration_count = schedules;
  params.output_stream = &nowhere;
  params.progress_stream = &nowhere;
  params.search_type = rl::random_scheduler_type;
  Outcome outcome;
  outcome.holds = rl::simulate<Suite>(params);
  outcome.schedules = params.stop_iteration;
  if (!outcome.holds) outcome.fault = rl::test_result_str(params.test_result);
  return outcome;
}

// Each weakens one place by as little as there is: a mutant that still holds means that the product
// asks for more than it needs.
using enum std::memory_order;
using Light = ModelMemory<true>;    // the consumer pays: heavy_fence
using Fenced = ModelMemory<false>;  // the producer pays: seq_cst
#define PLANECAST_WEAKENED(name, base, place, order) \
  struct name : base {                               \
    static constexpr auto place = order;             \
  }
PLANECAST_WEAKENED(LightTailPublish, Light, kTailPublish, relaxed);
PLANECAST_WEAKENED(LightTailSeen, Light, kTailSeen, relaxed);
PLANECAST_WEAKENED(LightHeadPublish, Light, kHeadPublish, relaxed);
PLANECAST_WEAKENED(LightHeadSeen, Light, kHeadSeen, relaxed);
PLANECAST_WEAKENED(LightClosedSeen, Light, kClosedSeen, relaxed);
PLANECAST_WEAKENED(LightClose, Light, kClose, relaxed);
struct LightNoFence : Light {
  static bool heavy_fence() { return true; }
};
PLANECAST_WEAKENED(FencedTailPublish, Fenced, kTailPublishFenced, release);
PLANECAST_WEAKENED(FencedTailSeen, Fenced, kTailSeen, relaxed);
PLANECAST_WEAKENED(FencedTailLastLook, Fenced, kTailLastLook, acquire);
PLANECAST_WEAKENED(FencedHeadPublish, Fenced, kHeadPublish, relaxed);
PLANECAST_WEAKENED(FencedHeadSeen, Fenced, kHeadSeen, relaxed);
PLANECAST_WEAKENED(FencedSleepAnnounced, Fenced, kSleepAnnounced, release);
PLANECAST_WEAKENED(FencedSleeperSeen, Fenced, kSleeperSeen, acquire);
PLANECAST_WEAKENED(FencedClose, Fenced, kClose, release);
PLANECAST_WEAKENED(FencedClosedSeen, Fenced, kClosedSeen, acquire);
PLANECAST_WEAKENED(CountPublish, Light, kCountPublish, relaxed);
PLANECAST_WEAKENED(CountSeen, Light, kCountSeen, relaxed);
PLANECAST_WEAKENED(PiecesPublish, Light, kPiecesPublish, relaxed);
PLANECAST_WEAKENED(PieceTaken, Light, kPieceTaken, relaxed);
PLANECAST_WEAKENED(PieceFinished, Light, kPieceFinished, relaxed);
PLANECAST_WEAKENED(AllFinishedSeen, Light, kAllFinishedSeen, relaxed);
// A wake that does not come: who sleeps for a job that somebody else finishes sleeps for ever.
struct NoWake : Light {
  static void wake_one(ModelAtomic<std::uint32_t>&) {}
};
#undef PLANECAST_WEAKENED

}  // namespace

std::vector<Case> sound_cases() {
  return {
      {"stream, consumer pays", "", &simulate<Stream<Light>>},
      {"stream, producer pays", "", &simulate<Stream<Fenced>>},
      {"one push, consumer pays", "", &simulate<OnePush<Light>>},
      {"one push, producer pays", "", &simulate<OnePush<Fenced>>},
      {"another thread closes, consumer pays", "", &simulate<OtherCloses<Light>>},
      {"another thread closes, producer pays", "", &simulate<OtherCloses<Fenced>>},
      {"slot pool, consumer pays", "", &simulate<Pool<Light>>},
      {"slot pool, producer pays", "", &simulate<Pool<Fenced>>},
      {"slot pool's counts", "", &simulate<Counts<Light>>},
      {"shared pieces", "", &simulate<SharedJobs<Light>>},
  };
}

std::vector<Case> mutant_cases() {
  return {
      {"stream, consumer pays", "kTailPublish relaxed", &simulate<Stream<LightTailPublish>>},
      {"stream, consumer pays", "kTailSeen relaxed", &simulate<Stream<LightTailSeen>>},
      {"stream, consumer pays", "kHeadPublish relaxed", &simulate<Stream<LightHeadPublish>>},
      {"stream, consumer pays", "kHeadSeen relaxed", &simulate<Stream<LightHeadSeen>>},
      {"stream, consumer pays", "kClosedSeen relaxed", &simulate<Stream<LightClosedSeen>>},
      {"stream, consumer pays", "kClose relaxed", &simulate<Stream<LightClose>>},
      {"one push, consumer pays", "no heavy fence", &simulate<OnePush<LightNoFence>>},
      {"one push, producer pays", "kTailPublishFenced release",
       &simulate<OnePush<FencedTailPublish>>},
      {"stream, producer pays", "kTailSeen relaxed", &simulate<Stream<FencedTailSeen>>},
      {"one push, producer pays", "kTailLastLook acquire", &simulate<OnePush<FencedTailLastLook>>},
      {"stream, producer pays", "kHeadPublish relaxed", &simulate<Stream<FencedHeadPublish>>},
      {"stream, producer pays", "kHeadSeen relaxed", &simulate<Stream<FencedHeadSeen>>},
      {"one push, producer pays", "kSleepAnnounced release",
       &simulate<OnePush<FencedSleepAnnounced>>},
      {"one push, producer pays", "kSleeperSeen acquire", &simulate<OnePush<FencedSleeperSeen>>},
      {"another thread closes, producer pays", "kClose release",
       &simulate<OtherCloses<FencedClose>>},
      {"another thread closes, producer pays", "kClosedSeen acquire",
       &simulate<OtherCloses<FencedClosedSeen>>},
      {"slot pool, consumer pays", "kTailPublish relaxed", &simulate<Pool<LightTailPublish>>},
      {"slot pool's counts", "kCountPublish relaxed", &simulate<Counts<CountPublish>>},
      {"slot pool's counts", "kCountSeen relaxed", &simulate<Counts<CountSeen>>},
      {"shared pieces", "kPiecesPublish relaxed", &simulate<SharedJobs<PiecesPublish>>},
      {"shared pieces", "kPieceTaken relaxed", &simulate<SharedJobs<PieceTaken>>},
      {"shared pieces", "kPieceFinished relaxed", &simulate<SharedJobs<PieceFinished>>},
      {"shared pieces", "kAllFinishedSeen relaxed", &simulate<SharedJobs<AllFinishedSeen>>},
      {"shared pieces", "no wake", &simulate<SharedJobs<NoWake>>},
  };
}

}  // namespace planecast::model
