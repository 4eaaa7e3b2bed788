// The database of tokens. The daemon and `sweepstaked token` have it open at the same time.
//
// A token is 256 random bits as text. Only its SHA-256 is stored: whoever reads the file cannot
// use what is in it. Rows are never removed, so that the file also says who made and who revoked a
// token, and when. A file that is empty, damaged or of another program is refused, since without
// its tokens a daemon on loopback asks nobody for one.
//
// The file tokens-made beside it says that there have been tokens, so that a file that was lost is
// not taken for none.
//
// Used by one thread at a time.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/statusor.h"
#include "server/auth/principal.h"
#include "server/storage/private_file.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::auth {

// What a token is made from.
struct TokenRequest {
  std::string name;  // unique among all tokens, also those that were revoked
  Role role = Role::kWatch;
  std::vector<std::string> projects;      // empty: all
  std::optional<int64_t> expires_unix_s;  // absent: never
  std::string made_by;                    // the user who asks for it
};

struct StoredToken {
  int64_t id = 0;
  TokenRequest request;
  std::string digest;  // SHA-256 of the token, 64 hexadecimal digits
  int64_t created_unix_s = 0;
  std::optional<int64_t> last_used_unix_s;
  std::optional<int64_t> revoked_unix_s;
  std::string revoked_by;

  bool IsValidAt(int64_t unix_s) const {
    return !revoked_unix_s && (!request.expires_unix_s || unix_s < *request.expires_unix_s);
  }
};

// Returns the SHA-256 of the token, 64 hexadecimal digits.
std::string DigestOf(std::string_view token);

class TokenStore {
 public:
  static constexpr size_t kMaxTokens = 10'000;

  // What to do about a missing file where there have been tokens.
  enum class IfLost { kRefuse, kReplace };

  // Opens the file; a missing one is made, for its owner only. Errors: UNAVAILABLE (cannot be made
  // or opened), DATA_LOSS (empty, damaged or of another program), FAILED_PRECONDITION (written by a
  // newer version, or lost).
  static absl::StatusOr<TokenStore> Open(const std::filesystem::path& path,
                                         IfLost if_lost = IfLost::kRefuse);

  // Returns whether there is such a file, or has been one with tokens.
  static bool IsKnown(const std::filesystem::path& path);

  // Makes a token and returns it; it cannot be read again. Errors: INVALID_ARGUMENT (a name or
  // project is none, or it has expired), ALREADY_EXISTS, RESOURCE_EXHAUSTED (kMaxTokens),
  // UNAVAILABLE.
  absl::StatusOr<std::string> Create(const TokenRequest& request, int64_t unix_s);
  // Errors: NOT_FOUND, FAILED_PRECONDITION (it was revoked before), UNAVAILABLE.
  absl::Status Revoke(const std::string& name, const std::string& revoked_by, int64_t unix_s);
  // Returns all tokens, ordered by id.
  absl::StatusOr<std::vector<StoredToken>> Load();
  // Stores when tokens were last used: pairs of id and time.
  absl::Status MarkUsed(std::span<const std::pair<int64_t, int64_t>> uses);
  // Returns whether the file that was opened is still the one of its name: another one may have
  // been put in its place, or it was removed. Error: UNAVAILABLE (it cannot be told).
  absl::StatusOr<bool> IsInPlace() const;
  // Returns a number that differs from that of an earlier call if another connection has changed
  // the file that was opened in between.
  absl::StatusOr<int64_t> Version() { return database_.QueryInteger("PRAGMA data_version"); }

  // Returns whether there have been tokens, as the file beside it says.
  bool WereMade() const;
  // Makes that file, if it is missing; on return it is on disk. Error: UNAVAILABLE.
  absl::Status NoteMade() const;
  // What a file without the tokens that there have been is refused with.
  absl::Status Lost() const;

 private:
  TokenStore(std::filesystem::path path, storage::FileId file, storage::SqliteDatabase database)
      : path_(std::move(path)), file_(file), database_(std::move(database)) {}

  std::filesystem::path path_;
  storage::FileId file_;  // that the database is
  storage::SqliteDatabase database_;
};

}  // namespace sweepstake::auth
