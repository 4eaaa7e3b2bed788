// The logins of browsers: each has a random cookie, for which the daemon keeps the token that was
// logged in with. Nothing of it is on disk: when the daemon ends, so do they. Not thread-safe.
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
  // At either bound the login ends that has not been used for the longest time, of those of the
  // token at its own.
  static constexpr size_t kMaxLogins = 10'000;
  static constexpr size_t kMaxOfToken = 100;
  // A login that has not been used for so long ends.
  static constexpr int64_t kPatienceS = 7 * 86'400;

  // Times are of a clock that does not go back. Returns the cookie, 64 hexadecimal digits.
  std::string Begin(const std::string& token, int64_t now_s);
  // Returns the token, or nothing if there is no such login. It counts as a use.
  std::optional<std::string> Find(std::string_view cookie, int64_t now_s);
  void End(std::string_view cookie);

  size_t size() const { return logins_.size(); }

 private:
  struct Login {
    std::string cookie;
    std::string token;
    int64_t used_s = 0;
  };
  using Place = std::list<Login>::iterator;

  void Remove(Place login);
  void MakeRoom(const std::string& token, int64_t now_s);

  std::list<Login> logins_;  // the one that was used last at the end
  std::unordered_map<std::string, Place> by_cookie_;
  std::unordered_map<std::string, size_t> counts_;  // by token
};

}  // namespace sweepstake::web
