// How a session begins: Hello and what the store knows become a session and its Welcome.
//
// There are three ways. A new session starts from Beta(1,1) plus the evidence of all sources. A
// session that is resumed from the store after a restart does the same; its own evidence is among
// them. A session that is resumed from memory goes on as it is. With ignore_priors only the
// session's own evidence counts. What a session learns and starts from belongs to its policy's
// version of the reward; a checked Hello names the policy.
#pragma once

#include <memory>
#include <optional>
#include <string>

#include "absl/status/statusor.h"
#include "server/rpc/sessions/game_session.h"

namespace sweepstake::rpc {

// What the store knows for a Hello.
struct StoredStart {
  priors::PriorSums priors;                   // in Hello's order of arms
  std::optional<priors::SourceState> source;  // of a session to resume
};

// On the store's thread. NOT_FOUND: the session to resume is unknown.
absl::StatusOr<StoredStart> LoadStart(priors::PriorStore& store, const v1::Hello& hello);

// Makes the session of a checked Hello. INVALID_ARGUMENT: the stored session was about another
// scene, or the setup is wrong.
absl::StatusOr<std::shared_ptr<GameSession>> MakeSession(SessionContext& context,
                                                         const v1::Hello& hello,
                                                         const StoredStart& start);

// INVALID_ARGUMENT: the session in memory was opened with another project, scene, machine class,
// version of the reward or other arms.
absl::Status CheckSame(const GameSession& session, const v1::Hello& hello);

v1::Welcome WelcomeOf(const GameSession& session, bool resumed, const RpcOptions& options);

}  // namespace sweepstake::rpc
