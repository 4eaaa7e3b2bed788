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

// Gives a new file that root has made to the owner of its directory, so that the daemon, which runs
// as that user, can use files that an administrator made. Leaves the file as it is if root may not
// change the owner, and for other users. `path` names the open file.
void GiveToOwner(int file, const std::filesystem::path& path);

// Makes an empty file. Replaces a file that an earlier attempt left, with SQLite's logs beside it.
// Error: UNAVAILABLE.
absl::Status CreatePrivateFile(const std::filesystem::path& path);

// Renames a file to its final name. After a power failure the file is complete or missing. Error:
// UNAVAILABLE.
absl::Status PublishFile(const std::filesystem::path& unfinished,
                         const std::filesystem::path& path);

// A file, identified by device and inode; both 0: missing. While it is open, no other file has its
// inode.
struct FileId {
  uint64_t device = 0;
  uint64_t inode = 0;

  // Returns the file of that name. Error: UNAVAILABLE (it cannot be determined).
  static absl::StatusOr<FileId> Of(const std::filesystem::path& path);
  friend bool operator==(const FileId&, const FileId&) = default;
};

// Files in use, with the identity that each name had at the start.
class FilesInUse {
 public:
  // Error: UNAVAILABLE (the file cannot be determined).
  absl::Status Add(const std::filesystem::path& path);
  // Errors: NOT_FOUND (a file was removed or replaced), UNAVAILABLE.
  absl::Status Check() const;

 private:
  std::vector<std::pair<std::filesystem::path, FileId>> files_;
};

}  // namespace sweepstake::storage
