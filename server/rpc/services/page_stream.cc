#include "server/rpc/services/page_stream.h"

namespace sweepstake::rpc {

void PageStream::Begin() {
  const absl::Status begun = BeginTransfer(v1::ERROR_REASON_TOO_MANY_READS);
  begun.ok() ? LoadNext() : End(begun);
}

void PageStream::LoadNext() {
  const bool submitted = context_.store.Read(
      [weak = weak_from_this(), &loop = context_.loop, load = load_](priors::PriorReader& store) {
        if (weak.expired()) return;  // the stream ended before this read began
        loop.Post([weak, page = (*load)(store)]() mutable {
          if (!page.ok()) page = StoreFailed(page.status());
          if (const auto self = weak.lock()) self->OnPage(std::move(page));
        });
      });
  if (!submitted) OnPage(StoreBusy());
}

void PageStream::OnPage(absl::StatusOr<StreamPage> page) {
  ahead_ = std::move(page);
  if (!writes_ && !ended_) WriteNext();
}

void PageStream::WriteNext() {
  if (const absl::Status still = context_.access.CheckStill(caller_); !still.ok())
    return End(still);
  auto next = *std::exchange(ahead_, std::nullopt);
  if (!next.ok()) return End(next.status());
  page_ = *std::move(next);
  if (page_.response == nullptr) return End(absl::OkStatus());
  writes_ = true;
  sink_.Write(page_.response);
  if (!page_.last) LoadNext();
}

void PageStream::OnWritten(bool ok) {
  OnProgress();
  writes_ = false;
  if (!ok) return End(absl::CancelledError("the connection was lost"));
  if (page_.last) return End(absl::OkStatus());
  if (ahead_) WriteNext();
}

void PageStream::OnStalled() {
  const absl::Status stalled =
      Refused(v1::ERROR_REASON_CALL_STALLED,
              "the client did not read the whole answer in time; request less at once");
  EndTransfer(stalled);
  sink_.Cancel(stalled);
}

void PageStream::End(const absl::Status& status) {
  ended_ = true;
  EndTransfer(status);
  sink_.Finish(status);
}

}  // namespace sweepstake::rpc
