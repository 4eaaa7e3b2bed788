#include "server/auth/token_store.h"

#include <fcntl.h>
#include <openssl/rand.h>
#include <openssl/sha.h>
#include <unistd.h>

#include <algorithm>
#include <array>
#include <cerrno>
#include <cstdio>
#include <system_error>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "absl/strings/str_split.h"
#include "engine_client/text/names.h"
#include "server/storage/data_directory.h"
#include "server/storage/private_file.h"

namespace sweepstake::auth {
namespace {

namespace fs = std::filesystem;
using storage::Explain;
using storage::SqliteDatabase;
using storage::SqlRow;

constexpr int64_t kApplicationId = 0x53575431;  // "SWT1"
constexpr int64_t kSchemaVersion = 1;
constexpr size_t kTokenBytes = 32;
// Makes tokens recognisable, for instance for programs that search published files for secrets.
constexpr const char* kTokenPrefix = "sweepstake_";
// The content of the column `projects` that means all projects. Otherwise the column has one
// project per line.
constexpr const char* kAllProjects = "*";
constexpr size_t kMaxProjects = 100;

// A time of 0 means that the event has not happened.
constexpr const char* kSchema = R"sql(
  CREATE TABLE token (
    id INTEGER PRIMARY KEY AUTOINCREMENT,
    name TEXT NOT NULL UNIQUE CHECK (length(CAST(name AS BLOB)) BETWEEN 1 AND 128),
    digest TEXT NOT NULL UNIQUE CHECK (length(digest) = 64),
    role TEXT NOT NULL CHECK (role IN ('player', 'ticket', 'ingest', 'watch', 'operator', 'admin')),
    projects TEXT NOT NULL CHECK (length(CAST(projects AS BLOB)) BETWEEN 1 AND 65536),
    created_unix_s INTEGER NOT NULL CHECK (created_unix_s BETWEEN 0 AND 9223372036854775807),
    created_by TEXT NOT NULL CHECK (length(CAST(created_by AS BLOB)) BETWEEN 1 AND 128),
    expires_unix_s INTEGER NOT NULL CHECK (expires_unix_s BETWEEN 0 AND 9223372036854775807),
    last_used_unix_s INTEGER NOT NULL DEFAULT 0
      CHECK (last_used_unix_s BETWEEN 0 AND 9223372036854775807),
    revoked_unix_s INTEGER NOT NULL DEFAULT 0
      CHECK (revoked_unix_s BETWEEN 0 AND 9223372036854775807),
    revoked_by TEXT NOT NULL DEFAULT '' CHECK (length(CAST(revoked_by AS BLOB)) BETWEEN 0 AND 128)
  ) STRICT;
)sql";

constexpr const char* kInsert = R"sql(
  INSERT INTO token (name, digest, role, projects, created_unix_s, created_by, expires_unix_s)
  VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7) ON CONFLICT (name) DO NOTHING RETURNING id)sql";
constexpr const char* kSelect = R"sql(
  SELECT id, name, digest, role, projects, created_unix_s, created_by, expires_unix_s,
         last_used_unix_s, revoked_unix_s, revoked_by
  FROM token ORDER BY id)sql";

// The name contains the process id, because other processes may be creating the same file.
fs::path UnfinishedName(const fs::path& path) {
  return absl::StrCat(path.string(), ".new-", getpid());
}

fs::path NoteBeside(const fs::path& path) {
  return path.parent_path() / storage::DataDirectory::kTokensMadeName;
}

bool Exists(const fs::path& path) {
  std::error_code unknown;  // a file that cannot be examined cannot be opened either
  return fs::exists(path, unknown);
}

// The error for a file whose tokens were lost.
absl::Status LostFile(const fs::path& path) {
  return absl::FailedPreconditionError(absl::StrCat(
      path.string(),
      Exists(path) ? " contains no tokens, but tokens were created earlier"
                   : " is missing, but tokens were created earlier",
      ": restore a copy of the file; or create new tokens with `sweepstaked token create`, which "
      "invalidates the earlier ones; to run without tokens, stop the daemon and remove ",
      Exists(path) ? absl::StrCat(path.string(), " and ") : "", NoteBeside(path).string()));
}

// Gives the file `unfinished` the name `path` unless `path` exists. First tries a hard link, which
// FAT lacks, then a rename that does not replace, which NFS lacks. Returns 0 or the errno.
int NameUnlessThere(const fs::path& unfinished, const fs::path& path) {
  if (link(unfinished.c_str(), path.c_str()) == 0) return 0;
  const int why = errno;
  if (why == EEXIST) return why;
  if (renameat2(AT_FDCWD, unfinished.c_str(), AT_FDCWD, path.c_str(), RENAME_NOREPLACE) == 0)
    return 0;
  return errno == EEXIST ? EEXIST : why;
}

