// The identity of a session, fixed for its life. A plain value.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/sessions/prior_store.h"

namespace sweepstake::sessions {

struct SessionIdentity {
  std::string id;
  int64_t token_id = 0;  // id of the token that began the session; no other token may resume it
  std::string build;     // build of the game; empty if unknown
  priors::SceneKey scene;
  std::vector<std::string> arms;
  std::vector<uint32_t> backend_versions;  // one per arm
  uint64_t seed = 0;
  std::string policy;                      // its name in the registry of policies
  uint32_t audit_segment = 1;              // segment of the session's audit log
  std::vector<std::string> prior_sources;  // describes the sources of its prior in the audit log
};

}  // namespace sweepstake::sessions
