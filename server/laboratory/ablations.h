// AI Decides with one of its components disabled, to measure what that component is worth. Only the
// laboratory's commands link this library: neither a daemon nor a game can choose an ablation.
#pragma once

#include "server/decision/session/policy_registry.h"

namespace sweepstake::decision {

// Returns the shipped policies, followed by the ablations `adaptive-without-…`.
PolicyRegistry StudyPolicies();

}  // namespace sweepstake::decision
