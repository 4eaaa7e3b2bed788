// The daemon's automatic backups. If the database is damaged when the daemon starts, the latest
// good backup replaces it. A database whose file was removed or replaced while in use is saved,
// too.
//
// Backups lie beside the database as NAME.backup-NUMBER-TIME, and contain no damaged rows. A
// damaged database is kept as NAME.quarantine-NUMBER-TIME. The number is that of the newest such
// file plus one, so a wrong wall clock does not change their order. Only the newest
// BackupPlan::count backups and the newest two damaged databases are kept.
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
  std::unique_ptr<ReadConnection> reads;  // reads the same file; destroyed before `store`
  std::string damage;                     // which priors were lost, and what to do; empty if none
  FileId file;  // the file that `store` and `reads` use; both fields 0 for PostgreSQL
};

// Opens the store as OpenSqlitePriorStore does. If the file is damaged, it is put into quarantine,
// and a copy of the last whole backup is opened in its place. Without a backup nothing is changed,
// and the error says what to do. `reads` is opened after `store`, so that both have the same file.
// Also reads all rows of evidence once to check their hashes, and compares the number of commits
// with the CommitMark.
absl::StatusOr<OpenedStore> OpenStoreOrBackup(const std::filesystem::path& path,
                                              const priors::AuditLimits& audit_limits = {},
                                              uint64_t max_bytes = 0, OnSync on_sync = {});

// Returns the modification time of the newest backup file, or nothing if there is no backup.
std::optional<std::filesystem::file_time_type> LastBackupTime(const std::filesystem::path& path);

// Writes the content of the open store to a new backup beside `path`. Used if the store's file was
// removed from `path`, or replaced, while the daemon used it. Makes the directory if it is missing.
// Keeps the copy without a check, because it is the only one. Leaves out damaged rows, because
// `restore` would refuse them. Errors: UNAVAILABLE, DATA_LOSS. REQUIRES: OpenStoreOrBackup returned
// `store`.
absl::StatusOr<std::filesystem::path> SaveMisplacedStore(priors::PriorStore& store,
                                                         const std::filesystem::path& path);

struct MadeBackup {
  std::filesystem::path file;
  int64_t damaged_row_count = 0;  // damaged rows of the database, which the backup leaves out
};

struct BackupPlan {
  std::chrono::milliseconds interval = std::chrono::hours(24);
  size_t count = 3;  // backups that are kept; 0 makes none
  // Delay of the first backup if the database has none yet, and of the next attempt after a
  // failure. Limited to `interval`.
  std::chrono::milliseconds patience = std::chrono::minutes(10);
  // The database file that the daemon opened. If `path` names another file by now, no backup is
  // made, because it would replace the oldest backup of this file. The default disables this check.
  FileId file = {};
};

// Makes backups on a thread and connections of its own, so that commits do not wait. The destructor
// cancels a backup in progress.
class AutomaticBackups {
 public:
  // Called on the backup thread after each attempt, with the backup or the error.
  using OnDone = std::function<void(const absl::StatusOr<MadeBackup>&)>;

  // Backs up the database `path`.
  AutomaticBackups(std::filesystem::path path, const BackupPlan& plan, OnDone on_done);
  ~AutomaticBackups();
  AutomaticBackups(const AutomaticBackups&) = delete;
  AutomaticBackups& operator=(const AutomaticBackups&) = delete;

  // Begins no further backup, and cancels one in progress as soon as SQLite and the disk allow it.
  // Does not wait.
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
  std::thread thread_;  // the last member, because it uses the others
};

}  // namespace sweepstake::storage
