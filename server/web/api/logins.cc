#include "server/web/api/logins.h"

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <iterator>

#include "absl/strings/escaping.h"

namespace sweepstake::web {
namespace {

std::string RandomCookie() {
  std::array<char, 32> bytes;
  if (getentropy(bytes.data(), bytes.size()) != 0) std::abort();  // The system has no random bytes.
  return absl::BytesToHexString({bytes.data(), bytes.size()});
}

}  // namespace

std::string Logins::Begin(const std::string& token, int64_t now_s) {
  MakeRoom(token, now_s);
  logins_.push_back({RandomCookie(), token, now_s});
  const Place login = std::prev(logins_.end());
  by_cookie_[login->cookie] = login;
  ++counts_[token];
  return login->cookie;
}

std::optional<std::string> Logins::Find(std::string_view cookie, int64_t now_s) {
  const auto found = by_cookie_.find(std::string(cookie));
  if (found == by_cookie_.end()) return std::nullopt;
  const Place login = found->second;
  if (now_s - login->used_s > kPatienceS) {
    Remove(login);
    return std::nullopt;
  }
  login->used_s = now_s;
  logins_.splice(logins_.end(), logins_, login);
  return login->token;
}

void Logins::End(std::string_view cookie) {
  if (const auto found = by_cookie_.find(std::string(cookie)); found != by_cookie_.end())
    Remove(found->second);
}

void Logins::Remove(Place login) {
  if (--counts_[login->token] == 0) counts_.erase(login->token);
  by_cookie_.erase(login->cookie);
  logins_.erase(login);
}

void Logins::MakeRoom(const std::string& token, int64_t now_s) {
  while (!logins_.empty() &&
         (now_s - logins_.front().used_s > kPatienceS || logins_.size() >= kMaxLogins)) {
    Remove(logins_.begin());
  }
  const auto count = counts_.find(token);
  if (count == counts_.end() || count->second < kMaxOfToken) return;
  Remove(std::find_if(logins_.begin(), logins_.end(),
                      [&](const Login& login) { return login.token == token; }));
}

}  // namespace sweepstake::web
