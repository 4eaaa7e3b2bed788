// The updates that a daemon could not commit to the store that it shares with others. They are kept
// in a file of its data directory, so that they outlive the daemon.
//
// None of them is acknowledged. If a session continues at another daemon, its client sends the
// updates again there, and the store refuses those in the outbox (SourceWriter). The store ignores
// an update that it has already, by its number. So each message counts once.
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
  // Error: DATA_LOSS (a row is damaged).
  absl::StatusOr<std::vector<priors::SourceUpdate>> Load();

  struct Delivery {
    size_t committed_count = 0;  // now, or before
    size_t refused_count = 0;    // their sessions continued elsewhere, or were revoked
  };
  // Commits all updates in order and empties the outbox. Errors: those of Load, and those of the
  // store but refusals; then the content is unchanged.
  absl::StatusOr<Delivery> DeliverTo(priors::PriorStore& store);

 private:
  Outbox(std::filesystem::path path, SqliteDatabase database)
      : path_(std::move(path)), database_(std::move(database)) {}

  std::filesystem::path path_;
  SqliteDatabase database_;
};

// Checks that nothing waits for a shared store that is not used any more. Errors:
// FAILED_PRECONDITION (the outbox has updates), and those of Open and Load.
absl::Status CheckDelivered(const std::filesystem::path& path);

}  // namespace sweepstake::storage
