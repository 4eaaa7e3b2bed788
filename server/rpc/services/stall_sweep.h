// Ends calls whose client makes no progress, with one timer for all calls. Used on the decision
// loop only.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <set>
#include <utility>

#include "server/rpc/services/service_context.h"

namespace sweepstake::rpc {

// Ends a call at once. A pending write to a client that does not read fails then. The client
// receives the code and the message, but no details.
void Cancel(grpc::CallbackServerContext& call, const grpc::Status& status);

// A call that may stall. It must leave the sweep before it is finished, because gRPC may free it
// before the loop learns of the end.
class StallingCall {
 public:
  virtual ~StallingCall() = default;
  // The time of the last progress, or Clock::kNever while the daemon does not wait for the client.
  virtual int64_t waiting_since_ns() const = 0;
  // The time by which the call must be done, or Clock::kNever.
  virtual int64_t deadline_ns() const { return sessions::Clock::kNever; }
  // Called when the patience is over, or the deadline has passed. The call may remove itself.
  virtual void OnStalled() = 0;
};

class StallSweep {
 public:
  // A call is ended between one and 1.25 times the patience after its last progress, and at most a
  // quarter of it after its deadline.
  StallSweep(sessions::DecisionLoop& loop, int64_t patience_ns)
      : loop_(loop), patience_ns_(patience_ns) {}

  void Add(StallingCall& call);
  void Remove(StallingCall& call) { calls_.erase(&call); }

 private:
  void Schedule();
  void Sweep();

  sessions::DecisionLoop& loop_;
  const int64_t patience_ns_;
  std::set<StallingCall*> calls_;
  bool scheduled_ = false;
};

// An export or import under way. It ends with DEADLINE_EXCEEDED if it makes no progress for
// RpcOptions::watcher_patience_ns, or is not done within transfer_patience_ns. AccessControl limits
// the number of transfers.
class Transfer : public StallingCall {
 public:
  int64_t waiting_since_ns() const override { return last_progress_ns_; }
  int64_t deadline_ns() const override { return deadline_ns_; }

 protected:
  Transfer(ServiceContext& context, Caller caller)
      : context_(context), caller_(std::move(caller)) {}

  // Counts the transfer, and begins to watch its progress. Error: RESOURCE_EXHAUSTED with the
  // reason `refusal`.
  absl::Status BeginTransfer(v1::ErrorReason refusal);
  void OnProgress() { last_progress_ns_ = context_.loop.clock().NowNs(); }
  // Called while the daemon waits for the store instead of the client.
  void WaitForStore() { last_progress_ns_ = deadline_ns_ = sessions::Clock::kNever; }
  // Called before the call is finished. Logs refusals.
  void EndTransfer(const absl::Status& status);

  ServiceContext& context_;
  const Caller caller_;

 private:
  AccessControl::Share share_;
  int64_t last_progress_ns_ = 0;
  int64_t deadline_ns_ = sessions::Clock::kNever;
};

}  // namespace sweepstake::rpc
