#include "server/storage/postgres/postgres_migration.h"

#include <functional>
#include <optional>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "absl/strings/str_join.h"
#include "server/storage/data_directory.h"
#include "server/storage/outbox/outbox.h"
#include "server/storage/postgres/postgres_connection.h"
#include "server/storage/postgres/postgres_schema.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_schema.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;

enum class Kind { kInteger, kBoolean, kText, kUnits, kCount, kBytes };

struct Column {
  const char* name;
  Kind kind = Kind::kInteger;
};

// A table of both stores. Tables are listed so that rows refer to earlier ones only. The first
// columns are its key, and are numbers.
struct Table {
  const char* name;
  size_t key_columns;
  bool is_hashed;  // SQLite keeps a hash of each row
  std::vector<Column> columns;
};

const std::vector<Table>& Tables() {
  static const std::vector<Table> tables = {
      {"source",
       1,
       true,
       {{"id"},
        {"name", Kind::kText},
        {"is_session", Kind::kBoolean},
        {"revoked", Kind::kBoolean},
        {"commit_sequence"},
        {"message_sequence"},
        {"explored_arm_count"},
        {"decision_count"},
        {"frame_count"},
        {"seed"},
        {"created_unix_s"},
        {"last_seen_unix_s"},
        {"build", Kind::kText},
        {"token_id"}}},
      {"scene",
       1,
       true,
       {{"id"},
        {"project", Kind::kText},
        {"scene", Kind::kText},
        {"machine_class", Kind::kText},
        {"reward_version"},
        {"source_count"}}},
      {"evidence_key",
       1,
       true,
       {{"id"},
        {"scene_id"},
        {"project", Kind::kText},
        {"scene", Kind::kText},
        {"measured_by", Kind::kText},
        {"arm", Kind::kText},
        {"backend_version"},
        {"machine_class", Kind::kText},
        {"reward_version"}}},
      {"evidence",
       2,
       true,
       {{"key_id"},
        {"source_id"},
        {"sequence"},
        {"alpha", Kind::kUnits},
        {"beta", Kind::kUnits},
        {"window_count", Kind::kCount},
        {"bail_out_count", Kind::kCount}}},
      {"quarantined_evidence",
       2,
       true,
       {{"key_id"},
        {"source_id"},
        {"sequence"},
        {"alpha", Kind::kUnits},
        {"beta", Kind::kUnits},
        {"window_count", Kind::kCount},
        {"bail_out_count", Kind::kCount}}},
      {"scene_source", 2, false, {{"source_id"}, {"scene_id"}}},
      {"audit_segment",
       1,
       false,
       {{"id"},
        {"session", Kind::kText},
        {"segment"},
        {"project", Kind::kText},
        {"scene", Kind::kText},
        {"unix_start_ms"}}},
      {"audit_row", 1, false, {{"id"}, {"segment_id"}, {"number"}, {"text", Kind::kBytes}}},
      {"audit_chunk", 1, false, {{"first_row_id"}, {"unix_start_s"}, {"byte_count"}}}};
  return tables;
}

constexpr uint64_t kRowsPerBatch = 5'000;

constexpr const char* kMakeSums = R"sql(
    UPDATE evidence_key
    SET alpha_sum = a, beta_sum = b, window_sum = w, bail_out_sum = o, source_count = n
    FROM (SELECT key_id, sum(alpha) AS a, sum(beta) AS b, sum(window_count) AS w,
                 sum(bail_out_count) AS o, count(*) AS n
          FROM evidence GROUP BY key_id) s
    WHERE key_id = id)sql";
// Counts end at a column's maximum.
constexpr const char* kMakeSqliteSums = R"sql(
    UPDATE evidence_key
    SET (alpha_sum, beta_sum, window_sum, bail_out_sum, source_count) =
          (SELECT total(alpha), total(beta), CAST(total(window_count) AS INTEGER),
                  CAST(total(bail_out_count) AS INTEGER), count(*)
           FROM evidence WHERE key_id = evidence_key.id))sql";
