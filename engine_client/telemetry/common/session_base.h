// The common base class of the session with a daemon and the embedded session. It has the queue
// that the frame thread fills, the sender thread that empties it, start and stop, and the
// statistics.
//
// Thread safety: the sink is used on the frame thread, Prepare on the thread that calls Start, Step
// on the sender thread. Start, Stop and stats may be called on any thread.
#pragma once

#include <atomic>
#include <chrono>
#include <limits>
#include <memory>
#include <mutex>

#include "engine_client/adaptive/session_attachment.h"
#include "engine_client/broad_phase/host/polling_thread.h"
#include "engine_client/broad_phase/host/thread_owned.h"
#include "engine_client/telemetry/common/flight_recorder.h"
#include "engine_client/telemetry/common/sample_queue.h"
#include "sweepstake/session.h"

namespace sweepstake {

class SessionBase : public Session {
 public:
  FrameSink& sink() final { return *queue_; }
  Status Start(AdaptiveBroadPhase& adaptive) final;
  void Stop(uint32_t deadline_ms) final;
  SessionStats stats() const final;
  Result<std::string> ExportPriors() const override;

 protected:
  // The destructor of a derived class must call Stop, because the sender thread uses members of the
  // derived class.
  explicit SessionBase(const SessionOptions& options);

  // Makes the objects that Step needs. Start calls it before it creates the sender thread. If it
  // returns an error, Start fails and may be called again.
  virtual Status Prepare(AdaptiveBroadPhase& adaptive) = 0;
  // Runs one step on the sender thread. `stopping` is true after Stop was called. Returns false to
  // end the thread.
  virtual bool Step(bool stopping) = 0;
  virtual std::chrono::milliseconds poll_interval() const = 0;

  // Only for the sender thread, and valid from Prepare until the end of Stop.
  AdaptiveBroadPhase& adaptive() const { return *adaptive_.load(std::memory_order_relaxed); }
  uint64_t stop_deadline_ns() const { return stop_deadline_ns_.load(); }

  // Calls `change` with the statistics while their lock is held.
  template <typename Change>
  void UpdateStats(const Change& change) {
    const std::lock_guard lock(stats_mutex_);
    change(*stats_);
  }
  void Wake() { thread_.Wake(); }
  SampleQueue& queue() { return *queue_; }

 private:
  Status StartThread();
  void LimitStop(uint32_t deadline_ms);
  void EndThread(uint32_t deadline_ms);
  void Close();

  // The AdaptiveBroadPhase shares the queue, and with it the recorder's ring, because it may use
  // both after the session's end.
  const std::shared_ptr<FlightRecorder> flight_;  // null: off
  const std::shared_ptr<SampleQueue> queue_;
  const std::shared_ptr<SessionAttachment> attachment_ = std::make_shared<SessionAttachment>();
  std::atomic<AdaptiveBroadPhase*> adaptive_{nullptr};
  std::atomic<uint64_t> stop_deadline_ns_{std::numeric_limits<uint64_t>::max()};

  mutable std::mutex stats_mutex_;  // guards *stats_
  const ThreadOwned<SessionStats> stats_ = MakeThreadOwned<SessionStats>();
  PollingThread thread_{"swp session"};
};

}  // namespace sweepstake
