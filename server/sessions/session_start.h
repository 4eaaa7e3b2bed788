// Starts sessions: makes a session and its Welcome from Hello and the store's evidence.
//
// There are three cases. A new session starts from Beta(1,1) plus the evidence of all sources, and,
// of arms that its scene has none of, plus what the project's other scenes have in common. A
// session that is resumed from the store after a restart does the same, and its own evidence is
// included. A session that is resumed from memory continues unchanged. With ignore_priors only the
// session's own evidence is used. All evidence is that of the policy's reward version; a checked
// Hello names the policy.
//
// What the store cannot read is missing, and the session starts all the same: from Beta(1,1) plus
// what could be read. A session whose own progress cannot be read is not resumed, since its
// messages might be counted twice; a new one begins.
//
// A session's id is public, so resuming needs its resume token too, which only its client has:
// HMAC-SHA-256 of both ids under RpcOptions::resume_secret, and the id of the token that the client
// authenticated itself with. It is stored nowhere. The right resume token with another token than
// the session began with is PERMISSION_DENIED.
//
// If the resume token is wrong, or the session to resume is unknown, has ended or is not of Hello's
// scene, machine class, reward version and arms, a new one begins. The answer is the same in all
// these cases, so that it tells nothing about other sessions.
#pragma once

#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "engine_client/decider/pooling/prior.h"
#include "server/sessions/game_session.h"
#include "server/sessions/new_scenes.h"

namespace sweepstake::rpc {

// The store's knowledge for a Hello.
struct StoredStart {
  decision::Prior prior;                        // for Hello's arms
  std::vector<std::string> prior_sources = {};  // describes its sources in the audit log
  std::optional<priors::SourceState> source;    // present if a session is resumed
  // Of a session that nothing of is stored yet, and which another daemon may have: it begins anew
  // under its id, so that the first of both to commit goes on with it, and no message counts twice.
  std::string kept_id = {};
  std::optional<UnstoredScene> new_scene;  // present if the store does not have the scene
  absl::Status refusal;                    // a quota that the session would exceed
  absl::Status status;                     // why some of it is missing; OK if nothing is
};

// Reads the store, on one of its threads: on the writing one if a session is to be resumed, since
// its latest commit may wait in the queue, or if the scene is not stored, since it `counts` against
// the quotas then. Elsewhere nothing is counted, and such a scene is to be read again there; only
// elsewhere the project's other scenes are read, too, for the arms of which this one knows nothing.
StoredStart LoadStart(priors::PriorReader& store, const v1::Hello& hello, const RpcOptions& options,
                      bool counts);

// Makes the session of a checked Hello for the caller's token. Error: INVALID_ARGUMENT (the setup
// is not valid).
absl::StatusOr<std::shared_ptr<GameSession>> MakeSession(SessionContext& context,
                                                         const v1::Hello& hello,
                                                         const StoredStart& start,
                                                         int64_t token_id);

// Returns the id of the token that Hello's session began with, or nothing if Hello has not the
// session's resume token. It takes the same time for every one.
std::optional<int64_t> TokenOfSession(const v1::Hello& hello, const RpcOptions& options);

// Returns whether Hello, with its token checked, may resume this session, which is in memory.
bool CanResume(const GameSession& session, const v1::Hello& hello);

// Answers the checked Hello, with the newest version of the protocol and the capabilities that both
// have. `stream_count` is how many streams are open.
v1::Welcome WelcomeOf(const GameSession& session, const v1::Hello& hello, bool resumed,
                      uint64_t stream_count, const RpcOptions& options);

// Returns how long a client is to collect frames: an eighth of the decision interval, 250 ms at
// most. With more streams it is longer, as if all were to send 10,000 batches a second, but at most
// half of the decision interval.
uint32_t BatchIntervalMs(uint32_t decision_interval_ms, uint64_t stream_count);

}  // namespace sweepstake::rpc
