// A thin layer over SQLite's C interface: a connection, prepared statements and rows. Used by one
// thread at a time.
//
// Statements are prepared once; their owner must destroy them before the connection. Errors map to
// UNAVAILABLE (full, read-only, locked, I/O), DATA_LOSS (corrupt, not a database), INVALID_ARGUMENT
// (a CHECK failed), CANCELLED (see StopWhen) and INTERNAL (our SQL is wrong); the message is
// SQLite's.
//
// Every connection has two functions of its own. row_hash(values...) is a 64-bit hash of numbers
// and texts. next_hash(hash, before, after) is `after` if hash equals `before`, that is, if the row
// was undamaged. Otherwise it is a wrong hash, so that a change does not hide the damage.
#pragma once

#include <sqlite3.h>

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <span>
#include <string>
#include <string_view>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sweepstake::storage {

// The columns of the current row, from 0.
class SqliteRow {
 public:
  explicit SqliteRow(sqlite3_stmt* statement) : statement_(statement) {}

  int64_t Integer(int column) const { return sqlite3_column_int64(statement_, column); }
  // Counts are stored as integers below 2^63, seeds as the same 64 bits.
  uint64_t Unsigned(int column) const { return static_cast<uint64_t>(Integer(column)); }
  double Real(int column) const { return sqlite3_column_double(statement_, column); }
  std::string Text(int column) const;

 private:
  sqlite3_stmt* statement_;
};

// Returns the lines with a line end before and after each, for instr() in SQL; empty for no lines.
// REQUIRES: no line contains a line end, as no name does.
std::string LineList(std::span<const std::string> lines);

// A prepared statement, whose first argument is `?1`.
class SqliteStatement {
 public:
  SqliteStatement() = default;
  explicit SqliteStatement(sqlite3_stmt* statement) : statement_(statement) {}

  // Runs the statement to its end and calls `on_row(const SqliteRow&)` for each row.
  template <typename OnRow, typename... Args>
  absl::Status ForEachRow(OnRow on_row, const Args&... args) {
    const Resetter resetter{statement_.get()};
    int index = 0;
    (Bind(++index, args), ...);
    int code = SQLITE_ROW;
    while ((code = sqlite3_step(statement_.get())) == SQLITE_ROW)
      on_row(SqliteRow(statement_.get()));
    return code == SQLITE_DONE ? absl::OkStatus() : Error(code);
  }

  template <typename... Args>
  absl::Status Run(const Args&... args) {
    return ForEachRow([](const SqliteRow&) {}, args...);
  }

 private:
  struct Finalizer {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  // Makes the statement ready for its next use and releases the read snapshot.
  struct Resetter {
    sqlite3_stmt* statement;
    ~Resetter() {
      sqlite3_reset(statement);
      sqlite3_clear_bindings(statement);
    }
  };

  void Bind(int index, uint64_t value) {
    sqlite3_bind_int64(statement_.get(), index, static_cast<int64_t>(value));
  }
  void Bind(int index, uint32_t value) { sqlite3_bind_int64(statement_.get(), index, value); }
  void Bind(int index, int64_t value) { sqlite3_bind_int64(statement_.get(), index, value); }
  void Bind(int index, double value) { sqlite3_bind_double(statement_.get(), index, value); }
  // The text must live until the statement has run, as the arguments of ForEachRow do.
  void Bind(int index, std::string_view text);
  absl::Status Error(int code) const;

  std::unique_ptr<sqlite3_stmt, Finalizer> statement_;
};

// Adds the name of the file to an error.
absl::Status Explain(const std::filesystem::path& path, const absl::Status& status);

// Receives the duration of an fsync.
using OnSync = std::function<void(std::chrono::nanoseconds)>;

class SqliteDatabase {
 public:
  enum class OpenMode { kExisting, kCreate, kReadOnly };

  ~SqliteDatabase();
  SqliteDatabase(SqliteDatabase&&) noexcept;
  SqliteDatabase& operator=(SqliteDatabase&&) = delete;

  // An existing file is not read before the first statement.
  static absl::StatusOr<SqliteDatabase> Open(const std::string& path, OpenMode mode);

  // Reads the schema, and sets the pragmas of every connection that writes: the timeout for locks,
  // the checks of what is read, and that a commit is on disk when it returns.
  absl::Status Configure();
  absl::StatusOr<SqliteStatement> Prepare(std::string_view sql);
  // Runs several statements without arguments and rows.
  absl::Status Execute(const std::string& sql);
  // Return the single value of a pragma or query.
  absl::StatusOr<int64_t> QueryInteger(std::string_view sql);
  absl::StatusOr<std::string> QueryText(std::string_view sql);
  // Writes all that is committed to a new file at `path`, replacing an existing one. Others may
  // write meanwhile. Reads the whole database once. The file appears whole or not at all, after
  // `edit`, if any, has changed it.
  using Edit = std::function<void(SqliteDatabase&)>;
  absl::Status CopyTo(const std::string& path, const Edit& edit = {});
  // Makes statements and copies end with CANCELLED soon after the flag is set. The flag must
  // outlive the connection.
  void StopWhen(const std::atomic<bool>& flag);
  // Returns false also if an error, such as a full disk, has ended the transaction.
  bool in_transaction() const { return sqlite3_get_autocommit(database_.get()) == 0; }
  // Limits the size of the file, at least to its present size. Writes that need more fail as on a
  // full disk.
  absl::Status LimitSize(uint64_t max_bytes);
  // Returns the bytes in use, including those in the log: what LimitSize bounds. The file grows
  // only when its unused bytes are used up.
  absl::StatusOr<uint64_t> UsedBytes();
  // Forbids statements that write the schema's own tables or could corrupt the file.
  absl::Status EnableDefensive();
  // Makes everything durable that a reader can see. A killed process may have left commits in the
  // log that never reached the disk. Needs no space. REQUIRES: the database is in WAL mode and was
  // read before.
  absl::Status SyncLog();
  // Calls `on_sync` after each fsync of the write-ahead log from now on. REQUIRES: the database is
  // in WAL mode and was read before.
  absl::Status TimeSyncs(OnSync on_sync);

 private:
  struct TimedFile;
  struct Closer {
    void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  };
  explicit SqliteDatabase(sqlite3* database);
  absl::Status Error(int code) const;
  // Overwrites the copy's file with the pages of this one.
  absl::Status CopyPagesTo(SqliteDatabase& copy);
  // Returns the open file of the write-ahead log.
  absl::StatusOr<sqlite3_file*> LogFile();

  const std::atomic<bool>* stop_ = nullptr;
  std::unique_ptr<TimedFile> timed_log_;  // used by the connection, which ends before it
  std::unique_ptr<sqlite3, Closer> database_;
};

// Runs BEGIN IMMEDIATE at once, and ROLLBACK at the end of the scope unless it was committed.
class SqliteTransaction {
 public:
  explicit SqliteTransaction(SqliteDatabase& database)
      : database_(database), begun_(database.Execute("BEGIN IMMEDIATE")) {}
  ~SqliteTransaction();
  SqliteTransaction(const SqliteTransaction&) = delete;
  SqliteTransaction& operator=(const SqliteTransaction&) = delete;

  const absl::Status& begun() const { return begun_; }
  absl::Status Commit();

 private:
  SqliteDatabase& database_;
  absl::Status begun_;
  bool committed_ = false;
};

}  // namespace sweepstake::storage