// Creates an empty token database, which is complete when it appears at `path`. If another process
// creates `path` at the same time, its file stays.
absl::Status CreateFile(const fs::path& path) {
  const fs::path unfinished = UnfinishedName(path);
  absl::Status status = storage::CreatePrivateFile(unfinished);
  if (!status.ok()) return status;
  {
    auto database = SqliteDatabase::Open(unfinished.string(), SqliteDatabase::OpenMode::kCreate);
    status = database.status();
    if (status.ok()) status = database->Configure();
    if (status.ok())
      status =
          database->Execute(absl::StrCat("PRAGMA application_id = ", kApplicationId,
                                         "; PRAGMA user_version = ", kSchemaVersion, ";", kSchema));
    if (!status.ok()) return Explain(unfinished, status);
  }
  const int problem = NameUnlessThere(unfinished, path);
  std::error_code ignored;
  fs::remove(unfinished, ignored);
  if (problem == 0 || problem == EEXIST) return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrCat(path.string(), ": ", std::system_category().message(problem)));
}

absl::Status CheckFile(SqliteDatabase& database, const fs::path& path) {
  const auto damaged = [&](absl::string_view what) {
    return absl::DataLossError(absl::StrCat(
        path.string(), " ", what, "; restore a copy, or remove it and create new tokens"));
  };
  if (absl::Status status = database.Configure(); !status.ok() && !absl::IsDataLoss(status))
    return Explain(path, status);
  auto id = database.QueryInteger("PRAGMA application_id");
  if (!id.ok() && !absl::IsDataLoss(id.status())) return Explain(path, id.status());
  if (!id.ok() || *id != kApplicationId) return damaged("is not a token database");
  auto version = database.QueryInteger("PRAGMA user_version");
  if (!version.ok()) return Explain(path, version.status());
  if (*version != kSchemaVersion) {
    return absl::FailedPreconditionError(
        absl::StrCat(path.string(), " has schema ", *version, ", but this program supports schema ",
                     kSchemaVersion, "; use the version of the program that wrote it"));
  }
  auto verdict = database.QueryText("PRAGMA integrity_check(1)");
  if (!verdict.ok() && !absl::IsDataLoss(verdict.status())) return Explain(path, verdict.status());
  if (!verdict.ok() || *verdict != "ok") return damaged("is damaged");
  return database.EnableDefensive();
}

absl::Status Check(const TokenRequest& request, int64_t unix_s) {
  if (!text::IsName(request.name)) {
    return absl::InvalidArgumentError(
        "a token's name must have 1 to 128 bytes and no control characters");
  }
  if (request.projects.size() > kMaxProjects)
    return absl::InvalidArgumentError(absl::StrCat("a token has at most ", kMaxProjects,
                                                   " projects; leave them out to allow all"));
  for (const std::string& project : request.projects) {
    if (!text::IsName(project) || project == kAllProjects)
      return absl::InvalidArgumentError(
          "a project name must have 1 to 128 bytes and no control characters; omit projects to "
          "allow all");
  }
  if (request.expires_unix_s && *request.expires_unix_s <= unix_s)
    return absl::InvalidArgumentError("the expiry time of a new token must be in the future");
  return absl::OkStatus();
}

absl::StatusOr<std::string> RandomToken() {
  std::array<unsigned char, kTokenBytes> bytes{};
  if (RAND_bytes(bytes.data(), static_cast<int>(bytes.size())) != 1)
    return absl::UnavailableError("the system returned no random numbers; try again");
  return absl::StrCat(kTokenPrefix,
                      absl::WebSafeBase64Escape(absl::string_view(
                          reinterpret_cast<const char*>(bytes.data()), bytes.size())));
}

std::string TextOf(const std::vector<std::string>& projects) {
  return projects.empty() ? kAllProjects : absl::StrJoin(projects, "\n");
}

std::vector<std::string> ProjectsOf(const std::string& text) {
  if (text == kAllProjects) return {};
  return absl::StrSplit(text, '\n');
}

// Returns the role called `name`. REQUIRES: it exists, as the CHECK of the column ensures.
Role RoleOf(const std::string& name) {
  const auto* const found = std::find(kRoleNames.begin(), kRoleNames.end(), name);
  return static_cast<Role>(found - kRoleNames.begin());
}

std::optional<int64_t> TimeOf(int64_t unix_s) {
  if (unix_s == 0) return std::nullopt;
  return unix_s;
}

StoredToken TokenOf(const SqlRow& row) {
  StoredToken token;
  token.id = row.Integer(0);
  token.request = {.name = row.Text(1),
                   .role = RoleOf(row.Text(3)),
                   .projects = ProjectsOf(row.Text(4)),
                   .expires_unix_s = TimeOf(row.Integer(7)),
                   .made_by = row.Text(6)};
  token.digest = row.Text(2);
  token.created_unix_s = row.Integer(5);
  token.last_used_unix_s = TimeOf(row.Integer(8));
  token.revoked_unix_s = TimeOf(row.Integer(9));
  token.revoked_by = row.Text(10);
  return token;
}

}  // namespace

bool IsToken(std::string_view text) { return text.starts_with(kTokenPrefix); }

