// Ends calls whose client makes no progress, with one timer for all calls. Used on the decision
// loop only.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <set>

#include "server/sessions/common/decision_loop.h"

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

}  // namespace sweepstake::rpc