constexpr const char* kSetNumbers = R"sql(
    SELECT setval('source_number', (SELECT max(id) FROM source)),
           setval(pg_get_serial_sequence('scene', 'id'), (SELECT max(id) FROM scene)),
           setval(pg_get_serial_sequence('evidence_key', 'id'), (SELECT max(id) FROM evidence_key)),
           setval(pg_get_serial_sequence('audit_segment', 'id'),
                  (SELECT max(id) FROM audit_segment)),
           setval(pg_get_serial_sequence('audit_row', 'id'), (SELECT max(id) FROM audit_row)))sql";

std::string NamesOf(const Table& table) {
  return absl::StrJoin(table.columns, ", ", [](std::string* out, const Column& column) {
    absl::StrAppend(out, column.name);
  });
}

const char* ArrayTypeOf(Kind kind) {
  switch (kind) {
    case Kind::kBoolean:
      return "boolean[]";
    case Kind::kText:
      return "text[]";
    case Kind::kUnits:
    case Kind::kCount:
      return "numeric[]";
    case Kind::kBytes:
      return "bytea[]";
    default:
      return "bigint[]";
  }
}

// Returns the statement that inserts arrays of the columns into PostgreSQL.
std::string InsertSql(const Table& table) {
  std::string parameters;
  for (size_t i = 0; i < table.columns.size(); ++i)
    absl::StrAppend(&parameters, i == 0 ? "" : ", ", "$", i + 1,
                    "::", ArrayTypeOf(table.columns[i].kind));
  return absl::StrCat("INSERT INTO ", table.name, " (", NamesOf(table),
                      ") OVERRIDING SYSTEM VALUE SELECT * FROM unnest(", parameters, ")");
}

void AddTo(PostgresArray& array, const SqliteRow& row, int index, Kind kind) {
  switch (kind) {
    case Kind::kText:
      return array.Add(row.Text(index));
    case Kind::kBytes:
      return array.AddBytes(row.Text(index));
    case Kind::kUnits:
      return array.Add(UnitsOf(row.Real(index)));
    default:
      return array.Add(row.Integer(index));
  }
}

std::string CountSql(const Table& table) {
  return absl::StrCat("SELECT count(*) FROM ", table.name);
}

absl::StatusOr<uint64_t> CountRows(const Table& table, SqliteDatabase& file) {
  const auto count = file.QueryInteger(CountSql(table));
  if (!count.ok()) return count.status();
  return static_cast<uint64_t>(*count);
}

absl::StatusOr<uint64_t> CountRows(const Table& table, PostgresConnection& server) {
  uint64_t count = 0;
  absl::Status status = server.ForEachRow(CountSql(table).c_str(),
                                          [&](const PostgresRow& row) { count = row.Unsigned(0); });
  if (!status.ok()) return status;
  return count;
}

// The progress of copying one table.
class Progress {
 public:
  Progress(const Table& table, uint64_t row_count, const OnMigrated& on_migrated)
      : table_(table), row_count_(row_count), on_migrated_(on_migrated) {}

  void Add(uint64_t rows) {
    const uint64_t before = rows_;
    rows_ += rows;
    if (rows > 0 && (rows_ == row_count_ || rows_ * 10 / row_count_ != before * 10 / row_count_))
      on_migrated_(table_.name, rows_, row_count_);
  }

 private:
  const Table& table_;
  const uint64_t row_count_;
  const OnMigrated& on_migrated_;
  uint64_t rows_ = 0;
};

absl::Status CopyTable(const Table& table, SqliteDatabase& from, PostgresConnection& to,
                       const OnMigrated& on_migrated) {
  const auto row_count = CountRows(table, from);
  if (!row_count.ok()) return row_count.status();
  Progress progress(table, *row_count, on_migrated);
  auto statement = from.Prepare(absl::StrCat("SELECT ", NamesOf(table), " FROM ", table.name));
  if (!statement.ok()) return statement.status();
  const std::string insert = InsertSql(table);
  absl::Status written;
  std::vector<PostgresArray> arrays(table.columns.size());
  uint64_t count = 0;
  const auto write = [&] {
    if (written.ok() && count > 0) written = to.RunOnce(insert, arrays);
    if (written.ok()) progress.Add(count);
    arrays.assign(table.columns.size(), PostgresArray());
    count = 0;
  };
  absl::Status status = statement->ForEachRow([&](const SqliteRow& row) {
    for (size_t i = 0; i < table.columns.size(); ++i)
      AddTo(arrays[i], row, static_cast<int>(i), table.columns[i].kind);
    if (++count == kRowsPerBatch) write();
  });
  write();
  return status.ok() ? written : status;
}

