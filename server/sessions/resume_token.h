// The proof that a client may resume a session. A session's id is public, so resuming needs its
// resume token too, which only its client has: HMAC-SHA-256 of the session's id and of the id of
// the token that the client authenticated itself with, under SessionOptions::resume_secret. It is
// stored nowhere. Pure functions.
#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace sweepstake::sessions {

// `token_id` is that of the token that the session began with; 0 for none.
std::string ResumeTokenOf(const std::string& session_id, int64_t token_id,
                          const std::string& secret);

// Returns the id of the token that the session began with, or nothing if `given` is not the
// session's resume token. It takes the same time for every token.
std::optional<int64_t> TokenOfSession(const std::string& session_id, const std::string& given,
                                      const std::string& secret);

}  // namespace sweepstake::sessions
