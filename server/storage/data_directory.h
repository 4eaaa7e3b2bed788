// The daemon's data directory. A lock on the directory itself admits only one process at a time.
//
// The object owns the lock until it is destroyed. If the process is killed, the system releases the
// lock. Movable.
#pragma once

#include <filesystem>

#include "absl/status/statusor.h"

namespace sweepstake::storage {

class DataDirectory {
 public:
  static constexpr const char* kDatabaseName = "priors.db";
  static constexpr const char* kTokensName = "tokens.db";
  static constexpr const char* kTokensMadeName = "tokens-made";
  static constexpr const char* kResumeKeyName = "resume-key";
  static constexpr const char* kOutboxName = "outbox.db";
  static constexpr const char* kHistoryName = "history.db";
  static constexpr const char* kSilencesName = "silences.json";

  // Creates the directory if it is missing, but not its parents. A new directory is accessible to
  // its owner only. An existing directory keeps its permissions, but other users lose access to its
  // files. Errors: UNAVAILABLE (cannot create or write it, or another daemon holds it).
  static absl::StatusOr<DataDirectory> Open(const std::filesystem::path& path);
  ~DataDirectory();
  DataDirectory(DataDirectory&& other) noexcept;
  DataDirectory& operator=(DataDirectory&&) = delete;

  // Returns whether users other than the owner have access to the directory or one of its files.
  bool open_to_others() const { return open_to_others_; }
  std::filesystem::path database() const { return path_ / kDatabaseName; }
  std::filesystem::path resume_key() const { return path_ / kResumeKeyName; }
  std::filesystem::path outbox() const { return path_ / kOutboxName; }
  std::filesystem::path history() const { return path_ / kHistoryName; }
  std::filesystem::path silences() const { return path_ / kSilencesName; }
  std::filesystem::path tokens() const { return path_ / kTokensName; }

 private:
  DataDirectory(std::filesystem::path path, int lock) : path_(std::move(path)), lock_(lock) {}

  std::filesystem::path path_;
  bool open_to_others_ = false;
  int lock_;  // descriptor of the directory, which is locked; -1 after a move
};

}  // namespace sweepstake::storage