// Returns an expression whose value is exact in JSON, in the form that SQLite stores.
std::string ToJson(const Column& column) {
  switch (column.kind) {
    case Kind::kBoolean:
      return absl::StrCat(column.name, "::int");
    case Kind::kBytes:
      return absl::StrCat("convert_from(", column.name, ", 'UTF8')");
    default:
      return column.name;
  }
}

// Returns the statement that reads a page of the table as a JSON array of its rows.
std::string PageSql(const Table& table) {
  const std::string values = absl::StrJoin(
      table.columns, ", ",
      [](std::string* out, const Column& column) { absl::StrAppend(out, ToJson(column)); });
  std::string key = table.columns[0].name;
  if (table.key_columns == 2) absl::StrAppend(&key, ", ", table.columns[1].name);
  return absl::StrCat("SELECT count(*), json_agg(json_build_array(", values,
                      ")) FROM (SELECT * FROM ", table.name, " ORDER BY ", key,
                      " LIMIT $1::bigint OFFSET $2::bigint) page");
}

// Returns the statement that inserts such a page into SQLite.
std::string InsertPageSql(const Table& table) {
  std::string values;
  for (size_t i = 0; i < table.columns.size(); ++i) {
    absl::StrAppend(&values, i == 0 ? "" : ", ", "json_extract(value, '$[", i, "]')",
                    table.columns[i].kind == Kind::kUnits ? " * 1.0 / 1048576.0" : "");
  }
  // The hashes are computed when all rows are there.
  return absl::StrCat("INSERT INTO ", table.name, " (", NamesOf(table),
                      table.is_hashed ? ", hash" : "", ") SELECT ", values,
                      table.is_hashed ? ", 0" : "", " FROM json_each(?1)");
}

absl::Status CopyTable(const Table& table, PostgresConnection& from, SqliteDatabase& to,
                       const OnMigrated& on_migrated) {
  auto insert = to.Prepare(InsertPageSql(table));
  if (!insert.ok()) return insert.status();
  const auto row_count = CountRows(table, from);
  if (!row_count.ok()) return row_count.status();
  Progress progress(table, *row_count, on_migrated);
  const std::string select = PageSql(table);
  uint64_t count = kRowsPerBatch;
  for (uint64_t offset = 0; count == kRowsPerBatch; offset += count) {
    std::string page;
    absl::Status status = from.ForEachRow(
        select.c_str(),
        [&](const PostgresRow& row) {
          count = row.Unsigned(0);
          page = row.Text(1);
        },
        kRowsPerBatch, offset);
    if (status.ok() && count > 0) status = insert->Run(page);
    if (!status.ok()) return status;
    progress.Add(count);
  }
  return absl::OkStatus();
}

