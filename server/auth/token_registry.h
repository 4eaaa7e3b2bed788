// The tokens of a running daemon. They are kept in memory, and read again within a second after
// `sweepstaked token` has changed the file, or the file was replaced.
//
// If the file is missing, cannot be read, or has lost all its tokens, the tokens in memory stay
// valid, and on_problem is called once. Thread-safe. It owns one thread, the only one that uses the
// database. This thread also stores the times at which tokens were last used, at most once a
// minute.
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
  std::chrono::milliseconds interval{1'000};  // between two checks of the file
  std::chrono::milliseconds use_interval{60'000};
  std::function<int64_t()> unix_now_s;  // the wall clock; called on any thread
  // Called on the registry's thread: on_change with a text about each token that was made, revoked
  // or removed, on_problem with an error of the token file.
  std::function<void(const std::string&)> on_change;
  std::function<void(const absl::Status&)> on_problem;
};

class TokenRegistry final : public TokenDirectory {
 public:
  // Reads the file; creates it if it is missing. Errors: those of TokenStore::Open. A file that had
  // tokens and has none now is FAILED_PRECONDITION.
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
    // Indices in the list, by the first kTicketKeyDigits digits of the digest. The lookup need not
    // take constant time: an attacker who guesses tokens cannot choose their digests.
    std::unordered_multimap<std::string, size_t> by_digest;
  };

  TokenRegistry(std::filesystem::path path, TokenRegistryOptions options)
      : options_(std::move(options)), path_(std::move(path)) {}

  std::shared_ptr<const Entries> Current() const;
  // Opens the file and reads it.
  absl::Status OpenStore();
  absl::Status Read();
  // Reads the file if it was changed or replaced.
  absl::Status Follow();
  void Report(const Entries& before, const Entries& after) const;
  void Run();
  void LookAtFile();
  void StoreUses();

  const TokenRegistryOptions options_;
  const std::filesystem::path path_;
  // Open uses these members first. After that, only the thread uses them.
  std::optional<TokenStore> store_;
  int64_t version_ = 0;  // version of the data that was read
  bool readable_ = true;
  std::chrono::steady_clock::time_point next_use_store_{};

  mutable std::mutex mutex_;  // guards the members below
  std::shared_ptr<const Entries> entries_ = std::make_shared<Entries>();
  std::condition_variable ending_changed_;
  bool ending_ = false;
  std::thread thread_;  // last: it uses the members above
};

}  // namespace sweepstake::auth
