// Makes an embedded session with any policy of a registry, for the laboratory's experiments. This
// header is not installed, so games can choose only shipped policies.
#pragma once

#include "engine_client/decider/session/policy_registry.h"
#include "sweepstake/session.h"

namespace sweepstake {

// Works like MakeEmbeddedSession but looks up the policy in `policies`, which must outlive the
// sessions.
Result<std::unique_ptr<Session>> MakeStudySession(decision::PolicyRegistry policies,
                                                  const EmbeddedOptions& embedded,
                                                  const SessionOptions& options);

}  // namespace sweepstake
