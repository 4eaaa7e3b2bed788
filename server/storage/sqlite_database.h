// A thin layer over SQLite's C interface: a connection, prepared statements and rows. Used by one
// thread at a time.
//
// Errors map to UNAVAILABLE (full, read-only, locked, I/O), DATA_LOSS (corrupt, not a database),
// INVALID_ARGUMENT (a CHECK failed), CANCELLED (see StopWhen) and INTERNAL (our SQL is wrong); the
// message is SQLite's.
//
// Every connection has three SQL functions in addition to SQLite's:
// - row_hash(values...) is a 64-bit hash of numbers and texts.
// - next_hash(hash, before, after) is the new hash of a row whose content hash changes from
//   `before` to `after`. It is `after` if the stored `hash` equals `before`: the row was undamaged.
//   Otherwise it is a wrong hash, so that the change does not hide the damage.
// - octet_length(text) is the number of bytes of the text, as in PostgreSQL and in SQLite from 3.43
//   on.
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
#include <unordered_map>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/storage/private_file.h"
#include "server/storage/sql/sql_database.h"

namespace sweepstake::storage {

// Adds the name of the file to an error.
absl::Status Explain(const std::filesystem::path& path, const absl::Status& status);

// Receives the duration of an fsync.
using OnSync = std::function<void(std::chrono::nanoseconds)>;

class SqliteDatabase final : public SqlDatabase {
 public:
  enum class OpenMode { kExisting, kCreate, kReadOnly };

  ~SqliteDatabase() override;
  SqliteDatabase(SqliteDatabase&&) noexcept;
  SqliteDatabase& operator=(SqliteDatabase&&) = delete;

  // Opens the file, but does not read it before the first statement.
  static absl::StatusOr<SqliteDatabase> Open(const std::string& path, OpenMode mode);

  // Reads the schema, and sets the pragmas that every connection needs: a timeout for locks, checks
  // of the data that is read, and commits that are on disk when they return.
  absl::Status Configure();
  absl::Status Execute(const std::string& sql) override;
  // Return the single value of a pragma or query.
  absl::StatusOr<int64_t> QueryInteger(std::string_view sql);
  absl::StatusOr<std::string> QueryText(std::string_view sql);
  // Writes the committed content to a new file at `path`, replacing an existing one. Reads the
  // whole database once; other connections can write during that time. `edit`, if any, changes the
  // copy before it appears at `path`. After an error, of `edit` too, no new file appears.
  using Edit = std::function<absl::Status(SqliteDatabase&)>;
  absl::Status CopyTo(const std::string& path, const Edit& edit = {});
  // Also ends copies.
  void StopWhen(const std::atomic<bool>* flag) override;
  // Remembers the file at `path` and its write-ahead log. From now on CheckPlace fails if one of
  // them was removed or replaced, or if the database was cut.
  absl::Status SetPlace(const std::filesystem::path& path);

  bool shared() const override { return false; }
  absl::Status CheckPlace() override { return files_.Check(); }
  absl::Status Begin() override;
  absl::Status BeginRead() override { return Execute("BEGIN"); }
  absl::Status Commit() override { return Execute("COMMIT"); }
  void Rollback() override;
  bool in_transaction() const override { return sqlite3_get_autocommit(database_.get()) == 0; }
  // Limits the size of the file to `max_bytes`, or to its present size if that is larger. Writes
  // that need more fail as on a full disk.
  absl::Status LimitSize(uint64_t max_bytes);
  // Returns the bytes in use, including those that are still in the write-ahead log. The file grows
  // only if it has no unused bytes left, so LimitSize limits these bytes.
  absl::StatusOr<uint64_t> UsedBytes();
  // Forbids statements that write the schema's own tables or could corrupt the file.
  absl::Status EnableDefensive();
  // Makes all commits durable that a reader can see. A killed process may have left commits in the
  // write-ahead log that never reached the disk. Needs no free disk space. REQUIRES: the database
  // is in WAL mode and was read before.
  absl::Status SyncLog();
  // Calls `on_sync` after each fsync of the write-ahead log from now on. REQUIRES: the database is
  // in WAL mode and was read before.
  absl::Status TimeSyncs(OnSync on_sync);

 private:
  struct TimedFile;
  struct Closer {
    void operator()(sqlite3* database) const { sqlite3_close_v2(database); }
  };
  struct Finalizer {
    void operator()(sqlite3_stmt* statement) const { sqlite3_finalize(statement); }
  };
  using Statement = std::unique_ptr<sqlite3_stmt, Finalizer>;

  explicit SqliteDatabase(sqlite3* database);
  absl::StatusOr<Statement> Prepare(std::string_view sql);
  // Runs the statement to its end.
  absl::Status Step(sqlite3_stmt* statement, std::span<const SqlValue> values, OnRow on_row);
  absl::StatusOr<uint64_t> RunRows(const char* sql, std::span<const SqlValue> values,
                                   size_t columns, OnRow on_row) override;
  absl::Status Error(int code) const;
  // Overwrites the file of `copy` with the pages of this database.
  absl::Status CopyPagesTo(SqliteDatabase& copy);
  // Returns the open file of the write-ahead log.
  absl::StatusOr<sqlite3_file*> LogFile();

  std::unique_ptr<TimedFile> timed_log_;  // used by database_, which is destroyed before it
  std::unique_ptr<sqlite3, Closer> database_;
  // By address of the SQL text; destroyed before database_.
  std::unordered_map<const char*, Statement> statements_;
  FilesInUse files_;
};

}  // namespace sweepstake::storage
