// Ends calls whose client does not go on: one timer for all of them. Used on the decision loop
// only.
#pragma once

#include <grpcpp/grpcpp.h>

#include <cstdint>
#include <set>

#include "server/sessions/common/decision_loop.h"

namespace sweepstake::rpc {

// Ends a call at once, also one whose pending write waits for a client that does not read: its
// pending operation then fails. The client gets the code and the message, but no details.
void Cancel(grpc::CallbackServerContext& call, const grpc::Status& status);

// A call that may stall. It leaves the sweep before it is finished, since gRPC may have freed it by
// the time that the loop hears of the end.
class StallingCall {
 public:
  virtual ~StallingCall() = default;
  // The time of the last progress, or Clock::kNever while the client need not do anything.
  virtual int64_t waiting_since_ns() const = 0;
  // The time by which the call must be done, or Clock::kNever.
  virtual int64_t deadline_ns() const { return sessions::Clock::kNever; }
  // Called once the patience is over, or the deadline has passed. The call may remove itself.
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
