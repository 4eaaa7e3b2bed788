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

  // Returns the identity of the file that `path` names now, and its size if `bytes` is not null.
  // Error: UNAVAILABLE (`stat` fails).
  static absl::StatusOr<FileId> Of(const std::filesystem::path& path, uint64_t* bytes = nullptr);
  friend bool operator==(const FileId&, const FileId&) = default;
};

// Files in use. Stores the identity of each file when it is added.
class FilesInUse {
 public:
  // `may_shrink`: the file may become shorter. Error: UNAVAILABLE (`stat` fails).
  absl::Status Add(const std::filesystem::path& path, bool may_shrink);
  // Checks that each path still names the same file, and that it was not cut. Errors: NOT_FOUND (a
  // file was removed, replaced or cut), UNAVAILABLE.
  absl::Status Check();

 private:
  struct File {
    std::filesystem::path path;
    FileId id;
    bool may_shrink = false;
    uint64_t bytes = 0;  // the largest size so far
  };

  std::vector<File> files_;
};

}  // namespace sweepstake::storage
