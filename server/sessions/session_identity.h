// The identity of a session, fixed for its life. A plain value.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "server/sessions/prior_store.h"

namespace sweepstake::sessions {

struct SessionIdentity {
  std::string id;
  priors::SourceOrigin origin;  // no other token than the origin's may resume the session
  priors::SceneKey scene;
  std::vector<std::string> arms;
  std::vector<uint32_t> backend_versions;  // one per arm
  std::vector<bool> kept_arms;             // whether evidence about each arm is stored
  bool is_of_player = false;               // adds no known arms to the store
  uint64_t seed = 0;
  std::string policy;                      // its name in the registry of policies
  uint32_t audit_segment = 1;              // segment of the session's audit log
  std::vector<std::string> prior_sources;  // describes the sources of its prior in the audit log
};

}  // namespace sweepstake::sessions
