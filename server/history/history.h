// The history of games (history_file.h), written and read on a thread of its own.
//
// Thread-safe. A write or read waits for those before it; at most kMaxQueued wait, and further ones
// are refused. A point that cannot be written is lost.
#pragma once

#include <atomic>
#include <boost/asio/thread_pool.hpp>
#include <chrono>
#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "absl/status/statusor.h"
#include "server/history/history_file.h"

namespace sweepstake::history {

class History {
 public:
  static constexpr size_t kMaxQueued = 1'000;
  using OnPage = std::function<void(const absl::StatusOr<HistoryPage>&)>;
  // Called on the history's thread with a sentence for the log, at most once a minute.
  using OnProblem = std::function<void(const std::string&)>;

  // Error: UNAVAILABLE (the file cannot be opened).
  static absl::StatusOr<std::unique_ptr<History>> Open(const std::filesystem::path& path,
                                                       const HistoryLimits& limits,
                                                       OnProblem on_problem);
  // Writes what is queued.
  ~History() { Close(); }
  History(const History&) = delete;
  History& operator=(const History&) = delete;

  void Write(std::vector<HistoryEntry> entries);
  // Calls `done` on the history's thread. Returns false if the queue is full or closed; then `done`
  // is not called.
  bool Read(HistoryQuery query, OnPage done);
  // Later writes use these limits.
  void Limit(const HistoryLimits& limits);
  // Writes what is queued, and refuses further writes and reads. Idempotent.
  void Close();

 private:
  History(std::unique_ptr<HistoryFile> file, const HistoryLimits& limits, OnProblem on_problem)
      : file_(std::move(file)), on_problem_(std::move(on_problem)), limits_(limits) {}

  bool Post(std::function<void()> job);
  // Runs on the history's thread.
  void Report(const std::string& problem);

  const std::unique_ptr<HistoryFile> file_;  // used on the thread
  const OnProblem on_problem_;
  HistoryLimits limits_;                               // used on the thread
  std::chrono::steady_clock::time_point next_report_;  // used on the thread
  std::atomic<size_t> queued_count_{0};
  std::atomic<bool> closed_{false};
  boost::asio::thread_pool thread_{1};  // the last member, because its jobs use the others
};

}  // namespace sweepstake::history
