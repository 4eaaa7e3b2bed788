// Makes an embedded session whose policy is not shipped, for the laboratory's experiments. This
// header is not installed: a game can choose a shipped policy only.
#pragma once

#include "engine_client/decider/session/policy_registry.h"
#include "sweepstake/session.h"

namespace sweepstake {

// Does what MakeEmbeddedSession does, with a policy of `policies`. The registry must outlive the
// sessions.
Result<std::unique_ptr<Session>> MakeStudySession(decision::PolicyRegistry policies,
                                                  const EmbeddedOptions& embedded,
                                                  const SessionOptions& options);

}  // namespace sweepstake
