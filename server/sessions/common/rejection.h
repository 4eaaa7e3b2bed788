// Detects measurements that are impossible. Pure functions.
#pragma once

#include <optional>

#include "engine_client/decider/types.h"
#include "server/sessions/common/options.h"

namespace sweepstake::sessions {

// Returns why the frame is impossible, or nothing. A frame lasts 1 µs (a million frames per second)
// to an hour. Detection is part of the frame, within 1 % and 1 ms of clock error. Checks are below
// 2^60, native bytes below 2^46.
std::optional<RejectionReason> RejectionOf(const FrameSample& frame);
// Returns why the sample is impossible, or nothing. The times are at most an hour; the other bounds
// are those of a frame.
std::optional<RejectionReason> RejectionOf(const ShadowSample& sample);

}  // namespace sweepstake::sessions
