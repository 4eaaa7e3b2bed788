// Tickets: a studio's backend signs one for each player, with a token of the role `ticket` that
// only the backend has. The token of a shipped game cannot sign tickets: its players can read it.
//
// A game sends its ticket in place of a token. The daemon then divides places for evidence and
// quotas among players, and a revocation can name a player. Without tickets all players of a game
// share its token, and the daemon can tell them apart only by their networks.
//
//   payload = "swt." + KEY + "." + PLAYER + "." + EXPIRES
//   ticket  = payload + "." + HEX(HMAC-SHA-256(DIGEST, payload))
//
// - DIGEST: the SHA-256 of the token, as 64 lower-case hexadecimal digits. The digits are the key
// of
//   the HMAC.
// - KEY: the first 16 digits of DIGEST.
// - PLAYER: 1 to 64 letters, digits, '-' and '_'. It need not be the player's real name.
// - EXPIRES: Unix time in seconds, at most kMaxTicketLifeS in the future.
//
// The daemon stores DIGEST. So whoever reads its token file can sign tickets, but cannot learn the
// token. Pure functions.
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace sweepstake::auth {

inline constexpr int64_t kMaxTicketLifeS = int64_t{7} * 24 * 3600;
inline constexpr size_t kTicketKeyDigits = 16;

struct Ticket {
  std::string key;  // the first digits of the token's digest
  std::string player;
  int64_t expires_unix_s = 0;

  bool IsValidAt(int64_t unix_s) const {
    return unix_s < expires_unix_s && expires_unix_s <= unix_s + kMaxTicketLifeS;
  }
};

// Returns whether the text can be the PLAYER of a ticket.
bool IsPlayer(std::string_view text);

// Returns the ticket of a player, signed with the token. REQUIRES: IsPlayer(player).
std::string SignTicket(std::string_view token, std::string_view player, int64_t expires_unix_s);

// Returns the content of a ticket without checking its signature; absent if the text is not a
// ticket.
std::optional<Ticket> ReadTicket(std::string_view text);

// Returns whether the text is a ticket that was signed with the token of this digest.
bool IsSignedWith(std::string_view text, std::string_view digest);

}  // namespace sweepstake::auth
