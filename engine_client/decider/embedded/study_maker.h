// Makes an embedded decider whose policy is not shipped, for the laboratory's experiments. This
// header is not installed: a game can choose a shipped policy only.
#pragma once

#include "engine_client/decider/session/policy_registry.h"
#include "sweepstake/embedded_decider.h"

namespace sweepstake {

// Does what EmbeddedDecider::Create does, with a policy of `policies`. The registry must outlive
// the deciders.
struct StudyMaker {
  decision::PolicyRegistry policies;

  Result<std::unique_ptr<EmbeddedDecider>> MakeDecider(const EmbeddedOptions& options,
                                                       std::span<const std::string> arms,
                                                       std::span<const uint32_t> arm_versions,
                                                       uint64_t now_ns) const;
};

}  // namespace sweepstake