// Compares the numbers of rows.
absl::Status CheckCounts(SqliteDatabase& file, PostgresConnection& server) {
  for (const Table& table : Tables()) {
    const auto in_file = CountRows(table, file);
    if (!in_file.ok()) return in_file.status();
    const auto in_server = CountRows(table, server);
    if (!in_server.ok()) return in_server.status();
    if (*in_file != *in_server) {
      return absl::DataLossError(absl::StrCat("of ", table.name, " ", *in_file,
                                              " rows are in the file and ", *in_server,
                                              " in PostgreSQL; nothing was changed"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckEmpty(PostgresConnection& connection) {
  bool any = false;
  absl::Status status =
      connection.ForEachRow("SELECT EXISTS (SELECT 1 FROM source)",
                            [&](const PostgresRow& row) { any = row.Boolean(0); });
  if (!status.ok() || !any) return status;
  return absl::AlreadyExistsError(
      "the store in PostgreSQL has sources; name another database, or export from one and import "
      "into the other");
}

absl::Status WriteAll(SqliteDatabase& file, PostgresConnection& connection,
                      const OnMigrated& on_migrated) {
  absl::Status status = connection.Execute("BEGIN; LOCK TABLE source IN EXCLUSIVE MODE");
  if (status.ok()) status = CheckEmpty(connection);
  for (const Table& table : Tables()) {
    if (status.ok()) status = CopyTable(table, file, connection, on_migrated);
  }
  if (status.ok()) status = connection.Execute(kMakeSums);
  if (status.ok()) status = connection.Execute(kSetNumbers);
  if (status.ok()) status = CheckCounts(file, connection);
  return status.ok() ? connection.Execute("COMMIT") : status;
}

absl::Status ReadAll(PostgresConnection& connection, SqliteDatabase& file,
                     const OnMigrated& on_migrated) {
  const PostgresSnapshot snapshot(connection);
  if (!snapshot.status().ok()) return snapshot.status();
  SqliteTransaction transaction(file);
  absl::Status status = transaction.begun();
  for (const Table& table : Tables()) {
    if (status.ok()) status = CopyTable(table, connection, file, on_migrated);
  }
  if (status.ok()) status = file.Execute(kMakeSqliteSums);
  for (const Table& table : Tables()) {
    if (status.ok() && table.is_hashed)
      status = file.Execute(absl::StrCat("UPDATE ", table.name, " SET hash = content_hash"));
  }
  if (status.ok()) status = CheckCounts(file, connection);
  return status.ok() ? transaction.Commit() : status;
}

absl::Status Prepare(PostgresConnection& connection) {
  absl::Status status = connection.Connect();
  return status.ok() ? PreparePostgresSchema(connection).status() : status;
}

// A directory beside the data, removed with its content.
class Workplace {
 public:
  explicit Workplace(const fs::path& directory) : path_(directory.string() + ".migration") {
    Clear();
  }
  ~Workplace() { Clear(); }
  Workplace(const Workplace&) = delete;
  Workplace& operator=(const Workplace&) = delete;
  const fs::path& path() const { return path_; }

 private:
  void Clear() const {
    std::error_code ignored;
    fs::remove_all(path_, ignored);
  }
  const fs::path path_;
};

// Makes a database in the directory from the store in PostgreSQL.
absl::Status MakeDatabase(PostgresConnection& connection, const fs::path& directory,
                          const OnMigrated& on_migrated) {
  auto data = DataDirectory::Open(directory);
  if (!data.ok()) return data.status();
  auto file = OpenPriorDatabase(data->database());
  if (!file.ok()) return file.status();
  return ReadAll(connection, *file, on_migrated);
}

}  // namespace

absl::StatusOr<StoreContents> MigrateToPostgres(const fs::path& directory, const std::string& url,
                                                const OnMigrated& on_migrated) {
  auto data = DataDirectory::Open(directory);  // keeps daemons from starting meanwhile
  if (!data.ok()) return data.status();
  if (absl::Status delivered = CheckDelivered(data->outbox()); !delivered.ok()) return delivered;
  const Workplace workplace(directory);
  std::error_code error;
  fs::create_directory(workplace.path(), error);
  const fs::path copy = workplace.path() / "copy.db";
  auto contents = BackUpStore(directory, copy);
  if (!contents.ok()) return contents;
  auto file = OpenPriorDatabase(copy);
  if (!file.ok()) return file.status();
  PostgresConnection connection(url);
  absl::Status status = Prepare(connection);
  if (status.ok()) status = WriteAll(*file, connection, on_migrated);
  if (!status.ok()) return status;
  return contents;
}

absl::StatusOr<StoreContents> MigrateFromPostgres(const std::string& url, const fs::path& directory,
                                                  const OnMigrated& on_migrated) {
  // Checks that no daemon uses it. RestoreStore checks again.
  absl::Status status = DataDirectory::Open(directory).status();
  if (status.ok()) status = CheckNoDatabase(directory);
  if (status.ok()) status = CheckDelivered(directory / DataDirectory::kOutboxName);
  PostgresConnection connection(url);
  if (status.ok()) status = Prepare(connection);
  if (!status.ok()) return status;
  const Workplace workplace(directory);
  const fs::path copy = workplace.path() / "copy.db";
  status = MakeDatabase(connection, workplace.path(), on_migrated);
  if (!status.ok()) return status;
  const auto copied = BackUpStore(workplace.path(), copy);
  if (!copied.ok()) return copied.status();
  return RestoreStore(copy, directory);
}

}  // namespace sweepstake::storage
