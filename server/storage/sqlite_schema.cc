#include "server/storage/sqlite_schema.h"

#include <fcntl.h>
#include <unistd.h>

#include <array>
#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;

// Step i migrates from version i to i + 1. A released step is never changed. Every bound has two
// sides, because `alpha >= 0` alone would accept +Inf.
constexpr std::array<const char*, 2> kMigrations = {R"sql(
  CREATE TABLE source (
    id INTEGER PRIMARY KEY,
    name TEXT NOT NULL UNIQUE CHECK (length(CAST(name AS BLOB)) BETWEEN 1 AND 128),
    is_session INTEGER NOT NULL CHECK (is_session IN (0, 1)),
    revoked INTEGER NOT NULL CHECK (revoked IN (0, 1)),
    commit_sequence INTEGER NOT NULL CHECK (commit_sequence BETWEEN 0 AND 9223372036854775807),
    message_sequence INTEGER NOT NULL CHECK (message_sequence BETWEEN 0 AND 9223372036854775807),
    explored_arm_count INTEGER NOT NULL CHECK (explored_arm_count BETWEEN 0 AND 4294967295),
    decision_count INTEGER NOT NULL CHECK (decision_count BETWEEN 0 AND 9223372036854775807),
    frame_count INTEGER NOT NULL CHECK (frame_count BETWEEN 0 AND 9223372036854775807),
    seed INTEGER NOT NULL
  ) STRICT;

  CREATE TABLE evidence_key (
    id INTEGER PRIMARY KEY,
    project TEXT NOT NULL CHECK (length(CAST(project AS BLOB)) BETWEEN 1 AND 128),
    scene TEXT NOT NULL CHECK (length(CAST(scene AS BLOB)) BETWEEN 1 AND 128),
    context_bucket TEXT NOT NULL CHECK (length(CAST(context_bucket AS BLOB)) BETWEEN 0 AND 128),
    arm TEXT NOT NULL CHECK (length(CAST(arm AS BLOB)) BETWEEN 1 AND 128),
    backend_version INTEGER NOT NULL CHECK (backend_version BETWEEN 1 AND 4294967295),
    machine_class TEXT NOT NULL CHECK (length(CAST(machine_class AS BLOB)) BETWEEN 0 AND 128),
    reward_version INTEGER NOT NULL CHECK (reward_version BETWEEN 1 AND 4294967295),
    UNIQUE (project, scene, context_bucket, arm, backend_version, machine_class, reward_version)
  ) STRICT;

  CREATE TABLE evidence (
    key_id INTEGER NOT NULL REFERENCES evidence_key (id),
    source_id INTEGER NOT NULL REFERENCES source (id),
    sequence INTEGER NOT NULL CHECK (sequence BETWEEN 1 AND 9223372036854775807),
    alpha REAL NOT NULL CHECK (alpha >= 0 AND alpha < 1e15),
    beta REAL NOT NULL CHECK (beta >= 0 AND beta < 1e15),
    window_count INTEGER NOT NULL CHECK (window_count BETWEEN 0 AND 9223372036854775807),
    bail_out_count INTEGER NOT NULL CHECK (bail_out_count BETWEEN 0 AND 9223372036854775807),
    PRIMARY KEY (key_id, source_id)
  ) STRICT, WITHOUT ROWID;

  CREATE INDEX evidence_by_source ON evidence (source_id);
)sql",
                                                    R"sql(
  CREATE TABLE audit_segment (
    id INTEGER PRIMARY KEY,
    session TEXT NOT NULL CHECK (length(CAST(session AS BLOB)) BETWEEN 1 AND 128),
    segment INTEGER NOT NULL CHECK (segment BETWEEN 1 AND 4294967295),
    project TEXT NOT NULL CHECK (length(CAST(project AS BLOB)) BETWEEN 1 AND 128),
    scene TEXT NOT NULL CHECK (length(CAST(scene AS BLOB)) BETWEEN 1 AND 128),
    unix_start_ms INTEGER NOT NULL,
    row_count INTEGER NOT NULL CHECK (row_count BETWEEN 1 AND 9223372036854775807),
    UNIQUE (session, segment)
  ) STRICT;

  CREATE TABLE audit_row (
    segment_id INTEGER NOT NULL REFERENCES audit_segment (id),
    number INTEGER NOT NULL CHECK (number BETWEEN 1 AND 9223372036854775807),
    text TEXT NOT NULL CHECK (length(CAST(text AS BLOB)) BETWEEN 1 AND 65536),
    UNIQUE (segment_id, number)
  ) STRICT;
)sql"};

absl::Status Explain(const fs::path& path, const absl::Status& status) {
  return {status.code(), absl::StrCat(path.string(), ": ", status.message())};
}

absl::Status Configure(SqliteDatabase& database) {
  return database.Execute(R"sql(
    PRAGMA busy_timeout = 2000;
    PRAGMA foreign_keys = ON;
    PRAGMA trusted_schema = OFF;
    PRAGMA cell_size_check = ON;
    PRAGMA synchronous = FULL;
  )sql");
}

