// The history of games (history_file.h), written and read on a thread of its own.
//
// Thread-safe. A write or read waits for those before it. At most kMaxQueued of them wait, with at
// most kMaxQueuedReports reports of sessions and kMaxQueuedReads reads; further ones are refused.
// Points that cannot be written are lost. A damaged file is set aside, and the history begins
// again.
#pragma once

#include <atomic>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <mutex>
#include <string>

#include "absl/status/statusor.h"
#include "server/history/history_file.h"

namespace sweepstake::history {

class History {
 public:
  static constexpr size_t kMaxQueued = 1'000;
  static constexpr size_t kMaxQueuedReports = 50'000;  // about 2 kB each
  static constexpr size_t kMaxQueuedReads = 64;        // so that writes do not wait for long
  using OnPage = std::function<void(const absl::StatusOr<HistoryPage>&)>;
  // Called on any thread with a sentence for the log, at most once a minute.
  using OnProblem = std::function<void(const std::string&)>;

  // Opens the file; its content is checked later, on the history's thread. Error: UNAVAILABLE.
  static absl::StatusOr<std::unique_ptr<History>> Open(const std::filesystem::path& path,
                                                       const HistoryLimits& limits,
                                                       OnProblem on_problem);
  // Writes what is queued.
  ~History() { Close(); }
  History(const History&) = delete;
  History& operator=(const History&) = delete;

  void Write(HistoryBatch batch);
  // Calls `done` on the history's thread. Returns false if the queue is full or closed; then `done`
  // is not called.
  bool Read(HistoryQuery query, OnPage done);
  // Later writes use these limits.
  void Limit(const HistoryLimits& limits);
  // Writes what is queued, ends the queued reads with CANCELLED, and refuses further ones.
  // Idempotent.
  void Close();

 private:
  History(std::filesystem::path path, std::unique_ptr<HistoryFile> file,
          const HistoryLimits& limits, OnProblem on_problem);

  // Returns false if the queue is full or closed.
  bool Post(std::function<void()> job, size_t report_count = 0);
  void Report(const std::string& problem);
  // The next three run on the history's thread. Settle opens a new file if the status is NOT_FOUND
  // (the file was removed) or DATA_LOSS; a damaged file is set aside.
  absl::Status Add(const HistoryBatch& batch);
  void Settle(const absl::Status& status);
  // Opens the file again; `why` is for the log.
  void BeginAgain(const std::string& why);
  void EndRead();

  const std::filesystem::path path_;
  const OnProblem on_problem_;
  std::unique_ptr<HistoryFile> file_;  // used on the thread; null if it cannot be opened again
  std::mutex mutex_;
  HistoryLimits limits_;                               // guarded by mutex_
  std::chrono::steady_clock::time_point next_report_;  // guarded by mutex_
  size_t queued_count_ = 0;                            // guarded by mutex_
  size_t queued_report_count_ = 0;                     // guarded by mutex_
  size_t queued_read_count_ = 0;                       // guarded by mutex_
  std::atomic<bool> closed_{false};                    // written under mutex_
  boost::asio::thread_pool thread_{1};  // the last member, because its jobs use the others
};

}  // namespace sweepstake::history
