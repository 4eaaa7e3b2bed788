// The tokens of a running daemon: kept in memory, and read again within a second after
// `sweepstaked token` has changed them, or another file was put in the place of theirs.
//
// While the file is missing, cannot be read, or has none of the tokens that there have been, they
// stay as they were, and on_problem says so once. Thread-safe. It owns one thread,
// which alone uses the database: it also stores when tokens were last used, at most once a minute.
#pragma once

#include <atomic>
#include <chrono>
#include <condition_variable>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <thread>
#include <unordered_map>
#include <vector>

#include "absl/status/statusor.h"
#include "server/auth/principal.h"
#include "server/auth/token_store.h"

namespace sweepstake::auth {

struct TokenRegistryOptions {
  std::chrono::milliseconds interval{1'000};  // between two looks at the file
  std::chrono::milliseconds use_interval{60'000};
  std::function<int64_t()> unix_now_s;  // the wall clock, from any thread
  // Told what has been done to a token, and what is wrong with the file; on the registry's thread.
  std::function<void(const std::string&)> on_change;
  std::function<void(const absl::Status&)> on_problem;
};

class TokenRegistry final : public TokenDirectory {
 public:
  // Reads the file, and makes it if it is missing. Errors: those of TokenStore::Open; a file
  // without a token, where there have been some, is FAILED_PRECONDITION as a missing one is.
  static absl::StatusOr<std::unique_ptr<TokenRegistry>> Open(const std::filesystem::path& path,
                                                             TokenRegistryOptions options);
  ~TokenRegistry() override;

  bool empty() const override { return Current()->list.empty(); }
  std::optional<Principal> Find(std::string_view token) const override;
  bool IsValid(const Principal& holder) const override;

 private:
  struct Entry {
    StoredToken token;
    std::shared_ptr<std::atomic<int64_t>> last_used_unix_s;
  };
  struct Entries {
    std::vector<Entry> list;  // ordered by id
    // Places in the list, by the first digits of the digest. These may be looked up in any time:
    // who guesses a token cannot choose its digest.
    std::unordered_multimap<std::string, size_t> by_digest;
  };

  TokenRegistry(std::filesystem::path path, TokenRegistryOptions options)
      : options_(std::move(options)), path_(std::move(path)) {}

  std::shared_ptr<const Entries> Current() const;
  // Opens the file and reads it.
  absl::Status OpenStore();
  absl::Status Read();
  // Reads the file if it was changed, or is another one.
  absl::Status Follow();
  void Report(const Entries& before, const Entries& after) const;
  void Run();
  void LookAtFile();
  void StoreUses();

  const TokenRegistryOptions options_;
  const std::filesystem::path path_;
  // These are used by Open, then by the thread.
  std::optional<TokenStore> store_;
  int64_t version_ = 0;  // of what was read
  bool readable_ = true;
  std::chrono::steady_clock::time_point next_use_store_{};

  mutable std::mutex mutex_;  // guards what follows
  std::shared_ptr<const Entries> entries_ = std::make_shared<Entries>();
  std::condition_variable ending_changed_;
  bool ending_ = false;
  std::thread thread_;  // last: it uses the members above
};

}  // namespace sweepstake::auth
