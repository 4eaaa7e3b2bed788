// The small files of a daemon: the secret key that signs the resume tokens of its sessions, the
// silences of alerts, and the file with its ports. Not thread-safe.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"

namespace sweepstake::server {

// Returns the secret key that signs resume tokens. Creates the file with a random key if it is
// missing. Errors: UNAVAILABLE (cannot be created), DATA_LOSS (cannot be read, or is damaged).
absl::StatusOr<std::string> ReadResumeKey(const std::filesystem::path& path);

// Returns the text of a small file; empty if the file is missing or cannot be read.
std::string ReadText(const std::filesystem::path& path);
// Replaces a private file by one with this text. After a power failure the file has the old or the
// new text. Error: UNAVAILABLE.
absl::Status ReplaceText(const std::filesystem::path& path, const std::string& text);

// The file of Config::port_file. If its path is empty, Remove and Write do nothing. Errors:
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
