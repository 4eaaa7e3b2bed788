// Reads the evidence with which a session begins from the store, and creates the session.
//
// A new session starts from Beta(1,1) plus the evidence of the chosen sources of its scene. For
// arms without such evidence the project's other scenes are used. Each regime of the scene has a
// prior of its own. A session of a player stores evidence only about known arms of a known scene
// (PriorReader::LoadKnownArms), and does not keep a claim to a quota. So players who invent names
// use up no quota. A session that is resumed from the store starts from the same evidence, its own
// included. With Hello::ignores_priors, only its own evidence is used. Evidence with another reward
// version than the policy's is not used.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "engine_client/decider/pooling/prior.h"
#include "server/sessions/client_messages.h"
#include "server/sessions/game_session.h"
#include "server/sessions/new_scenes.h"

namespace sweepstake::sessions {

// The result of reading the store for a Hello.
struct StoredStart {
  decision::Prior prior;                        // prior of the Hello's arms
  std::vector<std::string> prior_sources = {};  // lines for the audit log that describe its sources
  std::optional<priors::SourceState> source;    // present if a session is resumed
  // The session id in the Hello, if the store does not have that session but several daemons share
  // the store. The new session keeps this id, because another daemon may hold the session without
  // having committed it. Only the first daemon that commits can continue it, so no message counts
  // twice.
  std::string kept_id = {};
  std::optional<UnstoredScene> new_scene;  // present if the store does not have the scene
  // For a session of a player: whether evidence about each arm may be stored. Empty: about none.
  std::vector<bool> kept_arms = {};
  absl::Status refusal;  // an error if the session would exceed a quota
  absl::Status status;   // the error that made some evidence missing; OK if none is missing
};

// Reads all that the Hello's session needs, on one of the store's threads. A scene that is not
// stored is not counted against the quotas yet. The project's other scenes are skipped on the
// writing thread, where reading them would delay commits.
StoredStart LoadStart(priors::PriorReader& store, const SessionRequest& hello,
                      const HostedSessionOptions& options, bool is_writing_thread);

// Counts the Hello's scene against the quotas, if `start` shows that it is not stored. REQUIRES:
// the caller is the store's writing thread, so that the count is exact.
void CountScene(priors::PriorReader& store, const SessionRequest& hello,
                const HostedSessionOptions& options, StoredStart& start);

// Creates the session of a Hello. Error: INVALID_ARGUMENT (the setup is not
// valid).
absl::StatusOr<std::shared_ptr<GameSession>> MakeSession(const SessionContext& context,
                                                         const SessionRequest& hello,
                                                         const StoredStart& start);

}  // namespace sweepstake::sessions
