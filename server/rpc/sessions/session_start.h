// Starts sessions: makes a session and its Welcome from Hello and the store's evidence.
//
// There are three cases. A new session starts from Beta(1,1) plus the evidence of all sources. A
// session that is resumed from the store after a restart does the same, and its own evidence is
// included. A session that is resumed from memory continues unchanged. With ignore_priors only the
// session's own evidence is used. All evidence is that of the policy's reward version; a checked
// Hello names the policy.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "server/rpc/sessions/game_session.h"

namespace sweepstake::rpc {

// The store's knowledge for a Hello.
struct StoredStart {
  priors::PriorSums priors;                   // in Hello's order of arms
  std::optional<priors::SourceState> source;  // if a session is resumed
};

// Reads the store, on its thread. Error: NOT_FOUND (the session to resume is unknown).
absl::StatusOr<StoredStart> LoadStart(priors::PriorStore& store, const v1::Hello& hello);

// Makes the session of a checked Hello. Error: INVALID_ARGUMENT (the stored session has another
// scene, or the setup is not valid).
absl::StatusOr<std::shared_ptr<GameSession>> MakeSession(SessionContext& context,
                                                         const v1::Hello& hello,
                                                         const StoredStart& start);

// Checks that Hello matches a session in memory. Error: INVALID_ARGUMENT (it was opened with
// another project, scene, machine class, reward version or other arms).
absl::Status CheckSame(const GameSession& session, const v1::Hello& hello);

v1::Welcome WelcomeOf(const GameSession& session, bool resumed, const RpcOptions& options);

}  // namespace sweepstake::rpc
