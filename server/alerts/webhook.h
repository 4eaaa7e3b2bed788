// Sends messages to a URL by HTTP POST, in their order, on its own thread.
//
// A message that fails is sent again, with back-off, until it has been tried kMaxAttempts times.
// Later messages wait for it. The queue is bounded: if it is full, the oldest message is dropped.
// TLS certificates are verified, and redirects are not followed. Thread-safe.
#pragma once

#include <atomic>
#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <mutex>
#include <string>
#include <thread>

#include "server/sessions/common/decision_loop.h"

namespace sweepstake::alerts {

// Counts since the start, and messages that wait now.
struct WebhookCounters {
  std::atomic<uint64_t> delivered_count{0};
  std::atomic<uint64_t> failed_count{0};   // attempts
  std::atomic<uint64_t> dropped_count{0};  // messages that will not be sent
  std::atomic<uint64_t> queued_count{0};
};

class Webhook {
 public:
  static constexpr size_t kMaxQueued = 100;
  static constexpr uint32_t kMaxAttempts = 10;
  // The wait after a failure doubles from kFirstWaitNs to kMaxWaitNs. Ten attempts take 20 minutes.
  static constexpr int64_t kFirstWaitNs = 5'000'000'000;
  static constexpr int64_t kMaxWaitNs = 300'000'000'000;
  static constexpr int64_t kAttemptTimeoutMs = 10'000;
  static constexpr int64_t kReportIntervalNs = 60'000'000'000;

  struct Options {
    std::string user_agent;
    // Called with the reason of a failure, at most once per kReportIntervalNs, on the own thread.
    std::function<void(const std::string& problem)> on_problem = {};
  };

  // Only this object may wait on the clock, which must outlive it.
  Webhook(Options options, sessions::LoopClock& clock);
  // Drops the waiting messages. Takes up to a second if a message is being sent.
  ~Webhook();
  Webhook(const Webhook&) = delete;
  Webhook& operator=(const Webhook&) = delete;

  // Sets the URL (http or https); empty: messages are ignored, and the waiting ones are dropped.
  // The next attempt uses it.
  void SetUrl(const std::string& url);
  void Post(std::string message);
  const WebhookCounters& counters() const { return counters_; }

 private:
  void Run();
  // Sends the first message if it is due, and returns when the next attempt is due.
  int64_t Step();
  // Returns the reason of the failure; empty if the receiver answered with a status from 200 to
  // 299.
  std::string Send(const std::string& url, const std::string& message);
  void Settle(uint64_t number, const std::string& url, const std::string& problem);
  // Removes the first message. REQUIRES: mutex_ is locked, and there is one.
  void Remove();

  struct Message {
    uint64_t number = 0;
    std::string text;
    uint32_t attempt_count = 0;
  };

  const Options options_;
  sessions::LoopClock& clock_;
  WebhookCounters counters_;
  std::atomic<bool> closing_ = false;
  int64_t next_report_ns_ = 0;  // used on the own thread
  std::mutex mutex_;
  std::string url_;               // guarded by mutex_
  std::deque<Message> messages_;  // guarded by mutex_
  uint64_t last_number_ = 0;      // guarded by mutex_
  int64_t due_ns_ = 0;            // guarded by mutex_; earliest time of the next attempt
  std::thread thread_;            // last: it uses the members above
};

}  // namespace sweepstake::alerts
