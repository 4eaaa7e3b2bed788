// Makes an embedded decider with any policy of a registry, for the laboratory. The header is not
// installed, so games can choose only shipped policies.
#pragma once

#include "engine_client/decider/session/policy_registry.h"
#include "sweepstake/embedded_decider.h"

namespace sweepstake {

// Works like EmbeddedDecider::Create but looks up the policy in `policies`, which must outlive the
// deciders.
struct StudyMaker {
  decision::PolicyRegistry policies;

  Result<std::unique_ptr<EmbeddedDecider>> MakeDecider(const EmbeddedOptions& options,
                                                       std::span<const std::string> arms,
                                                       std::span<const uint32_t> arm_versions,
                                                       uint64_t now_ns) const;
};

}  // namespace sweepstake
