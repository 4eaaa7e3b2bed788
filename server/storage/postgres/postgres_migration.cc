#include "server/storage/postgres/postgres_migration.h"

#include <deque>
#include <span>
#include <system_error>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/storage/data_directory.h"
#include "server/storage/outbox/outbox.h"
#include "server/storage/postgres/postgres_connection.h"
#include "server/storage/postgres/postgres_prior_store.h"
#include "server/storage/sql/sql_schema.h"
#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_schema.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;

enum class Kind { kInteger, kBoolean, kText, kAmount, kBytes };

struct Column {
  const char* name;
  Kind kind = Kind::kInteger;
};

// A table that both stores have. Its first `key_columns` columns are its primary key: numbers above
// 0.
struct Table {
  const char* name;
  size_t key_columns;
  bool is_hashed;  // SQLite keeps a hash of each row
  std::vector<Column> columns;
  // SQL statements for this table. They live as long as the table, as SqlDatabase requires.
  std::string count = {};
  std::string select = {};  // reads the kRowsPerPage rows after a key
  std::string insert = {};
};

constexpr uint64_t kRowsPerPage = 5'000;

// Returns the table with its SQL statements.
Table WithStatements(Table table) {
  std::string columns, values;
  for (size_t i = 0; i < table.columns.size(); ++i) {
    const char* comma = i == 0 ? "" : ", ";
    absl::StrAppend(&columns, comma, table.columns[i].name);
    absl::StrAppend(&values, comma, "?", i + 1);
  }
  const bool is_pair = table.key_columns == 2;
  const std::string key = absl::StrCat(table.columns[0].name, is_pair ? ", " : "",
                                       is_pair ? table.columns[1].name : "");
  table.count = absl::StrCat("SELECT count(*) FROM ", table.name);
  table.select =
      absl::StrCat("SELECT ", columns, " FROM ", table.name, " WHERE (", key, ") > (",
                   is_pair ? "?1, ?2" : "?1", ") ORDER BY ", key, " LIMIT ", kRowsPerPage);
  // The hash of each row is 0 until CopyAll computes it, after all rows are inserted.
  table.insert =
      absl::StrCat("INSERT INTO ", table.name, " (", columns, table.is_hashed ? "[, hash]" : "",
                   ") {OVERRIDING SYSTEM VALUE} SELECT ", values, table.is_hashed ? "[, 0]" : "",
                   " {FROM @given}");
  return table;
}

std::vector<Table> MakeTables() {
  const std::vector<Column> evidence = {{"key_id"},
                                        {"source_id"},
                                        {"sequence"},
                                        {"alpha", Kind::kAmount},
                                        {"beta", Kind::kAmount},
                                        {"window_count"},
                                        {"bail_out_count"}};
  std::vector<Table> tables = {
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
        {"token_id"},
        {"player", Kind::kText},
        {"network", Kind::kText}}},
      {"scene",
       1,
       true,
       {{"id"},
        {"project", Kind::kText},
        {"scene", Kind::kText},
        {"machine_class", Kind::kText},
        {"reward_version"},
        {"source_count"},
        {"is_known", Kind::kBoolean},
        {"added_by_token"},
        {"added_by_party", Kind::kText}}},
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
        {"reward_version"},
        {"regime", Kind::kText},
        {"is_known", Kind::kBoolean}}},
      {"evidence", 2, true, evidence},
      {"quarantined_evidence", 2, true, evidence},
      {"scene_source",
       2,
       false,
       {{"source_id"}, {"scene_id"}, {"token_id"}, {"party", Kind::kText}}},
      {"audit_segment",
       1,
       false,
       {{"id"},
        {"session", Kind::kText},
        {"segment"},
        {"project", Kind::kText},
        {"scene", Kind::kText},
        {"unix_start_ms"}}},
      {"audit_row", 1, false, {{"id"}, {"segment_id"}, {"number"}, {"bytes", Kind::kBytes}}},
      {"audit_chunk", 1, false, {{"first_row_id"}, {"unix_start_s"}, {"byte_count"}}}};
  for (Table& table : tables) table = WithStatements(std::move(table));
  return tables;
}

