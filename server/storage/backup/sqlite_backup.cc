#include "server/storage/backup/sqlite_backup.h"

#include <unistd.h>

#include <cerrno>
#include <string>
#include <string_view>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/storage/backup/kept_files.h"
#include "server/storage/data_directory.h"
#include "server/storage/sql/sql_schema.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_schema.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;

// Counts the keys whose stored sums differ from the sums of their rows. The tolerance of 1e-8
// covers rounding, because the store adds the rows in another order. Sums of counts stop at 2^63 -
// 1.
constexpr const char* kWrongSums = R"sql(
  SELECT count(*) FROM evidence_key LEFT JOIN
    (SELECT key_id, total(alpha) AS a, total(beta) AS b, total(window_count) AS w,
            total(bail_out_count) AS o, count(*) AS n
     FROM evidence GROUP BY key_id) ON key_id = id
  WHERE source_count <> ifnull(n, 0)
    OR abs(alpha_sum - ifnull(a, 0)) > 1e-8 * (1 + alpha_sum)
    OR abs(beta_sum - ifnull(b, 0)) > 1e-8 * (1 + beta_sum)
    OR abs(window_sum - min(ifnull(w, 0), 9223372036854775807)) > 1e-8 * window_sum
    OR abs(bail_out_sum - min(ifnull(o, 0), 9223372036854775807)) > 1e-8 * bail_out_sum)sql";

constexpr const char* kWrongCounts = R"sql(
  SELECT count(*) FROM scene LEFT JOIN
    (SELECT scene_id, count(*) AS n FROM scene_source GROUP BY scene_id) ON scene_id = id
  WHERE source_count <> ifnull(n, 0))sql";

constexpr const char* kUncountedSources = R"sql(
  SELECT count(*) FROM
    (SELECT source_id, k.scene_id
     FROM evidence JOIN evidence_key k ON k.id = key_id
     EXCEPT SELECT source_id, scene_id FROM scene_source))sql";

constexpr const char* kSourcesOfNothing = R"sql(
  SELECT source_id, scene_id FROM scene_source
  EXCEPT SELECT source_id, k.scene_id FROM evidence JOIN evidence_key k ON k.id = key_id)sql";

constexpr const char* kWrongParties = R"sql(
  WITH of_sources AS
    (SELECT scene_id, token_id, party, max(source_id) FROM scene_source GROUP BY 1, 2, 3)
  SELECT (SELECT count(*) FROM (SELECT * FROM of_sources EXCEPT SELECT * FROM scene_party)) +
         (SELECT count(*) FROM (SELECT * FROM scene_party EXCEPT SELECT * FROM of_sources)))sql";

// A damaged key or scene can be repaired. Its names and ids are in an index as well, so SQLite's
// integrity_check verifies them. Its other columns are sums, which are computed again from the
// undamaged rows.
constexpr const char* kMarkDamagedRows = R"sql(
  CREATE TEMP TABLE wrong_source AS SELECT id FROM source WHERE hash <> content_hash;
  CREATE TEMP TABLE wrong_evidence AS
    SELECT key_id, source_id FROM evidence
    WHERE hash <> content_hash OR source_id IN wrong_source;
  CREATE TEMP TABLE wrong_key AS
    SELECT id FROM evidence_key WHERE hash <> content_hash
    UNION SELECT key_id FROM wrong_evidence;)sql";

constexpr const char* kDeleteDamagedRows = R"sql(
  DELETE FROM quarantined_evidence WHERE hash <> content_hash OR source_id IN wrong_source;
  DELETE FROM evidence WHERE (key_id, source_id) IN wrong_evidence;
  DELETE FROM scene_source WHERE source_id IN wrong_source;
  DELETE FROM source WHERE id IN wrong_source;
  DELETE FROM scene_source WHERE (source_id, scene_id) IN ()sql";

constexpr const char* kMakeSumsAnew = R"sql();
  UPDATE evidence_key
    SET (alpha_sum, beta_sum, window_sum, bail_out_sum, source_count) =
        (SELECT total(alpha), total(beta), CAST(total(window_count) AS INTEGER),
                CAST(total(bail_out_count) AS INTEGER), count(*)
         FROM evidence WHERE key_id = evidence_key.id)
    WHERE id IN wrong_key;
  UPDATE evidence_key SET hash = content_hash WHERE id IN wrong_key;
  UPDATE scene SET source_count = n
    FROM (SELECT scene.id, count(source_id) AS n
          FROM scene LEFT JOIN scene_source ON scene_id = scene.id GROUP BY scene.id) AS c
    WHERE c.id = scene.id AND source_count <> n;
  UPDATE scene SET hash = content_hash WHERE hash <> content_hash;
  DELETE FROM scene_party;)sql";

