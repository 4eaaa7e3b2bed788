// The daemon's data directory, which one process at a time holds.
//
// The object owns the lock until it is destroyed; if the process is killed, the system releases the
// lock. Movable.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"

namespace sweepstake::storage {

class DataDirectory {
 public:
  // Creates the directory, but not its parents, if it is missing. Errors: UNAVAILABLE (cannot
  // create or write it, or another daemon holds it).
  static absl::StatusOr<DataDirectory> Open(const std::filesystem::path& path);
  ~DataDirectory();
  DataDirectory(DataDirectory&& other) noexcept;
  DataDirectory& operator=(DataDirectory&&) = delete;

  std::filesystem::path database() const { return path_ / "priors.db"; }

 private:
  DataDirectory(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}

  std::filesystem::path path_;
  int lock_;  // descriptor of the locked file; -1 after a move
};

}  // namespace sweepstake::storage
