// Files that appear whole or not at all and that only their owner can read, and checks of which
// file a name refers to.
#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sweepstake::storage {

// Makes an empty file that only its owner can read. First removes a file of that name, and SQLite's
// -wal, -shm and -journal files beside it. Error: UNAVAILABLE.
absl::Status CreatePrivateFile(const std::filesystem::path& path);

// Renames a file to its final name. After a power failure the file is complete or missing. Error:
// UNAVAILABLE.
absl::Status PublishFile(const std::filesystem::path& unfinished,
                         const std::filesystem::path& path);

// Identifies a file by device and inode. Both are 0 if the file is missing. While a file is open,
// no other file gets its inode.
struct FileId {
  uint64_t device = 0;
  uint64_t inode = 0;

  // Returns the identity of the file that `path` names now. Error: UNAVAILABLE (`stat` fails).
  static absl::StatusOr<FileId> Of(const std::filesystem::path& path);
  friend bool operator==(const FileId&, const FileId&) = default;
};

// Files in use. Stores the identity of each file when it is added.
class FilesInUse {
 public:
  // Error: UNAVAILABLE (`stat` fails).
  absl::Status Add(const std::filesystem::path& path);
  // Checks that each path still names the same file. Errors: NOT_FOUND (a file was removed or
  // replaced), UNAVAILABLE.
  absl::Status Check() const;

 private:
  std::vector<std::pair<std::filesystem::path, FileId>> files_;
};

}  // namespace sweepstake::storage