absl::Status Corrupt(const fs::path& file, absl::string_view what) {
  return absl::DataLossError(
      absl::StrCat(file.string(), " is corrupt (", what, "); use an earlier backup"));
}

absl::Status CheckNone(SqliteDatabase& database, std::string_view sql, const fs::path& file,
                       absl::string_view what) {
  auto count = database.QueryInteger(sql);
  if (!count.ok()) return Corrupt(file, count.status().message());
  return *count == 0 ? absl::OkStatus() : Corrupt(file, absl::StrCat(*count, " ", what));
}

// Compares the schema with that of a new database: a trigger or view of another program would act
// on the restored one.
absl::Status CheckSchema(SqliteDatabase& database, const fs::path& file) {
  constexpr const char* kSchema =
      "SELECT group_concat(type || ' ' || name || ' ' || coalesce(sql, '')) FROM "
      "(SELECT * FROM sqlite_schema WHERE name NOT LIKE 'sqlite_stat%' ORDER BY type, name)";
  auto fresh = OpenPriorDatabaseInMemory();
  if (!fresh.ok()) return fresh.status();
  const auto expected = fresh->QueryText(kSchema);
  if (!expected.ok()) return expected.status();
  const auto found = database.QueryText(kSchema);
  if (!found.ok()) return Corrupt(file, found.status().message());
  return *found == *expected ? absl::OkStatus()
                             : Corrupt(file, "its schema is not that of a prior store");
}

absl::Status CheckRows(SqliteDatabase& database, const fs::path& file) {
  auto verdict = database.QueryText("PRAGMA integrity_check(1)");
  if (!verdict.ok()) return Corrupt(file, verdict.status().message());
  if (*verdict != "ok") return Corrupt(file, *verdict);
  absl::Status status = CheckNone(database, "SELECT count(*) FROM pragma_foreign_key_check", file,
                                  "rows refer to a row that does not exist");
  if (!status.ok()) return status;
  const auto damaged = CountDamagedRows(database);
  if (!damaged.ok()) return Corrupt(file, damaged.status().message());
  if (*damaged > 0) return Corrupt(file, absl::StrCat(*damaged, " rows were changed on the disk"));
  status = CheckNone(database, kWrongSums, file, "sums differ from their rows");
  if (!status.ok()) return status;
  status = CheckNone(database, kWrongCounts, file, "scenes have a wrong number of sources");
  if (status.ok())
    status = CheckNone(database, kUncountedSources, file,
                       "sources are missing in the list of their scene");
  if (status.ok())
    status = CheckNone(database, absl::StrCat("SELECT count(*) FROM (", kSourcesOfNothing, ")"),
                       file, "sources are listed for a scene but have no evidence of it");
  if (!status.ok()) return status;
  return CheckNone(database, kWrongParties, file, "parties of scenes have a wrong latest source");
}

absl::StatusOr<StoreContents> Count(SqliteDatabase& database) {
  StoreContents contents;
  const std::pair<int64_t*, const char*> queries[] = {
      {&contents.scene_count,
       "SELECT count(*) FROM (SELECT DISTINCT project, scene, machine_class, reward_version FROM "
       "evidence_key WHERE id IN (SELECT key_id FROM evidence))"},
      {&contents.source_count, "SELECT count(DISTINCT source_id) FROM scene_source"},
      {&contents.record_count, "SELECT count(*) FROM evidence"},
      {&contents.audit_row_count, "SELECT count(*) FROM audit_row"},
  };
  for (const auto& [count, sql] : queries) {
    auto value = database.QueryInteger(sql);
    if (!value.ok()) return value.status();
    *count = *value;
  }
  const auto files = database.Collect<std::vector<std::string>>(
      "SELECT name FROM kept_file ORDER BY name",
      [](const SqlRow& row, auto& names) { names.push_back(row.Text(0)); });
  if (!files.ok()) return files.status();
  contents.kept_files = *files;
  return contents;
}

absl::Status CheckAbsent(const fs::path& file, absl::string_view what_to_do) {
  std::error_code error;
  if (!fs::exists(fs::symlink_status(file, error))) return absl::OkStatus();
  return absl::AlreadyExistsError(absl::StrCat(file.string(), " exists; ", what_to_do));
}

