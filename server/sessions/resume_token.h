// The proof that a client may resume a session. A session's id is public, so resuming also requires
// its resume token, which only its client has. It is the HMAC-SHA-256 of the session's id and of
// the id of the token with which the client authenticated, under
// HostedSessionOptions::resume_secret. It is not stored. Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sweepstake::sessions {

// `token_id` is the id of the token with which the session began; 0 for none.
std::string ResumeTokenOf(const std::string& session_id, int64_t token_id,
                          const std::string& secret);

// Returns the id of the token with which the session began, or nothing if `given` is not the
// session's resume token. The comparison takes constant time.
std::optional<int64_t> TokenOfSession(const std::string& session_id, const std::string& given,
                                      const std::string& secret);

}  // namespace sweepstake::sessions
