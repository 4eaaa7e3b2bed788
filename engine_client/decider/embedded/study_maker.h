// Makes an embedded decider with a policy that is not shipped, for the laboratory. This header is
// not installed, because a game can only choose a shipped policy.
#pragma once

#include "engine_client/decider/session/policy_registry.h"
#include "sweepstake/embedded_decider.h"

namespace sweepstake {

// Works like EmbeddedDecider::Create, with the policies of `policies`. The registry must outlive
// the deciders.
struct StudyMaker {
  decision::PolicyRegistry policies;

  Result<std::unique_ptr<EmbeddedDecider>> MakeDecider(const EmbeddedOptions& options,
                                                       std::span<const std::string> arms,
                                                       std::span<const uint32_t> arm_versions,
                                                       uint64_t now_ns) const;
};

}  // namespace sweepstake
