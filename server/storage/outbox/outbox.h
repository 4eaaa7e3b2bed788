// What a daemon that shares its store with others could not commit there: a file in its data
// directory, so that it outlives the daemon.
//
// Nothing in it is acknowledged. A client whose session goes on at another daemon sends it again
// there, and the store then refuses what the outbox has of it (SourceWriter); what the store has
// already it recognises by its number. So each message counts once, whoever delivers it.
//
// An SQLite database of one table, a row per update, in the order in which they are to be
// committed. Used by one thread at a time.
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
  // Makes the file if there is none. Errors: UNAVAILABLE (it cannot be read or made), DATA_LOSS (it
  // is no outbox, of a newer daemon, or damaged).
  static absl::StatusOr<Outbox> Open(const std::filesystem::path& path);

  // Keeps these in place of all that is in it. Error: UNAVAILABLE; then it is as it was.
  absl::Status Replace(std::span<const priors::SourceUpdate> updates);
  // Error: DATA_LOSS (a row is damaged).
  absl::StatusOr<std::vector<priors::SourceUpdate>> Load();

  struct Delivery {
    size_t committed_count = 0;  // now, or before
    size_t refused_count = 0;    // their sessions went on elsewhere, or were revoked
  };
  // Commits all that is in it, one after the other, and empties it. Errors: those of the store but
  // refusals, and of Load; then it is as it was.
  absl::StatusOr<Delivery> DeliverTo(priors::PriorStore& store);

 private:
  Outbox(std::filesystem::path path, SqliteDatabase database)
      : path_(std::move(path)), database_(std::move(database)) {}

  std::filesystem::path path_;
  SqliteDatabase database_;
};

// For those who do without the shared store from now on. Errors: FAILED_PRECONDITION (there is an
// outbox with something in it), and those of Open and Load.
absl::Status CheckDelivered(const std::filesystem::path& path);

}  // namespace sweepstake::storage