// Returns all tables, ordered so that rows refer only to rows of earlier tables.
const std::vector<Table>& Tables() {
  static const auto& tables = *new std::vector<Table>(MakeTables());
  return tables;
}

constexpr const char* kMakeSums = R"sql(
    UPDATE evidence_key
    SET (alpha_sum, beta_sum, window_sum, bail_out_sum, source_count) =
          (SELECT [total(alpha)]{coalesce(sum(alpha), 0)}, [total(beta)]{coalesce(sum(beta), 0)},
                  [CAST(total(window_count) AS INTEGER)]{coalesce(sum(window_count), 0)},
                  [CAST(total(bail_out_count) AS INTEGER)]{coalesce(sum(bail_out_count), 0)},
                  count(*)
           FROM evidence WHERE key_id = evidence_key.id))sql";
constexpr const char* kSetNumbers = R"sql({
    SELECT setval('source_number', (SELECT max(id) FROM source)),
           setval(pg_get_serial_sequence('scene', 'id'), (SELECT max(id) FROM scene)),
           setval(pg_get_serial_sequence('evidence_key', 'id'), (SELECT max(id) FROM evidence_key)),
           setval(pg_get_serial_sequence('audit_segment', 'id'),
                  (SELECT max(id) FROM audit_segment)),
           setval(pg_get_serial_sequence('audit_row', 'id'), (SELECT max(id) FROM audit_row))})sql";

absl::StatusOr<uint64_t> CountRows(const Table& table, SqlDatabase& database) {
  return database.ReadInteger(table.count.c_str());
}

// Up to kRowsPerPage rows of a table.
class Page {
 public:
  explicit Page(const Table& table) : table_(table) {}

  void Add(const SqlRow& row) {
    std::vector<SqlValue> values;
    for (int i = 0; i < static_cast<int>(table_.columns.size()); ++i) {
      switch (table_.columns[static_cast<size_t>(i)].kind) {
        case Kind::kInteger:
          values.push_back(ToSql(row.Integer(i)));
          break;
        case Kind::kBoolean:
          values.push_back(ToSql(row.Boolean(i)));
          break;
        case Kind::kAmount:
          values.push_back(SqlAmount{row.Amount(i)});
          break;
        case Kind::kText:
          values.push_back(ToSql(texts_.emplace_back(row.Text(i))));
          break;
        case Kind::kBytes:
          values.push_back(SqlBytes{texts_.emplace_back(row.Bytes(i))});
      }
    }
    rows_.Add(std::span<const SqlValue>(values));
    ++count_;
    last_ = {row.Integer(0), row.Integer(1)};
  }
  uint64_t count() const { return count_; }
  const SqlBatch& rows() const { return rows_; }
  // The first two columns of the last row.
  const std::pair<int64_t, int64_t>& last() const { return last_; }

 private:
  const Table& table_;
  std::deque<std::string> texts_;
  SqlBatch rows_;
  uint64_t count_ = 0;
  std::pair<int64_t, int64_t> last_;
};

absl::Status CopyTable(const Table& table, SqlDatabase& from, SqlDatabase& to,
                       const OnMigrated& on_migrated) {
  const auto row_count = CountRows(table, from);
  if (!row_count.ok()) return row_count.status();
  uint64_t copied = 0;
  std::pair<int64_t, int64_t> last;
  uint64_t count = kRowsPerPage;
  while (count == kRowsPerPage) {
    Page page(table);
    const auto add = [&](const SqlRow& row) { page.Add(row); };
    absl::Status status = table.key_columns == 1
                              ? from.ForEachRow(table.select.c_str(), add, last.first)
                              : from.ForEachRow(table.select.c_str(), add, last.first, last.second);
    if (status.ok()) status = to.Run(table.insert.c_str(), page.rows());
    if (!status.ok()) return status;
    last = page.last();
    count = page.count();
    const uint64_t before = std::exchange(copied, copied + count);
    if (count > 0 && (copied == *row_count || copied * 10 / *row_count != before * 10 / *row_count))
      on_migrated(table.name, copied, *row_count);
  }
  return absl::OkStatus();
}

