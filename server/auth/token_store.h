// The database of tokens. The daemon and `sweepstaked token` may have it open at the same time.
//
// A token is 256 random bits as text. Only its SHA-256 is stored, so reading the file does not
// reveal tokens. Rows are never removed, so that the file also records who created or revoked a
// token, and when. An empty or damaged file, or one of another program, is refused, because a
// daemon on loopback requires no token if the file has none.
//
// The file tokens-made beside the database records that tokens were created, so that a lost token
// file is detected.
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

// The properties of a token to create.
struct TokenRequest {
  std::string name;  // unique among all tokens, including revoked ones
  Role role = Role::kWatch;
  std::vector<std::string> projects;      // empty: all projects
  std::optional<int64_t> expires_unix_s;  // absent: never
  std::string made_by;                    // user who created it
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

// Returns whether the text begins as a token does.
bool IsToken(std::string_view text);

// Returns the SHA-256 of the token, 64 hexadecimal digits.
std::string DigestOf(std::string_view token);

class TokenStore {
 public:
  static constexpr size_t kMaxTokens = 10'000;

  // What to do if the file is missing although tokens were created.
  enum class IfLost { kRefuse, kReplace };

  // Opens the file; creates a missing one, readable by its owner only. Errors: UNAVAILABLE (cannot
  // be created or opened), DATA_LOSS (empty, damaged or of another program), FAILED_PRECONDITION
  // (written by a newer version, or missing although tokens were created).
  static absl::StatusOr<TokenStore> Open(const std::filesystem::path& path,
                                         IfLost if_lost = IfLost::kRefuse);

  // Returns whether the file exists, or has existed with tokens.
  static bool IsKnown(const std::filesystem::path& path);

  // Creates a token and returns it; it cannot be read again. Errors: INVALID_ARGUMENT (invalid name
  // or project, or the expiry is not in the future), ALREADY_EXISTS, RESOURCE_EXHAUSTED
  // (kMaxTokens), UNAVAILABLE.
  absl::StatusOr<std::string> Create(const TokenRequest& request, int64_t unix_s);
  // Revokes the token with this name. Errors: NOT_FOUND, FAILED_PRECONDITION (already revoked),
  // UNAVAILABLE.
  absl::Status Revoke(const std::string& name, const std::string& revoked_by, int64_t unix_s);
  // Returns all tokens, ordered by id.
  absl::StatusOr<std::vector<StoredToken>> Load();
  // Stores when tokens were last used: pairs of id and time.
  absl::Status MarkUsed(std::span<const std::pair<int64_t, int64_t>> uses);
  // Returns whether the opened file still has its name, that is, it was not replaced or removed.
  // Error: UNAVAILABLE (the check failed).
  absl::StatusOr<bool> IsInPlace() const;
  // Returns a number that changes if another connection has changed the opened file.
  absl::StatusOr<int64_t> Version() { return database_.QueryInteger("PRAGMA data_version"); }

  // Returns whether tokens were ever created, according to the file tokens-made.
  bool WereMade() const;
  // Returns the error for a file whose tokens were lost.
  absl::Status Lost() const;

 private:
  // Creates the file tokens-made if it is missing; it is on disk on return. Error: UNAVAILABLE.
  absl::Status NoteMade() const;
  // Runs in the caller's transaction.
  absl::Status Insert(const TokenRequest& request, const std::string& token, int64_t unix_s);
  TokenStore(std::filesystem::path path, storage::FileId file, storage::SqliteDatabase database)
      : path_(std::move(path)), file_(file), database_(std::move(database)) {}

  std::filesystem::path path_;
  storage::FileId file_;  // identity of the opened file
  storage::SqliteDatabase database_;
};

}  // namespace sweepstake::auth
