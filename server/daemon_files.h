// The small files of a daemon: the secret of its sessions, the logins to its dashboard, and its
// ports. Not thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/web/api/logins.h"

namespace sweepstake::server {

// Returns the secret of the data directory's sessions; creates it at the first start. Errors:
// UNAVAILABLE (cannot be created), DATA_LOSS (cannot be read, or is damaged).
absl::StatusOr<std::string> ReadResumeKey(const std::filesystem::path& path);

// Returns the stored logins; none if there is no file. Error: DATA_LOSS (the file is damaged).
absl::StatusOr<std::vector<web::Login>> ReadLogins(const std::filesystem::path& path);
// Replaces the stored logins. The file is complete whenever the process ends; a power failure may
// destroy it. Error: UNAVAILABLE.
absl::Status WriteLogins(const std::filesystem::path& path, const std::vector<web::Login>& logins);

// The file of Config::port_file; if the path is empty, both functions do nothing. Errors:
// UNAVAILABLE.
class PortFile {
 public:
  explicit PortFile(std::filesystem::path path) : path_(std::move(path)) {}

  // Removes the file of an earlier daemon, so that a waiting process does not read its port.
  absl::Status Remove() const;
  // Renames a complete file into place, so that a waiting process never reads a part of it.
  absl::Status Write(int port, std::optional<int> http_port) const;

 private:
  const std::filesystem::path path_;
};

}  // namespace sweepstake::server
