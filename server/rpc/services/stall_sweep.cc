#include "server/rpc/services/stall_sweep.h"

#include <grpc/grpc.h>

#include <utility>

#include "server/rpc/common/error_reasons.h"

namespace sweepstake::rpc {

void Cancel(grpc::CallbackServerContext& call, const grpc::Status& status) {
  grpc_call_cancel_with_status(call.c_call(), static_cast<grpc_status_code>(status.error_code()),
                               status.error_message().c_str(), nullptr);
}

void StallSweep::Add(StallingCall& call) {
  calls_.insert(&call);
  Schedule();
}

void StallSweep::Schedule() {
  if (calls_.empty() || std::exchange(scheduled_, true)) return;
  loop_.PostAt(loop_.clock().NowNs() + patience_ns_ / 4, [this] { Sweep(); });
}

void StallSweep::Sweep() {
  scheduled_ = false;
  const int64_t now_ns = loop_.clock().NowNs();
  const int64_t overdue_ns = now_ns - patience_ns_;
  for (auto next = calls_.begin(); next != calls_.end();) {
    StallingCall& call = **next++;
    if (call.waiting_since_ns() <= overdue_ns || call.deadline_ns() <= now_ns) call.OnStalled();
  }
  Schedule();
}

absl::Status Transfer::BeginTransfer(v1::ErrorReason refusal) {
  OnProgress();
  deadline_ns_ = last_progress_ns_ + context_.options.transfer_patience_ns;
  context_.stalls.Add(*this);
  auto share = context_.access.BeginTransfer(caller_, refusal);
  if (share.ok()) share_ = *std::move(share);
  return share.status();
}

void Transfer::EndTransfer(const absl::Status& status) {
  context_.stalls.Remove(*this);  // before the call is finished, because gRPC then frees it
  context_.access.refusals().TellEnd(caller_.peer, status);
}

}  // namespace sweepstake::rpc
