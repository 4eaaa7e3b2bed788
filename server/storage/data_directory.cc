#include "server/storage/data_directory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <unistd.h>

#include <cerrno>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sweepstake::storage {
namespace fs = std::filesystem;

absl::StatusOr<DataDirectory> DataDirectory::Open(const fs::path& path) {
  std::error_code error;
  fs::create_directory(path, error);
  std::error_code unknown;  // if this fails too, it counts as no directory
  if (!fs::is_directory(path, unknown)) {
    return absl::UnavailableError(absl::StrCat("cannot create the data directory ", path.string(),
                                               ": ",
                                               error ? error.message() : "it is not a directory",
                                               "; make its parent writable, or name another with "
                                               "--data"));
  }
  const fs::path lock_path = path / "lock";
  const int lock = open(lock_path.c_str(), O_RDWR | O_CREAT | O_CLOEXEC, 0600);
  if (lock < 0) {
    const std::string why = std::system_category().message(errno);
    return absl::UnavailableError(absl::StrCat("cannot write to the data directory ", path.string(),
                                               ": ", why,
                                               "; make it writable, or name another with --data"));
  }
  DataDirectory directory(path, lock);
  if (flock(lock, LOCK_EX | LOCK_NB) != 0) {
    return absl::UnavailableError(absl::StrCat("another daemon uses the data directory ",
                                               path.string(),
                                               "; stop it, or name another with --data"));
  }
  return directory;
}

DataDirectory::DataDirectory(DataDirectory&& other) noexcept
    : path_(std::move(other.path_)), lock_(std::exchange(other.lock_, -1)) {}

DataDirectory::~DataDirectory() {
  if (lock_ >= 0) close(lock_);
}

}  // namespace sweepstake::storage
