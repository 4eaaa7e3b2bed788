// The logins of browsers: each has a random cookie, which opens the token that was logged in with.
// Neither the cookies nor the tokens can be told from what is kept of them. Not thread-safe.
#pragma once

#include <cstddef>
#include <cstdint>
#include <list>
#include <optional>
#include <string>
#include <string_view>
#include <unordered_map>
#include <vector>

namespace sweepstake::web {

// What is kept of a login.
struct Login {
  std::string cookie_digest;  // hexadecimal, as auth::DigestOf
  std::string token_digest;   // likewise
  std::string sealed_token;   // SealToken with the cookie
  int64_t used_unix_s = 0;    // last time
};

class Logins {
 public:
  // At either bound the login ends that has not been used for the longest time, of those of the
  // token at its own.
  static constexpr size_t kMaxLogins = 10'000;
  static constexpr size_t kMaxOfToken = 100;
  // A login that has not been used for so long ends.
  static constexpr int64_t kPatienceS = 7 * 86'400;
  // Uses alone count as a change after so long a time.
  static constexpr int64_t kTellUsesS = 86'400;

  // Begins with those that another object had, in its order.
  explicit Logins(std::vector<Login> kept = {});

  // Returns the cookie, 64 hexadecimal digits.
  std::string Begin(const std::string& token, int64_t unix_now_s);
  // Returns the token, or nothing if there is no such login. It counts as a use.
  std::optional<std::string> Find(std::string_view cookie, int64_t unix_now_s);
  void End(std::string_view cookie);

  // Returns whether there is something to keep that was not there at its last true.
  bool TakeChanged(int64_t unix_now_s);
  // The one used last at the end.
  std::vector<Login> All() const { return {logins_.begin(), logins_.end()}; }
  size_t size() const { return logins_.size(); }

 private:
  using Place = std::list<Login>::iterator;

  void Add(Login login);
  void Remove(Place login);
  void MakeRoom(const std::string& token_digest, int64_t unix_now_s);

  std::list<Login> logins_;  // the one that was used last at the end
  std::unordered_map<std::string, Place> by_cookie_digest_;
  std::unordered_map<std::string, size_t> counts_;  // by the token's digest
  bool has_changed_ = false;
  int64_t taken_unix_s_ = 0;
};

}  // namespace sweepstake::web