// Returns an error if a table has different numbers of rows in the two databases.
absl::Status CheckCounts(SqlDatabase& from, SqlDatabase& to) {
  for (const Table& table : Tables()) {
    const auto before = CountRows(table, from);
    if (!before.ok()) return before.status();
    const auto after = CountRows(table, to);
    if (!after.ok()) return after.status();
    if (*before != *after) {
      return absl::DataLossError(
          absl::StrCat(*after, " of the ", *before, " rows of ", table.name,
                       " were copied; the copy was cancelled, and nothing was changed"));
    }
  }
  return absl::OkStatus();
}

absl::Status CheckEmpty(SqlDatabase& database) {
  const auto count = CountRows(Tables().front(), database);
  if (!count.ok() || *count == 0) return count.status();
  return absl::AlreadyExistsError(
      "the store in PostgreSQL already contains evidence; name another database, or export from "
      "one store and import into the other");
}

// Copies all rows into an empty database, in one transaction.
absl::Status CopyAll(SqlDatabase& from, SqlDatabase& to, const OnMigrated& on_migrated) {
  const SqlSnapshot snapshot(from);
  if (!snapshot.status().ok()) return snapshot.status();
  return InTransaction(to, [&] {
    absl::Status status;
    if (to.shared()) status = to.Execute("LOCK TABLE source IN EXCLUSIVE MODE");
    if (status.ok()) status = CheckEmpty(to);
    for (const Table& table : Tables()) {
      if (status.ok()) status = CopyTable(table, from, to, on_migrated);
    }
    if (status.ok()) status = to.Run(kMakeSums);
    if (status.ok()) status = to.Run(kMakeParties);
    if (status.ok()) status = to.Run(kSetNumbers);
    for (const Table& table : Tables()) {
      if (status.ok() && table.is_hashed && !to.shared())
        status = to.Execute(absl::StrCat("UPDATE ", table.name, " SET hash = content_hash"));
    }
    return status.ok() ? CheckCounts(from, to) : status;
  });
}

absl::Status Prepare(PostgresConnection& connection) {
  absl::Status status = connection.Connect();
  return status.ok() ? PreparePostgresSchema(connection).status() : status;
}

// A temporary directory beside the data directory. The constructor and the destructor remove it
// with its content.
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

// Creates an SQLite database in `directory` with the rows of the store in PostgreSQL.
absl::Status MakeDatabase(PostgresConnection& connection, const fs::path& directory,
                          const OnMigrated& on_migrated) {
  auto data = DataDirectory::Open(directory);
  if (!data.ok()) return data.status();
  auto file = OpenPriorDatabase(data->database());
  if (!file.ok()) return file.status();
  return CopyAll(connection, *file, on_migrated);
}

}  // namespace

absl::StatusOr<StoreContents> MigrateToPostgres(const fs::path& directory, const std::string& url,
                                                const OnMigrated& on_migrated) {
  // Holds the lock, so that no daemon starts during the migration.
  auto data = DataDirectory::Open(directory);
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
  if (status.ok()) status = CopyAll(*file, connection, on_migrated);
  if (!status.ok()) return status;
  return contents;
}

absl::StatusOr<StoreContents> MigrateFromPostgres(const std::string& url, const fs::path& directory,
                                                  const OnMigrated& on_migrated) {
  // Open fails if a daemon uses the directory. RestoreStore checks this again at the end.
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
