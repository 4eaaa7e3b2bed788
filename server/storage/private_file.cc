#include "server/storage/private_file.h"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <string>
#include <system_error>

#include "absl/strings/str_cat.h"

namespace sweepstake::storage {
namespace {

namespace fs = std::filesystem;

absl::Status Unavailable(const fs::path& path, int why) {
  return absl::UnavailableError(
      absl::StrCat(path.string(), ": ", std::system_category().message(why)));
}

// Writes the content of a file or directory to the disk (fsync).
absl::Status Sync(const fs::path& path) {
  const int file = open(path.c_str(), O_RDONLY | O_CLOEXEC);
  const bool synced = file >= 0 && fsync(file) == 0;
  const int why = errno;
  if (file >= 0) close(file);
  return synced ? absl::OkStatus() : Unavailable(path, why);
}

fs::path ParentOf(const fs::path& path) {
  return path.has_parent_path() ? path.parent_path() : fs::path(".");
}

// Gives a new file that root has made to the owner of its directory, so that the daemon, which runs
// as that user, can use files that an administrator made. Does nothing if the process does not run
// as root, or if the owner cannot be changed. `file` is the open descriptor of `path`.
void GiveToOwner(int file, const fs::path& path) {
  struct stat made {};
  struct stat parent {};
  if (geteuid() != 0 || stat(ParentOf(path).c_str(), &parent) != 0) return;
  // A file with several hard links may belong to another user: the directory's owner could have
  // linked it here to become its owner. Root must not change its owner then.
  if (fstat(file, &made) != 0 || made.st_nlink != 1) return;
  [[maybe_unused]] const int given = fchown(file, parent.st_uid, parent.st_gid);
}

}  // namespace

absl::Status CreatePrivateFile(const fs::path& path) {
  std::error_code ignored;
  for (const char* suffix : {"", "-wal", "-shm", "-journal"})
    fs::remove(path.string() + suffix, ignored);
  const int file = open(path.c_str(), O_WRONLY | O_CREAT | O_EXCL | O_CLOEXEC, 0600);
  if (file < 0) return Unavailable(path, errno);
  GiveToOwner(file, path);
  close(file);
  return absl::OkStatus();
}

absl::Status PublishFile(const fs::path& unfinished, const fs::path& path) {
  if (absl::Status status = Sync(unfinished); !status.ok()) return status;
  if (std::rename(unfinished.c_str(), path.c_str()) != 0) return Unavailable(path, errno);
  return Sync(ParentOf(path));
}

absl::StatusOr<FileId> FileId::Of(const fs::path& path, uint64_t* bytes) {
  struct stat found {};
  if (stat(path.c_str(), &found) != 0)
    return errno == ENOENT || errno == ENOTDIR ? absl::StatusOr<FileId>(FileId{})
                                               : Unavailable(path, errno);
  if (bytes != nullptr) *bytes = static_cast<uint64_t>(found.st_size);
  return FileId{found.st_dev, found.st_ino};
}

absl::Status FilesInUse::Add(const fs::path& path, bool may_shrink) {
  File file{.path = path, .id = {}, .may_shrink = may_shrink};
  const auto id = FileId::Of(path, &file.bytes);
  if (!id.ok()) return id.status();
  file.id = *id;
  files_.push_back(std::move(file));
  return absl::OkStatus();
}

absl::Status FilesInUse::Check() {
  for (File& file : files_) {
    uint64_t bytes = 0;
    const auto now = FileId::Of(file.path, &bytes);
    if (!now.ok()) return now.status();
    const bool is_cut = !file.may_shrink && bytes < file.bytes;
    if (*now == file.id && !is_cut) {
      file.bytes = bytes;
      continue;
    }
    const char* what = *now == FileId() ? "removed" : *now == file.id ? "cut" : "replaced";
    return absl::NotFoundError(absl::StrCat(file.path.string(), " was ", what,
                                            " while it was in use, and new commits would be lost"));
  }
  return absl::OkStatus();
}

}  // namespace sweepstake::storage
