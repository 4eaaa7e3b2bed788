// Functions that all calls to a daemon use: open a channel, set a deadline, translate statuses.
// Thread-safe.
#pragma once

#include <grpcpp/grpcpp.h>

#include <atomic>
#include <chrono>
#include <functional>
#include <memory>
#include <string>
#include <thread>

#include "engine_client/cli/daemon/daemon_options.h"
#include "engine_client/telemetry/common/validation.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

// Returns the names of the TLS options in error messages: the options of AddDaemonOptions.
TlsNames TlsOptionNames();

// Returns a channel to the daemon, which connects at its first call. Error kInvalidArgument: the
// address is not HOST:PORT, or the TLS files cannot be used. Plain-text channels to the same
// address share a connection unless `own_connection` is true.
Result<std::shared_ptr<grpc::Channel>> OpenChannel(const DaemonOptions& daemon,
                                                   bool own_connection = false);

// Deadline of a call whose answer is quick to compute.
inline constexpr std::chrono::seconds kPatience{10};
// Deadline of a call that transfers all evidence, or the audit log, over a slow network. If the
// transfer stalls, the daemon ends it earlier.
inline constexpr std::chrono::seconds kTransferPatience = std::chrono::minutes(10);

// Sets the deadline of a call. The call fails with kUnavailable after `patience`.
void SetDeadline(grpc::ClientContext& context, std::chrono::seconds patience = kPatience);

// Returns whether the channel was connected at its latest call, which has just failed. A lost
// connection makes the channel idle, a failed attempt to connect does not.
bool WasConnected(grpc::Channel& channel);

// Returns the daemon's status, or kUnavailable if the daemon could not be reached or, with
// `was_connected`, the call broke off. `look` is the command that shows whether the call's change
// was made; empty if the call changes nothing.
Status ToStatus(const grpc::Status& status, const DaemonOptions& daemon, bool was_connected = false,
                const std::string& look = {});

// Makes a call that has one response. `channel` is a result of OpenChannel; `look` is that of
// ToStatus. Errors: those of OpenChannel and ToStatus.
template <typename Stub, typename Request, typename Response>
Result<Response> Call(const DaemonOptions& daemon,
                      const Result<std::shared_ptr<grpc::Channel>>& channel, const Request& request,
                      grpc::Status (Stub::*method)(grpc::ClientContext*, const Request&, Response*),
                      std::chrono::seconds patience = kPatience, const std::string& look = {}) {
  if (!channel.ok()) return channel.status();
  Stub stub(*channel);
  grpc::ClientContext context;
  SetDeadline(context, patience);
  Response response;
  const grpc::Status ended = (stub.*method)(&context, request, &response);
  const Status status = ToStatus(ended, daemon, WasConnected(**channel), look);
  if (!status.ok()) return status;
  return response;
}

// Makes a call that has several responses, and calls `on_part` with each. Errors: those of
// OpenChannel and ToStatus.
template <typename Stub, typename Request, typename Part, typename OnPart>
Status ReadParts(const DaemonOptions& daemon, const Request& request,
                 std::unique_ptr<grpc::ClientReader<Part>> (Stub::*method)(grpc::ClientContext*,
                                                                           const Request&),
                 std::chrono::seconds patience, const OnPart& on_part) {
  const auto channel = OpenChannel(daemon);
  if (!channel.ok()) return channel.status();
  Stub stub(*channel);
  grpc::ClientContext context;
  SetDeadline(context, patience);
  const auto reader = (stub.*method)(&context, request);
  Part part;
  while (reader->Read(&part)) on_part(part);
  const grpc::Status ended = reader->Finish();
  return ToStatus(ended, daemon, WasConnected(**channel));
}

// Cancels a call as soon as `is_stopped` returns true. It polls `is_stopped` on its own thread,
// because reading from the stream blocks. It does not cancel a call that has already ended, because
// that would change the call's status to CANCELLED.
class Canceller {
 public:
  Canceller(grpc::ClientContext& context, const std::function<bool()>& is_stopped);
  ~Canceller();
  Canceller(const Canceller&) = delete;
  Canceller& operator=(const Canceller&) = delete;

 private:
  std::atomic<bool> ended_ = false;
  std::thread thread_;
};

// A function that reads a daemon's stream of events until the stream ends or `is_stopped` returns
// true.
using Watch = std::function<Status(const std::shared_ptr<grpc::Channel>& channel,
                                   const std::function<bool()>& is_stopped)>;

// Calls `watch` until `is_stopped` returns true. If the daemon was reached and the connection is
// then lost, calls `on_connection` with the error and watches again on a new connection, with
// back-off. When the new connection is ready, calls `on_connection` with OK, possibly on the thread
// that calls `is_stopped`. Returns an error if the daemon was never reached or refuses the call.
Status KeepWatching(const DaemonOptions& daemon, const std::function<bool()>& is_stopped,
                    const std::function<void(const Status&)>& on_connection, const Watch& watch);

// Works like KeepWatching above, but watches a call with a stream of responses and passes each
// response to `on_event`. Another thread calls `is_stopped` every 50 ms.
template <typename Stub, typename Request, typename Event>
Status KeepWatching(const DaemonOptions& daemon, const Request& request,
                    std::unique_ptr<grpc::ClientReader<Event>> (Stub::*method)(grpc::ClientContext*,
                                                                               const Request&),
                    const std::function<bool()>& is_stopped,
                    const std::function<void(const Event&)>& on_event,
                    const std::function<void(const Status&)>& on_connection) {
  return KeepWatching(
      daemon, is_stopped, on_connection,
      [&](const std::shared_ptr<grpc::Channel>& channel, const std::function<bool()>& ends) {
        Stub stub(channel);
        grpc::ClientContext context;
        const auto reader = (stub.*method)(&context, request);
        {
          const Canceller canceller(context, ends);
          Event event;
          while (reader->Read(&event)) on_event(event);
        }
        const grpc::Status status = reader->Finish();
        if (ends()) return Status();
        if (!status.ok()) return ToStatus(status, daemon, WasConnected(*channel));
        return Status(StatusCode::kUnavailable,
                      "the daemon at " + daemon.address + " ended the watch");
      });
}

}  // namespace sweepstake::cli
