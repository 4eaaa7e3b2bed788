#include "server/daemon_files.h"

#include <unistd.h>

#include <array>
#include <cerrno>
#include <cstdio>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <system_error>

#include "absl/strings/escaping.h"
#include "absl/strings/str_cat.h"
#include "server/storage/private_file.h"

namespace sweepstake::server {
namespace fs = std::filesystem;
namespace {

using ResumeKey = std::array<char, 32>;

// Fills a private file with random bytes.
absl::Status WriteRandomKey(const fs::path& path) {
  if (absl::Status status = storage::CreatePrivateFile(path); !status.ok()) return status;
  ResumeKey key;
  if (getentropy(key.data(), key.size()) == 0 &&
      std::ofstream(path, std::ios::binary).write(key.data(), key.size()).flush())
    return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrCat(path.string(), ": ", std::generic_category().message(errno)));
}

absl::Status MakeResumeKey(const fs::path& path) {
  const fs::path unfinished = path.string() + ".new";
  absl::Status status = WriteRandomKey(unfinished);
  if (status.ok()) status = storage::PublishFile(unfinished, path);
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
  std::ifstream file(path, std::ios::binary);
  std::string key(std::istreambuf_iterator<char>(file), {});
  if (key.size() == std::tuple_size_v<ResumeKey>) return key;
  return absl::DataLossError(absl::StrCat(
      path.string(), " cannot be read or is damaged; if you remove it, games start new sessions"));
}

absl::StatusOr<std::vector<web::Login>> ReadLogins(const fs::path& path) {
  std::ifstream file(path);
  if (!file) return std::vector<web::Login>();
  const auto damaged = absl::DataLossError(
      absl::StrCat(path.string(), " is damaged; users of the dashboard must log in again"));
  const auto json = nlohmann::json::parse(file, nullptr, /*allow_exceptions=*/false);
  if (!json.is_array()) return damaged;
  std::vector<web::Login> logins;
  for (const nlohmann::json& item : json) {
    try {
      web::Login& login = logins.emplace_back();
      login.cookie_digest = item.at("cookie_sha256");
      login.token_digest = item.at("token_sha256");
      if (!absl::Base64Unescape(item.at("sealed_token").get<std::string>(), &login.sealed_token))
        return damaged;
      login.used_unix_s = item.at("used_unix_s");
    } catch (const nlohmann::json::exception&) {
      return damaged;
    }
  }
  return logins;
}

absl::Status WriteLogins(const fs::path& path, const std::vector<web::Login>& logins) {
  nlohmann::json json = nlohmann::json::array();
  for (const web::Login& login : logins) {
    json.push_back({{"cookie_sha256", login.cookie_digest},
                    {"token_sha256", login.token_digest},
                    {"sealed_token", absl::Base64Escape(login.sealed_token)},
                    {"used_unix_s", login.used_unix_s}});
  }
  const fs::path unfinished = path.string() + ".new";
  if (absl::Status status = storage::CreatePrivateFile(unfinished); !status.ok()) return status;
  std::ofstream file(unfinished);
  file << json.dump(1) << '\n';
  file.close();
  if (file && std::rename(unfinished.c_str(), path.c_str()) == 0) return absl::OkStatus();
  return absl::UnavailableError(
      absl::StrCat(path.string(), ": ", std::generic_category().message(errno)));
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
