// The daemon's data directory, held by one process at a time.
//
// Owns the lock until destroyed; a killed process loses it by itself. Movable.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"

namespace sweepstake::storage {

class DataDirectory {
 public:
  // Creates the directory (not its parents) when it is missing. Errors: UNAVAILABLE (cannot create
  // or write, or another daemon holds it).
  static absl::StatusOr<DataDirectory> Open(const std::filesystem::path& path);
  ~DataDirectory();
  DataDirectory(DataDirectory&& other) noexcept;
  DataDirectory& operator=(DataDirectory&&) = delete;

  std::filesystem::path database() const { return path_ / "priors.db"; }

 private:
  DataDirectory(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}

  std::filesystem::path path_;
  int lock_;  // descriptor of the locked file; -1: moved from
};

}  // namespace sweepstake::storage
