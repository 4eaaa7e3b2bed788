#include "server/storage/data_directory.h"

#include <fcntl.h>
#include <sys/file.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <string>
#include <system_error>
#include <utility>

#include "absl/strings/str_cat.h"

namespace sweepstake::storage {
namespace fs = std::filesystem;
namespace {

constexpr fs::perms kOthers = fs::perms::group_all | fs::perms::others_all;

bool IsPrivate(const fs::path& path) {
  std::error_code error;
  return (fs::status(path, error).permissions() & kOthers) == fs::perms::none;
}

// Removes access by other users. Returns whether only the owner has access, or the file is missing.
bool MakePrivate(const fs::path& file) {
  std::error_code error;
  if (!fs::exists(file, error) || IsPrivate(file)) return true;
  fs::permissions(file, kOthers, fs::perm_options::remove, error);
  return !error;
}

absl::Status CannotCreate(const fs::path& path, const std::error_code& why) {
  const auto text = [&](const std::string& reason, const std::string& advice) {
    return absl::UnavailableError(absl::StrCat("cannot create the data directory ", path.string(),
                                               ": ", reason, "; ", advice,
                                               ", or name another with --data"));
  };
  if (why == std::errc::file_exists) return text("it is not a directory", "move it away");
  if (why == std::errc::no_such_file_or_directory)
    return text(why.message(), absl::StrCat("make ", path.parent_path().string(), " first"));
  return text(why.message(), "make its parent writable");
}

}  // namespace

absl::StatusOr<DataDirectory> DataDirectory::Open(const fs::path& path) {
  std::error_code error;
  if (mkdir(path.c_str(), 0700) != 0) error = std::error_code(errno, std::system_category());
  std::error_code unknown;  // an error here counts as a missing directory
  if (!fs::is_directory(path, unknown)) {
    return CannotCreate(path, error);
  }
  DataDirectory directory(path, open(path.c_str(), O_RDONLY | O_DIRECTORY | O_CLOEXEC));
  const int lock = directory.lock_;
  if (lock < 0 || faccessat(lock, ".", W_OK | X_OK, AT_EACCESS) != 0) {
    const std::string why = std::system_category().message(errno);
    return absl::UnavailableError(absl::StrCat("cannot write to the data directory ", path.string(),
                                               ": ", why,
                                               "; make it writable, or name another with --data"));
  }
  if (flock(lock, LOCK_EX | LOCK_NB) != 0) {
    return absl::UnavailableError(absl::StrCat("another daemon uses the data directory ",
                                               path.string(),
                                               "; stop it, or name another with --data"));
  }
  directory.open_to_others_ = !IsPrivate(path);
  for (const char* suffix : {"", "-wal", "-shm"}) {
    const fs::path file = directory.database().string() + suffix;
    if (!MakePrivate(file)) directory.open_to_others_ = true;
  }
  if (!MakePrivate(directory.tokens())) directory.open_to_others_ = true;
  return directory;
}

DataDirectory::DataDirectory(DataDirectory&& other) noexcept
    : path_(std::move(other.path_)),
      open_to_others_(other.open_to_others_),
      lock_(std::exchange(other.lock_, -1)) {}

DataDirectory::~DataDirectory() {
  if (lock_ >= 0) close(lock_);
}

}  // namespace sweepstake::storage
