// A daemon for tests: it implements sweepstake.v1 on its own port, records what it receives, and
// answers as the test sets.
//
// Thread safety: call all methods from the test's thread; the stream's thread only reads the script
// and records.
#pragma once

#include <grpcpp/grpcpp.h>

#include <condition_variable>
#include <functional>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "sweepstake/v1/telemetry.grpc.pb.h"

namespace sweepstake::test_support {

class FakeDaemon final : public v1::TelemetryService::Service {
 public:
  // Determines how the daemon answers connections. The test may change it at any time.
  struct Script {
    // Ends the stream with this status instead of a welcome.
    std::optional<grpc::Status> refusal;
    // Ends the stream with this status after the first message with evidence.
    std::optional<grpc::Status> refusal_of_evidence;
    // The status that answers a goodbye.
    grpc::Status farewell;
    bool never_reads = false;   // sends the welcome, then reads nothing
    bool acknowledges = true;   // acknowledges each message with evidence at once
    bool answers_hello = true;  // whether a Hello gets a Welcome
    v1::Welcome welcome;        // session_id, resumed and acknowledged_sequence are filled in
  };

  FakeDaemon();
  ~FakeDaemon() override;

  // Port 0 selects a free port; a former port restarts the daemon at the same address.
  void Start(int port = 0);
  // Aborts all streams, like kill -9. Sessions are kept, as if they were on a disk.
  void Kill();

  std::string address() const { return "127.0.0.1:" + std::to_string(port_); }
  int port() const { return port_; }

  void SetScript(const std::function<void(Script&)>& change);
  // Discards all sessions: resuming one fails with NOT_FOUND.
  void ForgetSessions();
  // Writes to the open connection; returns false if there is none.
  bool Send(const v1::StreamTelemetryResponse& response);

  // Waits until `condition` holds. A wait that never succeeds ends with the test's time limit.
  void WaitUntil(const std::function<bool(const FakeDaemon&)>& condition);

  // Everything received so far, in order, over all connections. Read it only inside WaitUntil's
  // condition or after Stop.
  std::vector<v1::Hello> hellos;
  std::vector<v1::StreamTelemetryRequest> evidence;  // all messages, including resent messages
  std::vector<v1::Goodbye> goodbyes;
  int open_stream_count = 0;

  // Returns a copy of the evidence: each sequence number of the latest session once, in order.
  std::vector<v1::StreamTelemetryRequest> Evidence();

 private:
  using Stream = grpc::ServerReaderWriter<v1::StreamTelemetryResponse, v1::StreamTelemetryRequest>;

  grpc::Status StreamTelemetry(grpc::ServerContext* context, Stream* stream) override;
  grpc::Status Converse(Stream* stream);
  grpc::Status Greet(const v1::Hello& hello, Stream* stream);
  std::optional<grpc::Status> Receive(const v1::StreamTelemetryRequest& request, Stream* stream);

  int port_ = 0;
  std::unique_ptr<grpc::Server> server_;

  std::mutex mutex_;  // guards the members below and the records above
  std::condition_variable changed_;
  Script script_;
  Stream* open_stream_ = nullptr;
  std::vector<grpc::ServerContext*> contexts_;
  bool killed_ = false;
  int session_count_ = 0;
  std::string session_id_;  // the current session; empty if there is none
  uint64_t acknowledged_sequence_ = 0;
};

}  // namespace sweepstake::test_support
