// The policies that a daemon or a game can choose: the two of the decision core, and the baselines
// that they are compared with.
#pragma once

#include "server/decision/session/policy_registry.h"

namespace sweepstake::decision {

PolicyRegistry ShippedPolicies();

}  // namespace sweepstake::decision