// Returns a connection that has not read the file yet.
absl::StatusOr<SqliteDatabase> OpenToRead(const fs::path& file) {
  std::error_code unknown;
  if (access(file.c_str(), R_OK) != 0 && errno == EACCES)
    return absl::UnavailableError(absl::StrCat(
        file.string(), ": permission denied; run this as the user that owns the data directory"));
  if (!fs::exists(file, unknown) && !unknown)
    return absl::NotFoundError(absl::StrCat(file.string(), ": there is no such file"));
  // To open a named pipe would wait for a writer.
  if (!unknown && !fs::is_regular_file(file, unknown))
    return absl::InvalidArgumentError(
        absl::StrCat(file.string(), " is not a file; copy the backup into a file"));
  auto database = SqliteDatabase::Open(file.string(), SqliteDatabase::OpenMode::kReadOnly);
  absl::Status status = database.status();
  if (status.ok())
    status = database->Execute("PRAGMA busy_timeout = 2000; PRAGMA trusted_schema = OFF");
  if (!status.ok()) return Explain(file, status);
  return database;
}

}  // namespace

absl::StatusOr<StoreContents> VerifyStore(const fs::path& file, const std::atomic<bool>* stop) {
  auto database = OpenToRead(file);
  if (!database.ok()) return database.status();
  database->StopWhen(stop);
  absl::Status status = CheckPriorDatabase(*database, file);
  if (status.ok()) status = CheckSchema(*database, file);
  if (status.ok()) status = CheckRows(*database, file);
  if (!status.ok()) return status;
  return Count(*database);
}

int64_t LeaveOutDamagedRows(SqliteDatabase& copy) {
  const auto count = CountDamagedRows(copy);
  if (!count.ok() || *count == 0) return 0;
  const auto verdict = copy.QueryText("PRAGMA integrity_check(1)");
  if (!verdict.ok() || *verdict != "ok") return 0;
  const std::string sql = absl::StrCat(kMarkDamagedRows, kDeleteDamagedRows, kSourcesOfNothing,
                                       kMakeSumsAnew, kMakeParties);
  const absl::Status status = InTransaction(copy, [&] { return copy.Execute(sql); });
  return status.ok() ? *count : 0;
}

absl::StatusOr<StoreContents> BackUpStore(const fs::path& directory, const fs::path& file,
                                          const std::atomic<bool>* stop) {
  absl::Status status = CheckAbsent(file, "name a file that does not exist");
  if (!status.ok()) return status;
  const fs::path path = directory / DataDirectory::kDatabaseName;
  std::error_code error;
  if (!fs::exists(path, error) && !error) {
    return absl::NotFoundError(
        absl::StrCat("there is no ", path.string(), "; name the data directory with --data"));
  }
  auto database = OpenToRead(path);
  if (!database.ok()) return database.status();
  if (status = CheckPriorDatabase(*database, path); !status.ok()) return status;
  database->StopWhen(stop);
  int64_t damaged_row_count = 0;
  status = database->CopyTo(file.string(), [&](SqliteDatabase& copy) {
    copy.StopWhen(stop);
    damaged_row_count = LeaveOutDamagedRows(copy);
    return AddKeptFiles(directory, file.string() + ".tokens", copy);
  });
  if (!status.ok()) return status;
  auto contents = VerifyStore(file, stop);
  if (contents.ok()) contents->damaged_row_count = damaged_row_count;
  return contents;
}

absl::Status CheckNoDatabase(const fs::path& directory) {
  absl::Status status;
  for (const char* suffix : {"", "-wal", "-shm"}) {
    if (status.ok())
      status = CheckAbsent((directory / DataDirectory::kDatabaseName).string() + suffix,
                           "move it away, or name an empty directory with --data");
  }
  return status;
}

absl::StatusOr<StoreContents> RestoreStore(const fs::path& file, const fs::path& directory) {
  auto contents = VerifyStore(file);
  if (!contents.ok()) return contents;
  auto data = DataDirectory::Open(directory);
  if (!data.ok()) return data.status();
  absl::Status status = CheckNoDatabase(directory);
  if (!status.ok()) return status;
  auto database = OpenToRead(file);
  if (!database.ok()) return database.status();
  // The database appears after the other files: only then is the restore complete.
  status = database->CopyTo(data->database().string(),
                            [&](SqliteDatabase& copy) { return TakeKeptFiles(copy, directory); });
  if (!status.ok()) return status;
  return contents;
}

}  // namespace sweepstake::storage
