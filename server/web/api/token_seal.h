// Keeps a token so that only who has the cookie of its login can read it (AES-256-GCM under a key
// made from the cookie).
#pragma once

#include <optional>
#include <string>
#include <string_view>

namespace sweepstake::web {

// Returns the token, sealed; no text but the cookie opens it. A cookie seals one token.
std::string SealToken(std::string_view cookie, std::string_view token);
// Returns the token, or nothing if the cookie is another one, or the sealed text was changed.
std::optional<std::string> OpenToken(std::string_view cookie, std::string_view sealed);

}  // namespace sweepstake::web
