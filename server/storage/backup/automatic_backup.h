// Backups that the daemon makes by itself, the start from a backup if the database is damaged, and
// the backup of a database whose file was removed or replaced while it is in use.
//
// They lie beside the database, as NAME.backup-TIME, and contain no damaged rows. A damaged
// database is kept as NAME.quarantine-TIME. A few of both are kept, and the oldest are removed.
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
  std::string damage;                     // which priors were lost, and what to do; empty if none
  FileId file;                            // the file of both
};

// Opens the store as OpenSqlitePriorStore does. If the file is damaged, it is put into quarantine,
// and a copy of the last whole backup is opened in its place. Without a backup nothing is changed,
// and the error says what to do. The connection that reads is opened last, so that both have the
// same file. Reads the rows of the evidence once, for their hashes.
absl::StatusOr<OpenedStore> OpenStoreOrBackup(const std::filesystem::path& path,
                                              const priors::AuditLimits& audit_limits = {},
                                              uint64_t max_bytes = 0, OnSync on_sync = {});

// Returns when the last backup was made, by the time of its file, or nothing if there is none.
std::optional<std::filesystem::file_time_type> LastBackupTime(const std::filesystem::path& path);

// Writes all that the store has to a new backup beside `path`, which is not the store's file any
// more. Makes the directory if it is missing. The copy is not checked, since it is all that is
// left, but contains no damaged rows, because `restore` would refuse it. Errors: UNAVAILABLE,
// DATA_LOSS. REQUIRES: `store` is of OpenStoreOrBackup.
absl::StatusOr<std::filesystem::path> SaveMisplacedStore(priors::PriorStore& store,
                                                         const std::filesystem::path& path);

struct MadeBackup {
  std::filesystem::path file;
  int64_t damaged_row_count = 0;  // rows of the database that are left out
};

struct BackupPlan {
  std::chrono::milliseconds interval = std::chrono::hours(24);
  size_t count = 3;  // backups that are kept; 0 makes none
  // Delay of the first backup of a database without one, and of the next attempt after a failure.
  // At most the interval.
  std::chrono::milliseconds patience = std::chrono::minutes(10);
  // Only this file is backed up. A backup of another file in its place would cost one of this file.
  // By default any file.
  FileId file = {};
};

// Makes backups on a thread and connections of its own, so that commits go on. The destructor
// cancels a backup in progress.
class AutomaticBackups {
 public:
  // Called on that thread after each backup, with the backup or the error.
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
  std::thread thread_;  // last: it uses the others
};

}  // namespace sweepstake::storage
