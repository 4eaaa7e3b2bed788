// The only converter between the public plain structs and the values of the decision core.
// ToDecision makes a value of the core, FromDecision makes a public one. Pure functions.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "engine_client/decider/types.h"
#include "sweepstake/embedded_decider.h"
#include "sweepstake/frame_sample.h"

namespace sweepstake {

decision::Frame ToDecision(const FrameSample& sample);
decision::ShadowSample ToDecision(const ShadowSample& sample);
// A value that is negative or not finite was not measured.
decision::SceneDescriptor ToDecision(const SceneDescriptor& descriptor);
decision::SwitchCost ToDecision(const SwitchOutcome& outcome);
decision::SwitchReason ToDecision(SwitchReason reason);
decision::Mode ToDecision(Mode mode);
decision::BetaPosterior ToDecision(const ArmBelief& belief);

SwitchCommand FromDecision(const decision::SwitchCommand& command);
SceneVerdict FromDecision(const decision::Diagnosis& diagnosis);
std::vector<ArmBelief> FromDecision(std::span<const decision::BetaPosterior> posteriors,
                                    std::span<const decision::ArmStanding> standings,
                                    const decision::Diagnosis& diagnosis,
                                    std::span<const std::string> arms);
DecisionEvent FromDecision(const decision::Decision& decision, std::span<const std::string> arms);

}  // namespace sweepstake
