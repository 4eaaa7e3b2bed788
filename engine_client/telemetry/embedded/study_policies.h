// The embedded decider and its session with policies that are not shipped, for the laboratory's
// experiments. This header is not installed: a game can choose a shipped policy only.
#pragma once

#include "server/decision/session/policy_registry.h"
#include "sweepstake/session.h"

namespace sweepstake {

// Makes what EmbeddedDecider::Create and MakeEmbeddedSession make, with a policy of `policies`. The
// registry must outlive the deciders and sessions.
struct StudyMaker {
  decision::PolicyRegistry policies;

  Result<std::unique_ptr<EmbeddedDecider>> MakeDecider(const EmbeddedOptions& options,
                                                       std::span<const std::string> arms,
                                                       std::span<const uint32_t> arm_versions,
                                                       uint64_t now_ns) const;
  Result<std::unique_ptr<Session>> MakeSession(const EmbeddedOptions& embedded,
                                               const SessionOptions& options) const;
};

}  // namespace sweepstake
