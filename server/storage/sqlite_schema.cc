#include "server/storage/sqlite_schema.h"

#include <fstream>
#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/match.h"
#include "absl/strings/str_cat.h"
#include "absl/strings/str_split.h"
#include "server/storage/private_file.h"
#include "server/storage/sql/sql_schema.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;

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

// Returns the id in the file store-id; empty if that file is missing.
std::string ReadId(const fs::path& path) {
  std::string id;
  std::ifstream(StoreIdFile(path)) >> id;
  return id;
}

absl::Status WriteId(const fs::path& path, const std::string& id) {
  const fs::path unfinished = StoreIdFile(path).string() + ".new";
  if (absl::Status status = CreatePrivateFile(unfinished); !status.ok()) return status;
  std::ofstream file(unfinished);
  file << id << '\n';
  file.close();
  if (!file) return absl::UnavailableError(absl::StrCat("cannot write ", unfinished.string()));
  return PublishFile(unfinished, StoreIdFile(path));
}

// Returns an error if the id of the database differs from the id in the file store-id: then another
// database was here at the last start. Writes the file if it is missing.
absl::Status CheckId(SqliteDatabase& database, const fs::path& path) {
  const std::string expected = ReadId(path);
  auto id = database.QueryText("SELECT id FROM store");
  if (!id.ok()) return Explain(path, id.status());
  if (expected.empty()) return WriteId(path, *id);
  if (*id == expected) return absl::OkStatus();
  return absl::FailedPreconditionError(absl::StrCat(
      path.string(), " is another database than at the last start (", StoreIdFile(path).string(),
      " has another id); put the former one back, or delete store-id to use this one"));
}

absl::Status CreateTables(SqliteDatabase& database) {
  const std::string sql =
      absl::StrCat("PRAGMA application_id = ", kSqliteApplicationId,
                   "; PRAGMA user_version = ", kSchemaVersion, ";", SqliteSchema());
  return InTransaction(database, [&] { return database.Execute(sql); });
}

absl::Status CreateFile(const fs::path& path) {
  if (!ReadId(path).empty()) {
    return absl::DataLossError(absl::StrCat(path.string(), " is missing, but ",
                                            StoreIdFile(path).string(), " shows that it existed"));
  }
  const fs::path log = path.string() + "-wal";
  std::error_code error;
  if (fs::exists(log, error)) {
    return absl::DataLossError(absl::StrCat(path.string(), " is missing, but its write-ahead log ",
                                            log.filename().string(), " exists"));
  }
  const fs::path unfinished = path.string() + ".new";
  if (absl::Status status = CreatePrivateFile(unfinished); !status.ok()) return status;
  {
    auto database = SqliteDatabase::Open(unfinished.string(), SqliteDatabase::OpenMode::kCreate);
    if (!database.ok()) return Explain(unfinished, database.status());
    absl::Status status = database->Configure();
    if (status.ok()) status = CreateTables(*database);
    if (!status.ok()) return Explain(unfinished, status);
  }
  return PublishFile(unfinished, path);
}

// Returns an error if the file belongs to another program.
absl::Status CheckOwner(SqliteDatabase& database, const fs::path& path) {
  auto id = database.QueryInteger("PRAGMA application_id");
  if (id.ok() && *id == kSqliteApplicationId) return absl::OkStatus();
  if (!id.ok() && id.status().code() != absl::StatusCode::kDataLoss)
    return Explain(path, id.status());
  return absl::DataLossError(absl::StrCat(path.string(), " is not a Sweepstake database"));
}

}  // namespace

absl::Status CheckPriorDatabase(SqliteDatabase& database, const fs::path& path) {
  if (absl::Status status = CheckOwner(database, path); !status.ok()) return status;
  const auto version = database.QueryInteger("PRAGMA user_version");
  if (!version.ok()) return Explain(path, version.status());
  if (*version == kSchemaVersion) return absl::OkStatus();
  if (*version < 1) return absl::DataLossError(absl::StrCat(path.string(), " has no schema"));
  return absl::FailedPreconditionError(
      absl::StrCat(path.string(), " has schema version ", *version,
                   ", but this daemon reads only version ", kSchemaVersion,
                   "; use the version of the daemon that wrote it, or another data directory: "
                   "`sweepstake priors export` and `import` transfer the evidence"));
}

