// A thin layer over SQLite's C interface: a connection, prepared statements and rows. Used by one
// thread at a time.
//
// Statements are prepared once; their owner must destroy them before the connection. Errors map to
// UNAVAILABLE (full, read-only, locked, I/O), DATA_LOSS (corrupt, not a database), INVALID_ARGUMENT
// (a CHECK failed), CANCELLED (see StopWhen) and INTERNAL (our SQL is wrong); the message is
// SQLite's.
//
// Every connection has two functions of its own. row_hash(values...) is a 64-bit hash of numbers
// and texts. next_hash(hash, before, after) is `after` for a row whose hash was right, that is,
// equal to `before`; otherwise it is wrong again, so that a change does not hide a damage.
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

// Returns the lines with a line end before and after each, for instr() in SQL; empty if there are
// none. REQUIRES: no line has a line end, as no name does.
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

// Returns the error with the file that it is about.
absl::Status Explain(const std::filesystem::path& path, const absl::Status& status);

// Told how long an fsync took.
using OnSync = std::function<void(std::chrono::nanoseconds)>;

class SqliteDatabase {
 public:
  enum class OpenMode { kExisting, kCreate, kReadOnly };

  ~SqliteDatabase();
  SqliteDatabase(SqliteDatabase&&) noexcept;
  SqliteDatabase& operator=(SqliteDatabase&&) = delete;

  // If the file exists, it is not read before the first statement.
  static absl::StatusOr<SqliteDatabase> Open(const std::string& path, OpenMode mode);

  // Reads the schema, and sets what holds for every connection that writes: how long it waits for
  // others, how it checks what it reads, and that a commit is on disk when it ends.
  absl::Status Configure();
  absl::StatusOr<SqliteStatement> Prepare(std::string_view sql);
  // Runs several statements that have no arguments and no rows.
  absl::Status Execute(const std::string& sql);
  // These return the single value of a pragma or query.
  absl::StatusOr<int64_t> QueryInteger(std::string_view sql);
  absl::StatusOr<std::string> QueryText(std::string_view sql);
  // Writes all that is committed to a new file at `path`, in place of one that is there. Others may
  // write meanwhile; the whole database is read once. The file appears whole or not at all, and
  // after `edit`, if any, has changed it.
  using Edit = std::function<void(SqliteDatabase&)>;
  absl::Status CopyTo(const std::string& path, const Edit& edit = {});
  // Lets statements and copies end with CANCELLED soon after the flag is set, which must outlive
  // the connection.
  void StopWhen(const std::atomic<bool>& flag);
  // Returns false also if an error has ended the transaction, as a full disk does.
  bool in_transaction() const { return sqlite3_get_autocommit(database_.get()) == 0; }
  // Lets the file grow to so many bytes, or not at all if it is as large; then writes that need
  // more fail as if the disk were full.
  absl::Status LimitSize(uint64_t max_bytes);
  // Returns the bytes that are in use, those in the log included: what LimitSize bounds, since the
  // others of the file are used before it grows.
  absl::StatusOr<uint64_t> UsedBytes();
  // Forbids statements that write the schema's own tables or could corrupt the file.
  absl::Status EnableDefensive();
  // Makes everything durable that a reader can see, whoever wrote it. A process that was killed may
  // have left commits in the log that never reached the disk, also where its sync failed. Needs no
  // room. REQUIRES: the database is in WAL mode and was read before.
  absl::Status SyncLog();
  // Tells `on_sync` the duration of each fsync of the write-ahead log from now on. REQUIRES: the
  // database is in WAL mode and was read before.
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

// Runs BEGIN IMMEDIATE now, and ROLLBACK at the end of the scope unless it was committed.
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
