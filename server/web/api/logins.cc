#include "server/web/api/logins.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "absl/strings/escaping.h"
#include "server/auth/token_store.h"

namespace sweepstake::web {
namespace {

std::string RandomCookie() {
  std::array<char, 32> bytes;
  if (getentropy(bytes.data(), bytes.size()) != 0) std::abort();  // The system has no random bytes.
  return absl::BytesToHexString({bytes.data(), bytes.size()});
}

}  // namespace

std::string Logins::Begin(const std::string& token, int64_t unix_now_s) {
  MakeRoom(token, unix_now_s);
  std::string cookie = RandomCookie();
  logins_.push_back({auth::DigestOf(cookie), token, unix_now_s});
  by_cookie_digest_[logins_.back().cookie_digest] = std::prev(logins_.end());
  ++counts_[token];
  return cookie;
}

std::optional<std::string> Logins::Find(std::string_view cookie, int64_t unix_now_s) {
  const auto found = by_cookie_digest_.find(auth::DigestOf(cookie));
  if (found == by_cookie_digest_.end()) return std::nullopt;
  const Place login = found->second;
  if (unix_now_s - login->used_unix_s > kPatienceS) {
    Remove(login);
    return std::nullopt;
  }
  login->used_unix_s = unix_now_s;
  logins_.splice(logins_.end(), logins_, login);
  return login->token;
}

void Logins::End(std::string_view cookie) {
  if (const auto found = by_cookie_digest_.find(auth::DigestOf(cookie));
      found != by_cookie_digest_.end())
    Remove(found->second);
}

void Logins::Remove(Place login) {
  if (--counts_[login->token] == 0) counts_.erase(login->token);
  by_cookie_digest_.erase(login->cookie_digest);
  logins_.erase(login);
}

void Logins::MakeRoom(const std::string& token, int64_t unix_now_s) {
  while (!logins_.empty() &&
         (unix_now_s - logins_.front().used_unix_s > kPatienceS || logins_.size() >= kMaxLogins)) {
    Remove(logins_.begin());
  }
  const auto count = counts_.find(token);
  if (count == counts_.end() || count->second < kMaxOfToken) return;
  Remove(std::find_if(logins_.begin(), logins_.end(),
                      [&](const Login& login) { return login.token == token; }));
}

}  // namespace sweepstake::web
