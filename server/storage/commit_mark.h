// The number of commits that a database had when it was last looked at, in a file beside it. A
// database that has fewer later has lost commits, for instance because its write-ahead log was
// removed after a crash. SQLite cannot detect that.
//
// The file is not synced. After a power failure it may have an earlier number, and then fewer lost
// commits are detected.
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <utility>

namespace sweepstake::storage {

// Used by one thread.
class CommitMark {
 public:
  explicit CommitMark(const std::filesystem::path& database)
      : file_(database.parent_path() / "store-commits") {}

  // Returns the number in the file; 0 if it cannot be read.
  uint64_t Read() const;
  // Writes the number unless it was written last. Ignores errors: the next call tries again.
  void Write(uint64_t count);

 private:
  const std::filesystem::path file_;
  std::optional<uint64_t> written_;
};

}  // namespace sweepstake::storage
