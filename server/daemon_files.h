// The small files of a daemon: the secret of its sessions, and its ports. Not thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sweepstake::server {

// Returns the secret of the data directory's sessions, which is made at the first start. Errors:
// UNAVAILABLE (cannot be made), DATA_LOSS (cannot be read, or is damaged).
absl::StatusOr<std::string> ReadResumeKey(const std::filesystem::path& path);

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