namespace {

// Converts the result of an SQLite check, "ok" or a description of a fault, to a status.
absl::Status Judge(const absl::StatusOr<std::string>& verdict, const fs::path& path) {
  if (!verdict.ok()) return Explain(path, verdict.status());
  if (*verdict == "ok") return absl::OkStatus();
  // SQLite's check reports an unreadable page as if its content were wrong.
  if (absl::StrContains(*verdict, "unable to get the page") ||
      absl::StrContains(*verdict, "failed to get page")) {
    return absl::UnavailableError(
        absl::StrCat(path.string(), " cannot be read (", *verdict, "); check the disk"));
  }
  return absl::DataLossError(absl::StrCat(path.string(), " is corrupt (", *verdict, ")"));
}

}  // namespace

absl::Status CheckPages(SqliteDatabase& database, const fs::path& path) {
  absl::Status status = Judge(database.QueryText("PRAGMA quick_check(1)"), path);
  // quick_check does not compare indices with their tables, and a scene that is missing from its
  // index would be created a second time. Therefore integrity_check runs for all tables except the
  // tables of the audit log, which are most of the file.
  auto tables = database.QueryText(
      "SELECT group_concat(name) FROM sqlite_schema WHERE type = 'table' AND name NOT LIKE "
      "'audit%'");
  if (status.ok() && !tables.ok()) status = Explain(path, tables.status());
  if (!status.ok()) return status;
  for (const absl::string_view table : absl::StrSplit(*tables, ',', absl::SkipEmpty())) {
    status = Judge(database.QueryText(absl::StrCat("PRAGMA integrity_check(", table, ")")), path);
    if (!status.ok()) return status;
  }
  return absl::OkStatus();
}

namespace {

// Syncs the write-ahead log if the database has one. A restored file has none before
// UseWriteAheadLog.
absl::Status SyncLogIfAny(SqliteDatabase& database) {
  auto mode = database.QueryText("PRAGMA journal_mode");
  if (!mode.ok()) return mode.status();
  return *mode == "wal" ? database.SyncLog() : absl::OkStatus();
}

// Syncs the write-ahead log before reading the database. The daemon acknowledges the commits that
// it reads here, so they must be on the disk.
absl::Status PrepareExisting(SqliteDatabase& database, const fs::path& path) {
  absl::Status status = CheckPriorDatabase(database, path);
  if (!status.ok()) return status;
  status = database.Configure();
  if (status.ok()) status = SyncLogIfAny(database);
  if (!status.ok()) return Explain(path, status);
  if (status = CheckPages(database, path); !status.ok()) return status;
  status = UseWriteAheadLog(database);
  if (status.ok()) status = database.EnableDefensive();
  return status.ok() ? status : Explain(path, status);
}

}  // namespace

fs::path StoreIdFile(const fs::path& path) { return path.parent_path() / "store-id"; }

absl::StatusOr<int64_t> CountDamagedRows(SqliteDatabase& database) {
  int64_t count = 0;
  for (const char* table : kHashedTables) {
    auto damaged = database.QueryInteger(
        absl::StrCat("SELECT count(*) FROM ", table, " WHERE hash <> content_hash"));
    if (!damaged.ok()) return damaged.status();
    count += *damaged;
  }
  return count;
}

absl::StatusOr<SqliteDatabase> OpenPriorDatabase(const fs::path& path) {
  std::error_code error;
  if (!fs::exists(path, error)) {
    if (absl::Status status = CreateFile(path); !status.ok()) return status;
  } else if (fs::file_size(path, error) == 0) {
    return absl::DataLossError(absl::StrCat(path.string(), " exists but is empty"));
  }
  auto database = SqliteDatabase::Open(path.string(), SqliteDatabase::OpenMode::kExisting);
  if (!database.ok()) return Explain(path, database.status());
  absl::Status status = PrepareExisting(*database, path);
  if (status.ok()) status = CheckId(*database, path);
  if (!status.ok()) return status;
  return database;
}

absl::StatusOr<SqliteDatabase> OpenPriorDatabaseInMemory() {
  auto database = SqliteDatabase::Open(":memory:", SqliteDatabase::OpenMode::kCreate);
  if (!database.ok()) return database.status();
  absl::Status status = database->Configure();
  if (status.ok()) status = CreateTables(*database);
  // The id decides which sources are chosen, so tests need the same one each time.
  if (status.ok()) status = database->Execute("UPDATE store SET id = 'memory'");
  if (!status.ok()) return status;
  return database;
}

absl::StatusOr<SqliteDatabase> OpenPriorDatabaseToRead(const fs::path& path) {
  auto database = SqliteDatabase::Open(path.string(), SqliteDatabase::OpenMode::kReadOnly);
  if (!database.ok()) return Explain(path, database.status());
  absl::Status status = database->Configure();
  if (status.ok()) status = database->EnableDefensive();
  if (!status.ok()) return Explain(path, status);
  return database;
}

}  // namespace sweepstake::storage
