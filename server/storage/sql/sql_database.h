// A SQL database under a prior store: SQLite (sqlite_database.h) or PostgreSQL
// (postgres/postgres_connection.h). The store, its reader and its audit log are written once, over
// this interface. Used by one thread at a time.
//
// Both databases run the same statements. `?1` is the first parameter. Text in [] is for SQLite
// alone, and text in {} for PostgreSQL alone. With a SqlBatch, SQLite runs a statement once for
// each row of parameters. PostgreSQL runs it once for all rows: `@given`, inside {}, stands for the
// table of these rows.
//
// A statement is prepared at its first use, and identified by its address: its text must outlive
// the database.
//
// Errors: UNAVAILABLE (full, read-only, locked, I/O, no connection; trying again may help), ABORTED
// (a conflict with another daemon; the transaction can be repeated at once), INVALID_ARGUMENT (a
// value is out of a column's bounds), DATA_LOSS (the database found damage), CANCELLED
// (StopWhen).
#pragma once

#include <array>
#include <atomic>
#include <concepts>
#include <cstdint>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <variant>
#include <vector>

#include "absl/functional/function_ref.h"
#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sweepstake::storage {

// An amount of evidence. PostgreSQL keeps it as whole units of 2⁻²⁰ in a numeric column, whose sums
// are exact in any order. REQUIRES: the value is finite and a multiple of 2⁻²⁰ (InUnits in
// prior_store.h).
struct SqlAmount {
  double value = 0;
};
// The value of a column that may contain any bytes, not only UTF-8.
struct SqlBytes {
  std::string_view value;
};
// A parameter of a statement. It refers to texts, which must outlive it.
using SqlValue = std::variant<int64_t, bool, SqlAmount, std::string_view, SqlBytes>;

inline SqlValue ToSql(SqlAmount value) { return value; }
inline SqlValue ToSql(SqlBytes value) { return value; }
inline SqlValue ToSql(std::string_view value) { return value; }
// Converts counts, which are below 2^63, and seeds, whose 64 bits are kept as a signed integer.
template <std::integral Number>
SqlValue ToSql(Number value) {
  if constexpr (std::same_as<Number, bool>) return value;
  return static_cast<int64_t>(value);
}

// Rows of parameters for one statement, all with the same columns.
class SqlBatch {
 public:
  template <typename... Args>
  void Add(const Args&... args) {
    columns_ = sizeof...(args);
    (values_.push_back(ToSql(args)), ...);
  }
  void Add(std::span<const SqlValue> row) {
    columns_ = row.size();
    values_.insert(values_.end(), row.begin(), row.end());
  }
  bool empty() const { return values_.empty(); }
  size_t columns() const { return columns_; }
  std::span<const SqlValue> values() const { return values_; }

 private:
  std::vector<SqlValue> values_;
  size_t columns_ = 0;
};

// The current row of a result. Its columns are numbered from 0.
class SqlRow {
 public:
  virtual ~SqlRow() = default;

  virtual int64_t Integer(int column) const = 0;
  virtual bool Boolean(int column) const = 0;
  virtual double Amount(int column) const = 0;
  // Returns a count, limited to 2^63 - 1.
  virtual uint64_t Count(int column) const = 0;
  virtual std::string Text(int column) const = 0;
  virtual std::string Bytes(int column) const = 0;
  uint64_t Unsigned(int column) const { return static_cast<uint64_t>(Integer(column)); }
  // REQUIRES: the number is below 2^32.
  uint32_t Small(int column) const { return static_cast<uint32_t>(Integer(column)); }
};

class SqlDatabase {
 public:
  using OnRow = absl::FunctionRef<void(const SqlRow&)>;

  virtual ~SqlDatabase() = default;

  // Returns whether other daemons write to the same database: true for PostgreSQL.
  virtual bool shared() const = 0;
  // Returns a number that grows with each new connection. After a change, cached data of the
  // database may be wrong.
  virtual uint64_t incarnation() const { return 1; }
  // Implements PriorStore::CheckPlace.
  virtual absl::Status CheckPlace() { return absl::OkStatus(); }
  // Makes statements fail with CANCELLED while the flag is set. In SQLite a running statement also
  // ends soon. Null removes the flag, which must otherwise outlive the database.
  virtual void StopWhen(const std::atomic<bool>* flag) { stop_ = flag; }
  // Begins a transaction that writes. Fails if the file was removed or replaced, because the
  // changes would be lost (CheckPlace).
  virtual absl::Status Begin() = 0;
  // Begins a transaction whose reads all see one state: the state at the first read.
  virtual absl::Status BeginRead() = 0;
  virtual absl::Status Commit() = 0;
  // Ends the transaction, if any.
  virtual void Rollback() = 0;
  // Returns false also if an error, such as a full disk or a lost connection, has ended the
  // transaction.
  virtual bool in_transaction() const = 0;
  // Runs statements without [] and {} marks and without parameters. Ignores rows that they return.
  virtual absl::Status Execute(const std::string& sql) = 0;