absl::Status UseWriteAheadLog(SqliteDatabase& database) {
  auto mode = database.QueryText("PRAGMA journal_mode = WAL");
  if (!mode.ok()) return mode.status();
  if (*mode != "wal") {
    return absl::UnavailableError(
        absl::StrCat("cannot use a write-ahead log here (journal mode stays ", *mode,
                     "); put the data on a local, writable disk"));
  }
  return absl::OkStatus();
}

absl::Status Migrate(SqliteDatabase& database, int64_t from) {
  for (auto version = static_cast<size_t>(from); version < kMigrations.size(); ++version) {
    SqliteTransaction transaction(database);
    absl::Status status = transaction.begun();
    if (status.ok()) status = database.Execute(kMigrations[version]);
    if (status.ok()) status = database.Execute(absl::StrCat("PRAGMA user_version = ", version + 1));
    if (status.ok()) status = transaction.Commit();
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

// Syncs the directory, so that a file renamed into it survives a power failure.
absl::Status SyncDirectory(const fs::path& path) {
  const std::string name = path.empty() ? "." : path.string();
  const int directory = open(name.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC);
  const bool synced = directory >= 0 && fsync(directory) == 0;
  const int why = errno;
  if (directory >= 0) close(directory);
  if (synced) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat(name, ": ", std::system_category().message(why)));
}

absl::Status CreateFile(const fs::path& path) {
  const fs::path log = path.string() + "-wal";
  std::error_code error;
  if (fs::exists(log, error)) {
    return absl::DataLossError(
        absl::StrCat(path.string(), " is missing but its log ", log.filename().string(),
                     " is there; restore the file, or move the log away to start anew"));
  }
  const fs::path unfinished = path.string() + ".new";
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm", "-journal"})
    fs::remove(unfinished.string() + suffix, ignored);
  {
    auto database = SqliteDatabase::Open(unfinished.string(), SqliteDatabase::OpenMode::kCreate);
    if (!database.ok()) return Explain(unfinished, database.status());
    absl::Status status = Configure(*database);
    if (status.ok())
      status = database->Execute(absl::StrCat("PRAGMA application_id = ", kSqliteApplicationId));
    if (status.ok()) status = Migrate(*database, 0);
    if (!status.ok()) return Explain(unfinished, status);
  }
  fs::rename(unfinished, path, error);
  if (error) return absl::UnavailableError(absl::StrCat(path.string(), ": ", error.message()));
  return SyncDirectory(path.parent_path());
}

// Returns an error if the file belongs to another program.
absl::Status CheckOwner(SqliteDatabase& database, const fs::path& path) {
  auto id = database.QueryInteger("PRAGMA application_id");
  if (id.ok() && *id == kSqliteApplicationId) return absl::OkStatus();
  if (!id.ok() && id.status().code() != absl::StatusCode::kDataLoss)
    return Explain(path, id.status());
  return absl::DataLossError(
      absl::StrCat(path.string(),
                   " is not a Sweepstake database; move it away, or name another data directory"));
}

absl::Status CheckVersion(int64_t version, const fs::path& path) {
  if (version >= 1 && version <= SqliteSchemaVersion()) return absl::OkStatus();
  if (version < 1)
    return absl::DataLossError(
        absl::StrCat(path.string(), " has no schema; restore it from a backup"));
  return absl::FailedPreconditionError(absl::StrCat(
      path.string(), " was written by a newer daemon (schema ", version, ", this one knows ",
      SqliteSchemaVersion(), "); use that daemon, or another data directory"));
}

absl::Status CheckPages(SqliteDatabase& database, const fs::path& path) {
  auto verdict = database.QueryText("PRAGMA quick_check(1)");
  if (!verdict.ok()) return Explain(path, verdict.status());
  if (*verdict == "ok") return absl::OkStatus();
  return absl::DataLossError(absl::StrCat(path.string(), " is corrupt (", *verdict,
                                          "); restore it from a backup, or move it away"));
}

absl::Status PrepareExisting(SqliteDatabase& database, const fs::path& path) {
  if (absl::Status status = CheckOwner(database, path); !status.ok()) return status;
  if (absl::Status status = Configure(database); !status.ok()) return Explain(path, status);
  auto version = database.QueryInteger("PRAGMA user_version");
  if (!version.ok()) return Explain(path, version.status());
  if (absl::Status status = CheckVersion(*version, path); !status.ok()) return status;
  if (absl::Status status = CheckPages(database, path); !status.ok()) return status;
  absl::Status status = UseWriteAheadLog(database);
  if (status.ok()) status = Migrate(database, *version);
  if (status.ok()) status = database.EnableDefensive();
  return status.ok() ? status : Explain(path, status);
}

}  // namespace

int64_t SqliteSchemaVersion() { return static_cast<int64_t>(kMigrations.size()); }

absl::StatusOr<SqliteDatabase> OpenPriorDatabase(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    if (absl::Status status = CreateFile(path); !status.ok()) return status;
  } else if (fs::file_size(path, error) == 0) {
    return absl::DataLossError(
        absl::StrCat(path.string(),
                     " exists but is empty; restore it from a backup, or delete it to start anew"));
  }
  auto database = SqliteDatabase::Open(path.string(), SqliteDatabase::OpenMode::kExisting);
  if (!database.ok()) return Explain(path, database.status());
  if (absl::Status status = PrepareExisting(*database, path); !status.ok()) return status;
  return database;
}

}  // namespace sweepstake::storage
