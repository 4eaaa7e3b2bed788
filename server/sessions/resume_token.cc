#include "server/sessions/resume_token.h"

#include <openssl/crypto.h>
#include <openssl/hmac.h>
#include <openssl/sha.h>

#include "absl/strings/numbers.h"
#include "absl/strings/str_cat.h"

namespace sweepstake::sessions {

// A resume token is the HMAC, then a slash and the id of the client's token in plain text. An id of
// 0 is omitted together with the slash.
std::string ResumeTokenOf(const std::string& session_id, int64_t token_id,
                          const std::string& secret) {
  const std::string suffix = token_id == 0 ? "" : absl::StrCat("/", token_id);
  const std::string ids = session_id + suffix;
  std::string token(EVP_MAX_MD_SIZE, '\0');
  unsigned int size = 0;
  HMAC(EVP_sha256(), secret.data(), static_cast<int>(secret.size()),
       reinterpret_cast<const unsigned char*>(ids.data()), ids.size(),
       reinterpret_cast<unsigned char*>(token.data()), &size);
  token.resize(size);
  return token + suffix;
}

std::optional<int64_t> TokenOfSession(const std::string& session_id, const std::string& given,
                                      const std::string& secret) {
  int64_t token_id = 0;
  if (given.size() > SHA256_DIGEST_LENGTH &&
      !absl::SimpleAtoi(given.substr(SHA256_DIGEST_LENGTH + 1), &token_id)) {
    return std::nullopt;
  }
  const std::string token = ResumeTokenOf(session_id, token_id, secret);
  if (given.size() != token.size() ||
      CRYPTO_memcmp(given.data(), token.data(), token.size()) != 0) {
    return std::nullopt;
  }
  return token_id;
}

}  // namespace sweepstake::sessions
