// One client of a load run: a session with made-up frames, on gRPC's callback API, so that
// thousands need no thread of their own.
//
// Thread-safe: the run's timer thread sends, gRPC's threads receive. It keeps no unacknowledged
// message, since a load measures the daemon and not the evidence. After a lost connection it
// resumes its session.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <deque>
#include <memory>
#include <mutex>
#include <optional>
#include <string>

#include "sweepstake/v1/telemetry.grpc.pb.h"

namespace sweepstake::cli {

inline constexpr uint32_t kLoadArms = 7;

// The steady clock of a run.
int64_t NowNs();

class LoadStream;

// Receives what happens to the streams, on any thread.
class LoadEvents {
 public:
  virtual ~LoadEvents() = default;
  // `latency_ns` is the time since the connection was begun.
  virtual void OnWelcome(int64_t latency_ns) = 0;
  // So many more of the messages that were sent while measuring are on the daemon's disk. `lag_ns`
  // is the time since one of their batches was sent: at most one in flight is timed.
  virtual void OnAcknowledged(uint64_t message_count, std::optional<int64_t> lag_ns) = 0;
  // `delay_ms` is the min time before the next connection that the daemon asked for. `was_up` says
  // that the stream had its welcome.
  virtual void OnEnd(LoadStream& stream, const grpc::Status& status, bool was_up,
                     uint32_t delay_ms) = 0;
  // A switch command came; its outcome is sent. `latency_ns` is the time since the bail-out that it
  // answers, if any.
  virtual void OnSwitch(std::optional<int64_t> latency_ns) = 0;
};

class LoadStream {
 public:
  // Messages that may wait for the connection; a batch beyond is not sent.
  static constexpr size_t kMaxWaiting = 16;

  LoadStream(const std::shared_ptr<grpc::Channel>& channel, std::string project, std::string scene,
             LoadEvents& events);

  // Opens a connection. REQUIRES: there is none.
  void Connect();
  // Sends `frames` with the arm, epoch and indices of this stream, and a bail-out after them if
  // wanted. Returns false if there is no welcome yet or too much waits.
  bool SendBatch(const v1::FrameBatch& frames, bool with_bail_out);
  // What is sent between these two is measured.
  void BeginMeasuring();
  void EndMeasuring();
  // Returns whether measured messages wait for their acknowledgement, and it may come.
  bool AwaitsAcknowledgement();
  // Ends the session; the connection ends when all is on disk.
  void SayGoodbye();
  // Ends the connection at once.
  void Cancel();

 private:
  class Call;

  v1::StreamTelemetryRequest HelloRequest() const;
  // These are called with mutex_ held.
  void Send(v1::StreamTelemetryRequest request);
  void WriteNext();
  void OnResponse(const v1::StreamTelemetryResponse& response);
  void OnWelcome(const v1::Welcome& welcome);
  void OnAcknowledgement(uint64_t sequence);
  void OnSwitch(const v1::SwitchCommand& command);
  void SendBailOut();
  uint64_t NextSequence();
  bool IsMeasured(uint64_t sequence) const;

  const std::unique_ptr<v1::TelemetryService::Stub> stub_;
  const std::string project_;
  const std::string scene_;
  LoadEvents& events_;

  std::mutex mutex_;  // guards all below
  Call* call_ = nullptr;
  std::deque<v1::StreamTelemetryRequest> waiting_;  // the first one is being written
  std::string session_id_;
  std::string resume_token_;
  uint64_t acknowledged_sequence_ = 0;
  uint64_t sequence_ = 0;
  uint64_t frame_index_ = 0;
  uint64_t bail_out_ns_ = 0;  // the daemon's limit
  uint32_t arm_ = 0;
  uint32_t switch_epoch_ = 0;
  uint32_t reconnect_delay_ms_ = 0;
  bool measuring_ = false;
  uint64_t first_measured_ = 1;   // the sequences of what is measured
  uint64_t last_measured_ = 0;    // 0: nothing
  int64_t begun_ns_ = 0;          // of the connection
  int64_t bail_out_sent_ns_ = 0;  // 0: none is unanswered
  uint64_t timed_sequence_ = 0;   // of the batch whose commit is timed
  int64_t timed_sent_ns_ = 0;     // 0: none is
  bool up_ = false;               // the welcome has come
  bool leaving_ = false;          // goodbye was said: nothing follows it
};

}  // namespace sweepstake::cli
