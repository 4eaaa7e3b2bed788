// The logins of browsers: each has a random cookie, which stands for the token that was sent with
// the login. Logins are in memory only and end with the process. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>

namespace sweepstake::web {

class Logins {
 public:
  // A login beyond kMaxLogins ends the least recently used one. A login beyond kMaxOfToken ends the
  // least recently used one of the same token.
  static constexpr size_t kMaxLogins = 10'000;
  static constexpr size_t kMaxOfToken = 100;
  // A login ends when it was not used for this time.
  static constexpr int64_t kPatienceS = 7 * 86'400;

  // Begins a login. Returns its cookie: 64 hexadecimal digits.
  std::string Begin(const std::string& token, int64_t unix_now_s);
  // Returns the token, or nothing if there is no such login. This counts as a use.
  std::optional<std::string> Find(std::string_view cookie, int64_t unix_now_s);
  void End(std::string_view cookie);

  size_t size() const { return logins_.size(); }

 private:
  struct Login {
    std::string cookie_digest;  // auth::DigestOf
    std::string token;
    int64_t used_unix_s = 0;
  };
  using Place = std::list<Login>::iterator;

  void Remove(Place login);
  void MakeRoom(const std::string& token, int64_t unix_now_s);

  std::list<Login> logins_;  // ordered by the last use; the newest use is at the end
  // Logins by digest of the cookie, so that the time of a lookup reveals nothing about cookies.
  std::unordered_map<std::string, Place> by_cookie_digest_;
  std::unordered_map<std::string, size_t> counts_;  // by token
};

}  // namespace sweepstake::web