  // Run a statement and call `on_row(const SqlRow&)` for each row.
  template <typename... Args>
  absl::Status ForEachRow(const char* sql, OnRow on_row, const Args&... args) {
    const std::array<SqlValue, sizeof...(args)> values = {ToSql(args)...};
    return RunRows(sql, values, values.size(), on_row).status();
  }
  absl::Status ForEachRow(const char* sql, OnRow on_row, const SqlBatch& batch) {
    if (batch.empty()) return absl::OkStatus();
    return RunRows(sql, batch.values(), batch.columns(), on_row).status();
  }
  // Runs a statement and ignores its rows. `args` are values, or one SqlBatch.
  template <typename... Args>
  absl::Status Run(const char* sql, const Args&... args) {
    return ForEachRow(
        sql, [](const SqlRow&) {}, args...);
  }
  // Runs a statement, and returns a value that `add(row, value)` changes for each row.
  template <typename Value, typename Add, typename... Args>
  absl::StatusOr<Value> Collect(const char* sql, Add add, const Args&... args) {
    Value value{};
    absl::Status status = ForEachRow(
        sql, [&](const SqlRow& row) { add(row, value); }, args...);
    if (!status.ok()) return status;
    return value;
  }
  // Return the first column of the statement's only row. Without a row they return 0 or an empty
  // text.
  template <typename... Args>
  absl::StatusOr<int64_t> ReadInteger(const char* sql, const Args&... args) {
    return Collect<int64_t>(
        sql, [](const SqlRow& row, int64_t& value) { value = row.Integer(0); }, args...);
  }
  absl::StatusOr<std::string> ReadText(const char* sql) {
    return Collect<std::string>(sql,
                                [](const SqlRow& row, std::string& value) { value = row.Text(0); });
  }
  // Returns how many rows the statement has changed. REQUIRES: the batch is not empty.
  absl::StatusOr<uint64_t> Change(const char* sql, const SqlBatch& batch) {
    return RunRows(sql, batch.values(), batch.columns(), [](const SqlRow&) {});
  }

 protected:
  SqlDatabase() = default;
  SqlDatabase(SqlDatabase&&) = default;
  SqlDatabase& operator=(SqlDatabase&&) = default;
  // Returns whether the flag of StopWhen is set.
  bool stopped() const { return stop_ != nullptr && *stop_; }

 private:
  // `values` are rows of `columns` values, or none for a statement without parameters.
  virtual absl::StatusOr<uint64_t> RunRows(const char* sql, std::span<const SqlValue> values,
                                           size_t columns, OnRow on_row) = 0;

  const std::atomic<bool>* stop_ = nullptr;
};

// Runs `body` in a transaction that writes, and commits it. Rolls back if `body` or the commit
// fails, and returns that error.
absl::Status InTransaction(SqlDatabase& database, absl::FunctionRef<absl::Status()> body);

// Makes all reads in its scope see one state of the database. A nested scope, or one in a
// transaction, uses the outer state.
class SqlSnapshot {
 public:
  explicit SqlSnapshot(SqlDatabase& database);
  ~SqlSnapshot();
  SqlSnapshot(const SqlSnapshot&) = delete;
  SqlSnapshot& operator=(const SqlSnapshot&) = delete;

  const absl::Status& status() const { return status_; }

 private:
  SqlDatabase& database_;
  const bool nested_;
  absl::Status status_;
};

// Returns the statement for SQLite: without the text in {} and without the marks [ and ].
std::string SqliteText(std::string_view sql);

// Returns the statement for PostgreSQL. `types` are the SQL types of its parameters, such as
// "bigint".
std::string PostgresText(std::string_view sql, std::span<const char* const> types);

// Returns the lines with a line end before and after each, for instr() in SQL; empty for no lines.
// REQUIRES: no line contains a line end, as no name does.
std::string LineList(std::span<const std::string> lines);

}  // namespace sweepstake::storage
