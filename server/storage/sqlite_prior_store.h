// The prior store on SQLite: one file with a write-ahead log and synchronous commits. Used by one
// thread at a time.
//
// Before each change it is looked whether the file and its log still are what their names mean:
// what is written to a file without a name is lost with the process. Then nothing is written until
// they are back.
//
// A commit takes one fsync, however many increments it has. Import and Revoke add the sums of the
// keys they change anew, from one row per source. What it reads it reads as SqlitePriorReader does.
#pragma once

#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

// Opens the store, whose file does not grow beyond `max_bytes` (0: any size): then commits that
// need more are UNAVAILABLE. `on_sync`, if there is one, is told on the using thread how long each
// fsync of the write-ahead log took. The errors are those of OpenPriorDatabase.
absl::StatusOr<std::unique_ptr<priors::PriorStore>> OpenSqlitePriorStore(
    const std::filesystem::path& path, const priors::AuditLimits& audit_limits = {},
    uint64_t max_bytes = 0, std::function<void(std::chrono::nanoseconds)> on_sync = {});

// Changes the limits of the audit log, whose rows beyond them are removed, and how large the file
// may grow, at least to its present size. REQUIRES: `store` is of OpenSqlitePriorStore.
absl::Status LimitStore(priors::PriorStore& store, const priors::AuditLimits& audit_limits,
                        uint64_t max_bytes);

// Returns how many bytes of what the file may grow to are in use; what was removed is used again.
// Errors: UNAVAILABLE, DATA_LOSS. REQUIRES: `store` is of OpenSqlitePriorStore.
absl::StatusOr<uint64_t> UsedBytes(priors::PriorStore& store);

// Writes all that is committed to `file`, in place of one that is there, also where the store's own
// has no name any more; and takes the log into the store's file, so that an empty log stays beside
// whatever has its name now. The file appears after `edit`. Errors: UNAVAILABLE, DATA_LOSS.
// REQUIRES: `store` is of OpenSqlitePriorStore.
absl::Status CopyStore(priors::PriorStore& store, const std::filesystem::path& file,
                       const SqliteDatabase::Edit& edit);

// A place in the evidence, which is ordered by source and key. By default before all.
struct FoldPlace {
  int64_t source = 0;
  int64_t key = 0;
};

struct FoldStep {
  FoldPlace next;
  uint64_t source_count = 0;  // sources whose evidence was folded
  uint64_t record_count = 0;  // rows of evidence that this took
  bool last = false;          // there is no evidence behind `next`
};

// So many rows take as long as a group of commits.
inline constexpr uint32_t kRowsPerFold = 200;

// Looks at the next `row_count` rows of evidence, and folds those of sessions of this store that
// were last seen at `last_unix_s` or before: the row is added to one for its key and the calendar
// month (UTC) in which the session was last seen, and removed. Sums and numbers of sources stay as
// they are, to the bit. The session stays with its progress, so that what is sent again is ignored,
// and what is new of it is added. Its own part can no longer be exported or revoked. Rows that are
// damaged, and those of sessions from before their times were kept, stay as they are.
//
// All of a step is done or nothing. Errors: UNAVAILABLE, DATA_LOSS. REQUIRES: `store` is of
// OpenSqlitePriorStore; row_count > 0.
absl::StatusOr<FoldStep> FoldSources(priors::PriorStore& store, const FoldPlace& after,
                                     uint64_t last_unix_s, uint32_t row_count = kRowsPerFold);

}  // namespace sweepstake::storage
