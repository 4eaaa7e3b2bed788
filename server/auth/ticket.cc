#include "server/auth/ticket.h"

#include <openssl/crypto.h>
#include <openssl/hmac.h>

#include <algorithm>
#include <array>
#include <vector>

#include "absl/strings/ascii.h"
#include "absl/strings/escaping.h"
#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "server/auth/token_store.h"

namespace sweepstake::auth {
namespace {

constexpr absl::string_view kPrefix = "swt";
constexpr size_t kMaxPlayerBytes = 64;

std::string SignatureOf(std::string_view payload, std::string_view digest) {
  std::array<unsigned char, EVP_MAX_MD_SIZE> code{};
  unsigned int size = 0;
  HMAC(EVP_sha256(), digest.data(), static_cast<int>(digest.size()),
       reinterpret_cast<const unsigned char*>(payload.data()), payload.size(), code.data(), &size);
  return absl::BytesToHexString(
      absl::string_view(reinterpret_cast<const char*>(code.data()), size));
}

}  // namespace

bool IsPlayer(std::string_view text) {
  return !text.empty() && text.size() <= kMaxPlayerBytes &&
         std::all_of(text.begin(), text.end(), [](char letter) {
           return absl::ascii_isalnum(static_cast<unsigned char>(letter)) || letter == '-' ||
                  letter == '_';
         });
}

std::string SignTicket(std::string_view token, std::string_view player, int64_t expires_unix_s) {
  const std::string digest = DigestOf(token);
  const std::string payload = absl::StrCat(kPrefix, ".", digest.substr(0, kTicketKeyDigits), ".",
                                           std::string(player), ".", expires_unix_s);
  return absl::StrCat(payload, ".", SignatureOf(payload, digest));
}

std::optional<Ticket> ReadTicket(std::string_view text) {
  const std::vector<std::string> parts =
      absl::StrSplit(absl::string_view(text.data(), text.size()), '.');
  Ticket ticket;
  if (parts.size() != 5 || parts[0] != kPrefix || parts[1].size() != kTicketKeyDigits ||
      !IsPlayer(parts[2]) || !absl::SimpleAtoi(parts[3], &ticket.expires_unix_s) ||
      ticket.expires_unix_s <= 0) {
    return std::nullopt;
  }
  ticket.key = parts[1];
  ticket.player = parts[2];
  return ticket;
}

bool IsSignedWith(std::string_view text, std::string_view digest) {
  const size_t end = text.rfind('.');
  if (end == std::string_view::npos) return false;
  const std::string expected = SignatureOf(text.substr(0, end), digest);
  const std::string_view given = text.substr(end + 1);
  return !expected.empty() && given.size() == expected.size() &&
         CRYPTO_memcmp(given.data(), expected.data(), expected.size()) == 0;
}

}  // namespace sweepstake::auth
