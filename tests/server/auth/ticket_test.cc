#include "server/auth/ticket.h"

#include <gtest/gtest.h>

#include <string>
#include <vector>

#include "server/auth/token_store.h"

namespace sweepstake::auth {
namespace {

constexpr const char* kToken = "sweepstake_0123456789abcdef";
constexpr int64_t kExpires = 1'800'000'000;

// Computed with Python: hmac.new(hashlib.sha256(TOKEN).hexdigest(), PAYLOAD, 'sha256').
TEST(TicketTest, HasTheDocumentedForm) {
  EXPECT_EQ(SignTicket(kToken, "player-17", kExpires),
            "swt.5311b9d8add8acd1.player-17.1800000000."
            "45545aca87314c09e94263de58668c4fb4331d13edeca7924321ff50674c9a52");
}

TEST(TicketTest, IsReadAndItsSignatureChecked) {
  const std::string ticket = SignTicket(kToken, "player_17", kExpires);
  const auto read = ReadTicket(ticket);
  ASSERT_TRUE(read);
  EXPECT_EQ(read->player, "player_17");
  EXPECT_EQ(read->expires_unix_s, kExpires);
  EXPECT_EQ(read->key, DigestOf(kToken).substr(0, kTicketKeyDigits));
  EXPECT_TRUE(IsSignedWith(ticket, DigestOf(kToken)));
  EXPECT_FALSE(IsSignedWith(ticket, DigestOf("sweepstake_other")));
}

TEST(TicketTest, NoChangedByteIsAccepted) {
  const std::string ticket = SignTicket(kToken, "alice", kExpires);
  for (size_t i = 0; i < ticket.size(); ++i) {
    std::string changed = ticket;
    changed[i] = changed[i] == '1' ? '2' : '1';
    EXPECT_FALSE(ReadTicket(changed) && IsSignedWith(changed, DigestOf(kToken))) << changed;
  }
  EXPECT_FALSE(IsSignedWith(ticket.substr(0, ticket.size() - 1), DigestOf(kToken)));
  EXPECT_FALSE(IsSignedWith("", DigestOf(kToken)));
}

TEST(TicketTest, OtherTextIsNoTicket) {
  const std::string key(kTicketKeyDigits, 'a');
  for (const std::string& text : std::vector<std::string>{
           std::string(), std::string(kToken), std::string("swt"), "swt." + key + ".p.1",
           "swt." + key + "..1.x", "swt." + key + ".p.x.x", "swt." + key + ".p.-1.x",
           "swt." + key + ".p q.1.x", "swt.short.p.1.x", "swt." + key + ".p.1.x.y",
           "swt." + key + "." + std::string(65, 'p') + ".1.x"}) {
    EXPECT_FALSE(ReadTicket(text)) << text;
  }
  EXPECT_TRUE(ReadTicket("swt." + key + "." + std::string(64, 'p') + ".1.x"));
}

TEST(TicketTest, EndsAtItsTimeAndIsNotValidForLong) {
  const Ticket ticket{.key = "", .player = "p", .expires_unix_s = kExpires};
  EXPECT_TRUE(ticket.IsValidAt(kExpires - 1));
  EXPECT_FALSE(ticket.IsValidAt(kExpires));
  EXPECT_TRUE(ticket.IsValidAt(kExpires - kMaxTicketLifeS));
  EXPECT_FALSE(ticket.IsValidAt(kExpires - kMaxTicketLifeS - 1));
}

}  // namespace
}  // namespace sweepstake::auth
