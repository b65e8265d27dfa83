/* The whole pipeline as core/pipeline/stage_runner.cpp and core/ring/slot_pool.hpp run it: claim,
 * four stages, the rings between them, the done ring, the return ring; drops at the claim, frames
 * that fail in any stage, a source that waits and one that drops, a consumer that leaves, stop
 * (drain or discard) at any moment, and a start after it. A ring's sleep and wake are one step here:
 * that a wake is never lost is tests/core/ring/model's part.
 *
 * Checked in every state: a handle is in exactly one place, a ring never refuses a push, frames stay
 * in order, nobody sees more frames than are counted; at the end every handle and every frame is
 * accounted for; no deadlock; and (ltl) every run ends, so nobody waits for ever.
 * -DMUTANT_x plants one fault; each must be found (pipeline_model_test.py).
 */
#ifndef SLOTS
#define SLOTS 2
#endif
#ifndef FRAMES
#define FRAMES 3
#endif
#define STAGES 4
#define DONE STAGES
#ifdef MUTANT_SHORT_RING
#define CELLS (SLOTS - 1)
#else
#define CELLS SLOTS
#endif

#define OK 0
#define FAILED 1
#define STOPPED 2

/* Where a handle is. */
#define FREE 0
#define SOURCE 1
#define IN_RING 2
#define IN_STAGE 3
#define CONSUMER 4
#define RETURNED 5

chan ring[STAGES + 1] = [CELLS] of { byte };
chan returned = [CELLS] of { byte };
bool closed[STAGES + 1];
bool pool_closed;
bool running, discard, submitting;
byte alive;                    /* worker threads */
byte place[SLOTS];             /* of each handle */
byte status[SLOTS];
byte number[SLOTS];            /* frame in each slot */
byte free_handles;             /* the source's own stack holds handles SLOTS-1 .. by count */
byte stack[SLOTS];
byte frames_in, dropped, ok, failed, delivered;
bool begun, source_ended, consumer_ended, finished;

inline move(handle, from, to) {
  assert(place[handle] == from);
  place[handle] = to
}

/* StageRunner::Core::push: the ring holds every handle, so it has room. */
inline push(to_ring, handle) {
  assert(nfull(ring[to_ring]));
  ring[to_ring]!handle
}

inline unclaim(handle) {
#ifdef MUTANT_NO_UNCLAIM
  skip;
#else
  d_step { move(handle, SOURCE, FREE); stack[free_handles] = handle; free_handles++ };
#endif
  dropped++
}

active proctype source() {
  byte handle;
  bool got;
  (free_handles == SLOTS);                     /* after init() */
  do
  :: frames_in < FRAMES ->
    frames_in++;
    got = false;
    if
    :: free_handles > 0 ->
      d_step { free_handles--; handle = stack[free_handles]; move(handle, FREE, SOURCE) };
      got = true
    :: else ->
      if
      :: atomic { returned?handle -> move(handle, RETURNED, SOURCE) }; got = true
#ifdef MUTANT_POLLING_SOURCE
      :: empty(returned) -> frames_in--; goto again
#else
      :: empty(returned) -> skip               /* claim(): the new frame is dropped */
#endif
      :: true ->                               /* claim_wait() */
        if
        :: atomic { returned?handle -> move(handle, RETURNED, SOURCE) }; got = true
#ifndef MUTANT_POOL_STAYS_OPEN
        :: pool_closed && empty(returned) -> skip
#endif
        fi
      fi
    fi;
    if
    :: !got -> dropped++
    :: got ->
      number[handle] = frames_in;
      /* submit() */
#ifdef MUTANT_LATE_FLAG
      if
      :: !running -> unclaim(handle)
      :: running ->
        submitting = true;
#else
      submitting = true;
      if
      :: !running -> submitting = false; unclaim(handle)
      :: running ->
#endif
        status[handle] = OK;
        atomic { move(handle, SOURCE, IN_RING); push(0, handle) };
        submitting = false
      fi
    fi;
again: skip
  :: else -> break
  od;
  source_ended = true
}

proctype worker(byte index) {
  byte handle;
  do
  :: atomic { ring[index]?handle -> move(handle, IN_RING, IN_STAGE) };
    if
    :: status[handle] == OK && discard -> status[handle] = STOPPED
    :: status[handle] == OK && !discard ->
      if
      :: skip                                  /* process() */
      :: status[handle] = FAILED
      fi
    :: status[handle] != OK -> skip            /* flows on untouched */
    fi;
#ifdef MUTANT_FAILED_FRAME_STAYS
    if
    :: status[handle] == FAILED && index == 1 -> goto next
    :: else -> skip
    fi;
#endif
    if
    :: index == STAGES - 1 ->
#ifdef MUTANT_COUNTED_LATE
      atomic { move(handle, IN_STAGE, IN_RING); push(DONE, handle) };
#endif
      if
      :: status[handle] == OK -> ok++
      :: else -> failed++
      fi;
#ifndef MUTANT_COUNTED_LATE
      atomic { move(handle, IN_STAGE, IN_RING); push(DONE, handle) }
#else
      skip
#endif
    :: else -> atomic { move(handle, IN_STAGE, IN_RING); push(index + 1, handle) }
    fi;
next: skip
#ifdef MUTANT_LEAVES_FULL_RING
  :: closed[index] -> break
#else
  :: closed[index] && empty(ring[index]) -> break
#endif
  od;
#ifndef MUTANT_END_STAYS
  closed[index + 1] = true;
#endif
  alive--
}

active proctype consumer() {
  byte handle;
  byte last = 0;
  do
  :: atomic { ring[DONE]?handle -> move(handle, IN_RING, CONSUMER); delivered++ };
    assert(delivered <= ok + failed);
    assert(number[handle] > last);
    last = number[handle];
    /* release() */
    atomic { move(handle, CONSUMER, RETURNED); assert(nfull(returned)); returned!handle };
#ifdef MUTANT_RELEASED_TWICE
    atomic { nfull(returned) -> returned!handle }
#endif
  :: atomic { closed[DONE] && empty(ring[DONE]) && source_ended -> consumer_ended = true }; break
  /* It may also leave once stopped: what is in the done ring stays there, and a source that waits
   * for a slot must still end. */
  :: atomic { !running && begun -> consumer_ended = true }; break
  od
}

inline start() {
  discard = false;
  byte i;
  for (i : 0 .. STAGES) { closed[i] = false }
  pool_closed = false;
  for (i : 0 .. (STAGES - 1)) { alive++; run worker(i) }
  running = true;
  begun = true
}

inline stop() {
  if
  :: discard = true
  :: skip
  fi;
  running = false;
  pool_closed = true;
#ifndef MUTANT_STOP_DOES_NOT_WAIT
  !submitting;
#endif
  closed[0] = true;
  alive == 0;
  closed[DONE] = true
}

active proctype control() {
  byte h;
  d_step {
    h = 0;
    do
    :: h < SLOTS -> stack[h] = h; h++
    :: else -> break
    od;
    free_handles = SLOTS
  };
  atomic { start() };
  stop();                                      /* at any moment */
  if
  :: atomic { !consumer_ended -> start() };    /* and on again */
    (source_ended);
    stop()
  :: skip
  fi;
  (source_ended && consumer_ended);
  /* Nothing lost, nothing doubled. */
  byte there = free_handles + len(returned) + len(ring[DONE]);
  assert(there == SLOTS);
  assert(frames_in == ok + failed + dropped);
  assert(delivered + len(ring[DONE]) == ok + failed);
  finished = true
}

ltl ends { <> finished }