std::string DigestOf(std::string_view token) {
  std::array<unsigned char, SHA256_DIGEST_LENGTH> digest{};
  SHA256(reinterpret_cast<const unsigned char*>(token.data()), token.size(), digest.data());
  return absl::BytesToHexString(
      absl::string_view(reinterpret_cast<const char*>(digest.data()), digest.size()));
}

absl::StatusOr<TokenStore> TokenStore::Open(const fs::path& path, IfLost if_lost) {
  if (!Exists(path)) {
    if (if_lost == IfLost::kRefuse && Exists(NoteBeside(path))) return LostFile(path);
    if (absl::Status status = CreateFile(path); !status.ok()) return status;
  }
  // The identity is read before the file is opened, so that IsInPlace detects a file that was
  // replaced in between.
  const auto file = storage::FileId::Of(path);
  if (!file.ok()) return file.status();
  auto database = SqliteDatabase::Open(path.string(), SqliteDatabase::OpenMode::kExisting);
  if (!database.ok()) return Explain(path, database.status());
  if (absl::Status status = CheckFile(*database, path); !status.ok()) return status;
  return TokenStore(path, *file, *std::move(database));
}

absl::StatusOr<bool> TokenStore::IsInPlace() const {
  const auto now = storage::FileId::Of(path_);
  if (!now.ok()) return now.status();
  return *now == file_;
}

bool TokenStore::IsKnown(const fs::path& path) { return Exists(path) || Exists(NoteBeside(path)); }

bool TokenStore::WereMade() const { return Exists(NoteBeside(path_)); }

absl::Status TokenStore::NoteMade() const {
  if (WereMade()) return absl::OkStatus();
  const fs::path unfinished = UnfinishedName(NoteBeside(path_));
  absl::Status status = storage::CreatePrivateFile(unfinished);
  if (status.ok()) status = storage::PublishFile(unfinished, NoteBeside(path_));
  return status;
}

absl::Status TokenStore::Lost() const { return LostFile(path_); }

absl::StatusOr<std::string> TokenStore::Create(const TokenRequest& request, int64_t unix_s) {
  absl::Status status = Check(request, unix_s);
  if (!status.ok()) return status;
  auto token = RandomToken();
  if (!token.ok()) return token.status();
  status = InTransaction(database_, [&] { return Insert(request, *token, unix_s); });
  if (!status.ok()) return status;
  return token;
}

absl::Status TokenStore::Insert(const TokenRequest& request, const std::string& token,
                                int64_t unix_s) {
  const auto count = database_.QueryInteger("SELECT count(*) FROM token");
  if (!count.ok()) return count.status();
  if (*count >= static_cast<int64_t>(kMaxTokens))
    return absl::ResourceExhaustedError(
        absl::StrCat("the token file already has the maximum of ", kMaxTokens, " tokens"));
  const auto id = database_.ReadInteger(kInsert, request.name, DigestOf(token),
                                        NameOf(request.role), TextOf(request.projects), unix_s,
                                        request.made_by, request.expires_unix_s.value_or(0));
  if (!id.ok()) return id.status();
  if (*id == 0) {
    return absl::AlreadyExistsError(absl::StrCat("there is, or was, a token with the name ",
                                                 text::PrintableLine(request.name),
                                                 "; choose another name"));
  }
  // Writes the note (the file tokens-made) before the commit, so that no token exists without a
  // note, and after all other steps that can fail, so that no note exists without a token.
  return NoteMade();
}

absl::Status TokenStore::Revoke(const std::string& name, const std::string& revoked_by,
                                int64_t unix_s) {
  const auto tokens = Load();
  if (!tokens.ok()) return tokens.status();
  const auto found = std::find_if(tokens->begin(), tokens->end(), [&](const StoredToken& token) {
    return token.request.name == name;
  });
  if (found == tokens->end()) {
    return absl::NotFoundError(absl::StrCat("there is no token with the name ",
                                            text::PrintableLine(name),
                                            "; `sweepstaked token list` shows them"));
  }
  if (found->revoked_unix_s)
    return absl::FailedPreconditionError("this token has already been revoked");
  return database_.Run(
      "UPDATE token SET revoked_unix_s = ?2, revoked_by = ?3 WHERE id = ?1 AND revoked_unix_s = 0",
      found->id, unix_s, revoked_by);
}

absl::StatusOr<std::vector<StoredToken>> TokenStore::Load() {
  return database_.Collect<std::vector<StoredToken>>(
      kSelect, [](const SqlRow& row, auto& tokens) { tokens.push_back(TokenOf(row)); });
}

absl::Status TokenStore::MarkUsed(std::span<const std::pair<int64_t, int64_t>> uses) {
  storage::SqlBatch batch;
  for (const auto& [id, unix_s] : uses) batch.Add(id, unix_s);
  return InTransaction(database_, [&] {
    return database_.Run("UPDATE token SET last_used_unix_s = ?2 WHERE id = ?1", batch);
  });
}

}  // namespace sweepstake::auth
