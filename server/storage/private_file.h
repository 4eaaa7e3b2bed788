// Files that appear whole or not at all, and that only their owner can read.
#pragma once

#include <filesystem>

#include "absl/status/status.h"

namespace sweepstake::storage {

// Makes an empty file, in place of one that an earlier attempt left with the logs of SQLite beside
// it. Error: UNAVAILABLE.
absl::Status CreatePrivateFile(const std::filesystem::path& path);

// Renames a file to its final name; after a power failure either it is there, complete, or not at
// all. Error: UNAVAILABLE.
absl::Status PublishFile(const std::filesystem::path& unfinished,
                         const std::filesystem::path& path);

}  // namespace sweepstake::storage
