#include "server/rpc/services/watcher.h"

#include "server/net/peer_address.h"

namespace sweepstake::rpc {

void Watcher::Begin(priors::SceneFilter wanted) {
  filter_ = std::move(wanted);
  absl::Status allowed = Narrow(caller_, filter_);
  if (allowed.ok()) allowed = Join();
  if (allowed.ok()) allowed = TakeShare();
  if (!allowed.ok()) return Close(allowed);
  context_.stalls.Add(*this);
  WriteNext();
}

absl::Status Watcher::TakeShare() {
  auto share = context_.access.BeginWatch(caller_, net::AddressOf(CallerOf(call_)));
  if (share.ok()) share_ = *std::move(share);
  return share.status();
}

void Watcher::EndIfRefused() {
  if (const absl::Status still = context_.access.CheckStill(caller_); !still.ok()) Close(still);
}

void Watcher::OnStalled() {
  Close(Refused(v1::ERROR_REASON_WATCHER_STALLED, "the watcher did not read; watch again"));
}

void Watcher::WriteNext() {
  if (writing_ || finished_) return;
  if (end_) {
    finished_ = true;
    return Finish(ToGrpc(*end_, context_.counters));
  }
  std::optional<grpc::ByteBuffer> next = TakeNext();
  if (!next) return;
  write_bytes_ = *std::move(next);
  writing_ = true;
  write_start_ns_ = context_.loop.clock().NowNs();
  StartWrite(&write_bytes_);
}

void Watcher::OnWritten(bool ok) {
  writing_ = false;
  if (!ok && !end_) end_ = absl::CancelledError("the connection was lost");
  WriteNext();
}

void Watcher::Close(const absl::Status& status) {
  if (end_) return;
  end_ = status;
  context_.access.refusals().TellEnd(CallerOf(call_), status);
  Forget();
  Leave();
  share_.reset();
  context_.stalls.Remove(*this);
  if (writing_) {
    Cancel(call_, ToGrpc(status, context_.counters));  // OnWritten continues from there
    end_ = absl::CancelledError("the call was cut off");
  }
  WriteNext();
}

void Watcher::OnWriteDone(bool ok) {
  context_.loop.Post([this, ok] { OnWritten(ok); });
}

void Watcher::OnCancel() {
  context_.loop.Post([this] { Close(absl::CancelledError("the connection was lost")); });
}

void Watcher::OnDone() {
  // All tasks posted before this one have run by then.
  context_.loop.Post([this] {
    Leave();
    context_.stalls.Remove(*this);
    self_.reset();
  });
}

}  // namespace sweepstake::rpc
