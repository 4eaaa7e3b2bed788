// The instruction set that the broad phases run with: the best one that the processor has, unless a
// lesser one is asked for, to test it or to measure what other players' machines would take.
//
// What is chosen counts for the whole process, for broad phases that exist already too, and for
// other users of the same Highway library.
#pragma once

#include <span>
#include <string_view>

#include "sweepstake/status.h"

#include "sweepstake/names/begin.h"

namespace sweepstake {

// Returns the names of the instruction sets that this machine has kernels for, the best first: of
// avx512, avx2, sse4, sve2, sve, neon and scalar. Any thread.
std::span<const std::string_view> SimdTargets();

// Returns the one of SimdTargets() that runs. Any thread.
std::string_view SimdTarget();

// Lets this one run, and none that is better. kInvalidArgument: not one of SimdTargets(), which the
// message lists; nothing has changed. REQUIRES: no broad phase is at work.
Status UseSimdTarget(std::string_view name);

// Lets the one run that environment variable SWEEPSTAKE_CLIENT_SIMD names, if there is one, and
// returns what UseSimdTarget would. Only the first call of a process does it, and none after
// UseSimdTarget. MakeBroadPhase calls it. Any thread.
Status UseSimdTargetOfEnvironment();

}  // namespace sweepstake

#include "sweepstake/names/end.h"
