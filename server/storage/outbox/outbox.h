// The updates that a daemon could not commit to the store that it shares with others. They are kept
// in a file of its data directory, so that they outlive the daemon.
//
// The clients have received no acknowledgement of these updates. If a session continues at another
// daemon, its client sends the updates again there, and the store refuses those in the outbox
// (SourceWriter). The store also ignores an update whose sequence number it already has. Each
// message therefore counts once.
//
// The file is an SQLite database of one table, with a row per update in the order of commits. Used
// by one thread at a time.
#pragma once

#include <cstddef>
#include <filesystem>
#include <span>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/sessions/prior_store.h"
#include "server/storage/sqlite_database.h"

namespace sweepstake::storage {

class Outbox {
 public:
  // Makes the file if it is missing. Errors: UNAVAILABLE (it cannot be read or made), DATA_LOSS (it
  // is not an outbox, has another version, or is damaged).
  static absl::StatusOr<Outbox> Open(const std::filesystem::path& path);

  // Replaces the content by these updates. Error: UNAVAILABLE; then the content is unchanged.
  absl::Status Replace(std::span<const priors::SourceUpdate> updates);
  // Returns the updates in commit order. Errors: UNAVAILABLE (cannot be read), DATA_LOSS (damaged).
  absl::StatusOr<std::vector<priors::SourceUpdate>> Load();

  struct Delivery {
    size_t committed_count = 0;  // committed by this call, or already in the store
    size_t refused_count = 0;    // of sessions that continued elsewhere or were revoked
  };
  // Commits all updates in order and empties the outbox. Updates that the store refuses are counted
  // and dropped. After an error the outbox is unchanged. Errors: those of Load, and of
  // PriorStore::Commit except refusals.
  absl::StatusOr<Delivery> DeliverTo(priors::PriorStore& store);

 private:
  Outbox(std::filesystem::path path, SqliteDatabase database)
      : path_(std::move(path)), database_(std::move(database)) {}

  std::filesystem::path path_;
  SqliteDatabase database_;
};

// Checks that the outbox at `path` is empty or missing, so that the shared store can be migrated or
// given up. Errors: FAILED_PRECONDITION (the outbox has updates), and those of Open and Load.
absl::Status CheckDelivered(const std::filesystem::path& path);

}  // namespace sweepstake::storage
