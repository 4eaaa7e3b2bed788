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

// Callbacks for events of the streams; called on any thread.
class LoadEvents {
 public:
  virtual ~LoadEvents() = default;
  // `latency_ns` is the time since the start of the connection.
  virtual void OnWelcome(int64_t latency_ns) = 0;
  // The daemon has written `message_count` more of the measured messages to disk. `lag_ns` is the
  // time since one of their batches was sent. It is absent if none of them was timed; at most one
  // batch in flight is timed.
  virtual void OnAcknowledged(uint64_t message_count, std::optional<int64_t> lag_ns) = 0;
  // `delay_ms` is the minimum time before the next connection, as requested by the daemon. `was_up`
  // is true if the stream had its welcome.
  virtual void OnEnd(LoadStream& stream, const grpc::Status& status, bool was_up,
                     uint32_t delay_ms) = 0;
  // A switch command was received and its outcome sent. `latency_ns` is the time since the bail-out
  // that it answers, if any.
  virtual void OnSwitch(std::optional<int64_t> latency_ns) = 0;
};

class LoadStream {
 public:
  // Maximum number of messages that wait for the connection; further batches are not sent.
  static constexpr size_t kMaxWaiting = 16;

  LoadStream(const std::shared_ptr<grpc::Channel>& channel, std::string project, std::string scene,
             LoadEvents& events);

  // Opens a connection. REQUIRES: there is none.
  void Connect();
  // Sends `frames` with the arm, epoch and indices of this stream, and a bail-out after them if
  // wanted. Returns false if there is no welcome yet or kMaxWaiting messages wait.
  bool SendBatch(const v1::FrameBatch& frames, bool with_bail_out);
  // Messages sent between these two calls are measured.
  void BeginMeasuring();
  void EndMeasuring();
  // Returns whether measured messages have no acknowledgement yet and the connection can still
  // deliver it.
  bool AwaitsAcknowledgement();
  // Ends the session. The connection ends when the daemon has written everything to disk.
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
  std::deque<v1::StreamTelemetryRequest> waiting_;  // the front message is being written
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
  uint64_t first_measured_ = 1;   // range of sequence numbers that are measured
  uint64_t last_measured_ = 0;    // 0: nothing
  int64_t begun_ns_ = 0;          // of the connection
  int64_t bail_out_sent_ns_ = 0;  // 0: none is unanswered
  uint64_t timed_sequence_ = 0;   // of the batch whose commit is timed
  int64_t timed_sent_ns_ = 0;     // 0: none is
  bool up_ = false;               // the welcome has come
  bool leaving_ = false;          // the goodbye was sent; no message may follow
};

}  // namespace sweepstake::cli
