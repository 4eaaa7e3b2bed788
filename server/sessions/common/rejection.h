// Detects measurements that are impossible. Pure functions.
#pragma once

#include <optional>

#include "engine_client/decider/types.h"
#include "server/sessions/common/options.h"

namespace sweepstake::sessions {

// Returns why the frame is impossible, or nothing. A possible frame lasts 1 µs (a million frames
// per second) to an hour. Its detection time is at most its frame time plus 1 % and 1 ms, which
// allow for clock error. It has fewer than 2^60 AABB checks and fewer than 2^46 native bytes.
std::optional<RejectionReason> RejectionOf(const FrameSample& frame);
// Returns why the shadow sample is impossible, or nothing. A possible sample took at most an hour
// to detect and to build. Its AABB checks and native bytes are limited as in a frame.
std::optional<RejectionReason> RejectionOf(const ShadowSample& sample);

}  // namespace sweepstake::sessions
