// The policies that the laboratory compares. Only the laboratory's commands link this library. A
// daemon or a game can choose only the policies that are shipped
// (engine_client/decider/session/policy_registry.h).
#pragma once

#include "engine_client/decider/session/policy_registry.h"

namespace sweepstake::decision {

// Returns the shipped policies, followed by the baselines that AI Decides is compared with.
PolicyRegistry ComparedPolicies();

// Returns ComparedPolicies(), followed by the ablations `adaptive-without-…`: AI Decides with one
// of its components disabled, to measure the contribution of that component.
PolicyRegistry StudyPolicies();

}  // namespace sweepstake::decision
