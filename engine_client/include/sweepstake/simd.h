// The instruction set of the broad phases. By default it is the best one of the processor. A lesser
// one can be chosen, to test it or to measure the cost on other players' machines.
//
// The choice applies to the whole process, including existing broad phases and other users of the
// same Highway library.
#pragma once

#include <span>
#include <string_view>

#include "sweepstake/status.h"

#include "sweepstake/names/begin.h"

namespace sweepstake {

// Returns the names of the instruction sets that this machine has kernels for, the best first.
// Possible names: avx512, avx2, sse4, sve2, sve, neon and scalar. Any thread.
std::span<const std::string_view> SimdTargets();

// Returns the member of SimdTargets() in use. Any thread.
std::string_view SimdTarget();

// Uses this instruction set, and no better one. Error kInvalidArgument: `name` is not one of
// SimdTargets(), which the message lists; nothing changes then. REQUIRES: no broad phase is
// running.
Status UseSimdTarget(std::string_view name);

// Uses the instruction set named by the environment variable SWEEPSTAKE_CLIENT_SIMD, if it is set,
// and returns the result of UseSimdTarget. Only the first call of a process has an effect, and none
// after UseSimdTarget. MakeBroadPhase calls it. Any thread.
Status UseSimdTargetOfEnvironment();

}  // namespace sweepstake

#include "sweepstake/names/end.h"
