#include "server/web/api/logins.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>
#include <utility>

#include "absl/strings/escaping.h"
#include "server/auth/token_store.h"
#include "server/web/api/token_seal.h"

namespace sweepstake::web {
namespace {

std::string RandomCookie() {
  std::array<char, 32> bytes;
  if (getentropy(bytes.data(), bytes.size()) != 0) std::abort();  // The system has no random bytes.
  return absl::BytesToHexString({bytes.data(), bytes.size()});
}

}  // namespace

Logins::Logins(std::vector<Login> kept) {
  for (Login& login : kept) {
    if (!by_cookie_digest_.contains(login.cookie_digest)) Add(std::move(login));
  }
}

std::string Logins::Begin(const std::string& token, int64_t unix_now_s) {
  const std::string token_digest = auth::DigestOf(token);
  MakeRoom(token_digest, unix_now_s);
  std::string cookie = RandomCookie();
  Add({auth::DigestOf(cookie), token_digest, SealToken(cookie, token), unix_now_s});
  has_changed_ = true;
  return cookie;
}

std::optional<std::string> Logins::Find(std::string_view cookie, int64_t unix_now_s) {
  const auto found = by_cookie_digest_.find(auth::DigestOf(cookie));
  if (found == by_cookie_digest_.end()) return std::nullopt;
  const Place login = found->second;
  const int64_t unused_s = unix_now_s - login->used_unix_s;
  auto token = OpenToken(cookie, login->sealed_token);
  if (unused_s > kPatienceS || !token) {
    Remove(login);
    return std::nullopt;
  }
  login->used_unix_s = unix_now_s;
  logins_.splice(logins_.end(), logins_, login);
  return token;
}

void Logins::End(std::string_view cookie) {
  if (const auto found = by_cookie_digest_.find(auth::DigestOf(cookie));
      found != by_cookie_digest_.end())
    Remove(found->second);
}

bool Logins::TakeChanged(int64_t unix_now_s) {
  const bool has_old_uses = !logins_.empty() && unix_now_s - taken_unix_s_ >= kTellUsesS;
  if (!has_changed_ && !has_old_uses) return false;
  has_changed_ = false;
  taken_unix_s_ = unix_now_s;
  return true;
}

void Logins::Add(Login login) {
  logins_.push_back(std::move(login));
  const Place added = std::prev(logins_.end());
  by_cookie_digest_[added->cookie_digest] = added;
  ++counts_[added->token_digest];
}

void Logins::Remove(Place login) {
  if (--counts_[login->token_digest] == 0) counts_.erase(login->token_digest);
  by_cookie_digest_.erase(login->cookie_digest);
  logins_.erase(login);
  has_changed_ = true;
}

void Logins::MakeRoom(const std::string& token_digest, int64_t unix_now_s) {
  while (!logins_.empty() &&
         (unix_now_s - logins_.front().used_unix_s > kPatienceS || logins_.size() >= kMaxLogins)) {
    Remove(logins_.begin());
  }
  const auto count = counts_.find(token_digest);
  if (count == counts_.end() || count->second < kMaxOfToken) return;
  Remove(std::find_if(logins_.begin(), logins_.end(),
                      [&](const Login& login) { return login.token_digest == token_digest; }));
}

}  // namespace sweepstake::web
