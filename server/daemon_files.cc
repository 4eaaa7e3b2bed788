#include "server/daemon_files.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <fstream>
#include <iterator>
#include <system_error>

#include "absl/strings/str_cat.h"
#include "server/storage/private_file.h"

namespace sweepstake::server {
namespace fs = std::filesystem;
namespace {

using ResumeKey = std::array<char, 32>;

absl::Status Failed(const fs::path& path) {
  return absl::UnavailableError(
      absl::StrCat(path.string(), ": ", std::generic_category().message(errno)));
}

absl::Status MakeResumeKey(const fs::path& path) {
  ResumeKey key;
  const absl::Status status = getentropy(key.data(), key.size()) == 0
                                  ? ReplaceText(path, std::string(key.data(), key.size()))
                                  : Failed(path);
  if (status.ok()) return status;
  return absl::UnavailableError(
      absl::StrCat("cannot create ", status.message(), "; make the data directory writable"));
}

}  // namespace

absl::StatusOr<std::string> ReadResumeKey(const fs::path& path) {
  std::error_code unknown;  // a file that cannot be examined cannot be read either
  if (!fs::exists(path, unknown)) {
    if (absl::Status status = MakeResumeKey(path); !status.ok()) return status;
  }
  std::string key = ReadText(path);
  if (key.size() == std::tuple_size_v<ResumeKey>) return key;
  return absl::DataLossError(absl::StrCat(
      path.string(), " cannot be read or is damaged; if you remove it, games start new sessions"));
}

std::string ReadText(const fs::path& path) {
  std::error_code ignored;
  if (!fs::is_regular_file(path, ignored)) return {};
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

absl::Status ReplaceText(const fs::path& path, const std::string& text) {
  const fs::path unfinished = path.string() + ".new";
  if (absl::Status status = storage::CreatePrivateFile(unfinished); !status.ok()) return status;
  std::ofstream file(unfinished, std::ios::binary);
  file.write(text.data(), static_cast<std::streamsize>(text.size())).flush();
  return file ? storage::PublishFile(unfinished, path) : Failed(unfinished);
}

absl::Status PortFile::Remove() const {
  std::error_code ignored;
  if (path_.empty() || !fs::exists(path_, ignored)) return absl::OkStatus();
  if (!fs::is_regular_file(path_, ignored))
    return absl::UnavailableError(
        absl::StrCat(path_.string(), " is not a file; name another with --port-file"));
  fs::remove(path_, ignored);
  return absl::OkStatus();
}

absl::Status PortFile::Write(int port, std::optional<int> http_port) const {
  if (path_.empty()) return absl::OkStatus();
  const fs::path unfinished = path_.string() + ".new";
  std::ofstream file(unfinished);
  file << port << '\n';
  if (http_port) file << *http_port << '\n';
  file.close();
  std::error_code error;
  if (!file) {
    error = std::error_code(errno, std::generic_category());
  } else {
    fs::rename(unfinished, path_, error);
  }
  if (file && !error) return absl::OkStatus();
  return absl::UnavailableError(absl::StrCat("cannot write the port file ", path_.string(), ": ",
                                             error.message(), "; name another with --port-file"));
}

}  // namespace sweepstake::server
