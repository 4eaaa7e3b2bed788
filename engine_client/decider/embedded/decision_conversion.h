// Converts between the structs of a decision session and those of the public interface. Pure
// functions.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine_client/decider/types.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/frame_sample.h"

namespace sweepstake {

// A value that is negative or not finite counts as not measured.
decision::SceneDescriptor ToDecision(const SceneDescriptor& descriptor);
decision::SwitchCost SwitchCostOf(const SwitchOutcome& outcome);

SceneVerdict FromDecision(const decision::Diagnosis& diagnosis);
std::vector<ArmBelief> FromDecision(std::span<const decision::BetaPosterior> posteriors,
                                    std::span<const ArmStanding> standings,
                                    const decision::Diagnosis& diagnosis,
                                    std::span<const std::string> arms);
DecisionEvent FromDecision(const decision::Decision& decision, std::span<const std::string> arms);

}  // namespace sweepstake
