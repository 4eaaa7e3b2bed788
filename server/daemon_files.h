// The small files of a daemon: the secret of its sessions, the logins of its page, and the ports
// that it has. Not thread-safe.
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

// Returns the secret of the data directory's sessions, which is made at the first start. Errors:
// UNAVAILABLE (cannot be made), DATA_LOSS (cannot be read, or is damaged).
absl::StatusOr<std::string> ReadResumeKey(const std::filesystem::path& path);

// Returns the logins that were kept; none where there is no file. Error: DATA_LOSS (not all can be
// read).
absl::StatusOr<std::vector<web::Login>> ReadLogins(const std::filesystem::path& path);
// Keeps these in place of all others. The file is whole whenever the process ends; a power failure
// may take it. Error: UNAVAILABLE.
absl::Status WriteLogins(const std::filesystem::path& path, const std::vector<web::Login>& logins);

// The file of Config::port_file; with an empty path there is none, and nothing is done. Errors:
// UNAVAILABLE.
class PortFile {
 public:
  explicit PortFile(std::filesystem::path path) : path_(std::move(path)) {}

  // Removes the file of an earlier daemon: it would name a port that nobody serves, and a waiting
  // process must not read it.
  absl::Status Remove() const;
  // The file appears whole, so that a process that waits for it never reads a part of it.
  absl::Status Write(int port, std::optional<int> http_port) const;

 private:
  const std::filesystem::path path_;
};

}  // namespace sweepstake::server
