// Files that appear whole or not at all, and that only their owner can read; and which file a name
// means.
#pragma once

#include <cstdint>
#include <filesystem>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sweepstake::storage {

// Gives a new file that root has made to the owner of the directory that it is in, so that a daemon
// which runs as that user can use what an administrator has made for it. What cannot be given, as
// where root may not, stays as it is, and so does what other users make. `path` names the open
// file.
void GiveToOwner(int file, const std::filesystem::path& path);

// Makes an empty file, in place of one that an earlier attempt left with the logs of SQLite beside
// it. Error: UNAVAILABLE.
absl::Status CreatePrivateFile(const std::filesystem::path& path);

// Renames a file to its final name; after a power failure either it is there, complete, or not at
// all. Error: UNAVAILABLE.
absl::Status PublishFile(const std::filesystem::path& unfinished,
                         const std::filesystem::path& path);

// A file by its device and inode, whatever its name; both 0: there is none. While it is open, no
// other file has its inode.
struct FileId {
  uint64_t device = 0;
  uint64_t inode = 0;

  // Returns which file the name means. Error: UNAVAILABLE (it cannot be told).
  static absl::StatusOr<FileId> Of(const std::filesystem::path& path);
  friend bool operator==(const FileId&, const FileId&) = default;
};

// Files that are in use, and which ones their names meant when that began.
class FilesInUse {
 public:
  // Error: UNAVAILABLE (it cannot be told).
  absl::Status Add(const std::filesystem::path& path);
  // Errors: NOT_FOUND (a name means no file any more, or another one), UNAVAILABLE.
  absl::Status Check() const;

 private:
  std::vector<std::pair<std::filesystem::path, FileId>> files_;
};

}  // namespace sweepstake::storage
