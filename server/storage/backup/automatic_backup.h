// Backups that the daemon makes by itself, the start with one of them where the database is
// damaged, and one of a database whose file was removed or replaced while it is in use.
//
// They lie beside the database, NAME.backup-TIME, and have no rows that are not what was written; a
// damaged database is kept as NAME.quarantine-TIME. Of both there are a few, and the oldest go.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>

#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/private_file.h"
#include "server/storage/read_thread.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

struct OpenedStore {
  std::unique_ptr<priors::PriorStore> store;
  std::unique_ptr<ReadConnection> reads;  // of the same file; ends before the store
  std::string damage;  // what of the priors was lost, and what to do; empty if nothing
  FileId file;         // that both have
};

// Opens the store as OpenSqlitePriorStore does. If the file is damaged, it is put into quarantine,
// and a copy of the last whole backup opened in its place; without one the error is as there, with
// what to do, and nothing is changed. The connection that reads is opened last, so that both have
// the same file. It reads the rows of the evidence once, for their hashes.
absl::StatusOr<OpenedStore> OpenStoreOrBackup(const std::filesystem::path& path,
                                              const priors::AuditLimits& audit_limits = {},
                                              uint64_t max_bytes = 0, OnSync on_sync = {});

// Returns when the last backup was made, as the file system tells it, or nothing if there is none.
std::optional<std::filesystem::file_time_type> LastBackupTime(const std::filesystem::path& path);

// Writes all that the store has to a backup of now beside `path`, which is not its file any more;
// makes the directory again, if that is missing, too. It has no check of the copy, since there is
// nothing better, but what `restore` would refuse for wrong rows is without them. Errors:
// UNAVAILABLE, DATA_LOSS. REQUIRES: `store` is of OpenStoreOrBackup.
absl::StatusOr<std::filesystem::path> SaveMisplacedStore(priors::PriorStore& store,
                                                         const std::filesystem::path& path);

struct MadeBackup {
  std::filesystem::path file;
  int64_t damaged_row_count = 0;  // rows of the database that it is without
};

struct BackupPlan {
  std::chrono::milliseconds interval = std::chrono::hours(24);
  size_t count = 3;  // backups that are kept; 0 makes none
  // A database without a backup gets its first one after this time, or the interval if that is
  // less; after a failure the next attempt comes as soon.
  std::chrono::milliseconds patience = std::chrono::minutes(10);
  // Of this file only: of another one that was put in its place there is no backup, which would
  // cost one of this. By default of any.
  FileId file = {};
};

// Makes backups on a thread of its own, with connections of its own, so that commits go on. The
// destructor ends one that is being made.
class AutomaticBackups {
 public:
  // `on_done` is told on that thread of each backup or why there is none.
  using OnDone = std::function<void(const absl::StatusOr<MadeBackup>&)>;

  // Backs up the database `path`.
  AutomaticBackups(std::filesystem::path path, const BackupPlan& plan, OnDone on_done);
  ~AutomaticBackups();
  AutomaticBackups(const AutomaticBackups&) = delete;
  AutomaticBackups& operator=(const AutomaticBackups&) = delete;

  // Begins no further backup, and ends one that is being made as soon as SQLite and the disk let
  // it; does not wait.
  void Stop();

 private:
  void Loop();
  std::chrono::milliseconds FirstDelay() const;
  absl::StatusOr<MadeBackup> MakeOne();

  const std::filesystem::path path_;
  const BackupPlan plan_;
  const OnDone on_done_;
  std::atomic<bool> stopping_ = false;
  std::mutex mutex_;
  std::condition_variable changed_;
  std::thread thread_;  // last: it uses the others
};

}  // namespace sweepstake::storage
