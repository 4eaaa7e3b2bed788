// Ends calls whose client makes no progress, with one timer for all calls. Used on the decision
// loop only.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <set>
#include <utility>

#include "server/rpc/services/service_context.h"

namespace sweepstake::rpc {

// Ends a call at once. If a write waits for a client that does not read, the write fails. The
// client receives the code and the message of the status, but not its details.
void Cancel(grpc::CallbackServerContext& call, const grpc::Status& status);

// A call that is ended when it stalls. It must be removed from the sweep before it is finished,
// because gRPC may free a finished call before the loop runs its OnDone.
class StallingCall {
 public:
  virtual ~StallingCall() = default;
  // The time of the last progress, or Clock::kNever while the daemon does not wait for the client.
  virtual int64_t waiting_since_ns() const = 0;
  // The time by which the call must be done, or Clock::kNever.
  virtual int64_t deadline_ns() const { return sessions::LoopClock::kNever; }
  // Called when the call has made no progress for the patience of StallSweep, or its deadline has
  // passed. The call may remove itself from the sweep.
  virtual void OnStalled() = 0;
};

class StallSweep {
 public:
  // `patience_ns` is the longest time without progress. Calls are checked four times in this time.
  // A call is therefore ended 1 to 1.25 times `patience_ns` after its last progress, or at most a
  // quarter of `patience_ns` after its deadline.
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

  // Counts the transfer, and begins to check its progress. Error: RESOURCE_EXHAUSTED with the
  // reason `refusal` (too many transfers are under way).
  absl::Status BeginTransfer(v1::ErrorReason refusal);
  void OnProgress() { last_progress_ns_ = context_.loop.clock().NowNs(); }
  // Called while the daemon waits for the store instead of the client.
  void WaitForStore() { last_progress_ns_ = deadline_ns_ = sessions::LoopClock::kNever; }
  // Stops checking the progress, and logs `status` if it is a refusal. Called before the call is
  // finished.
  void EndTransfer(const absl::Status& status);

  ServiceContext& context_;
  const Caller caller_;

 private:
  AccessControl::Share share_;
  int64_t last_progress_ns_ = 0;
  int64_t deadline_ns_ = sessions::LoopClock::kNever;
};

}  // namespace sweepstake::rpc
