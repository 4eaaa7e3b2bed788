#include "server/sessions/box_views.h"

#include <algorithm>
#include <utility>

#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/options.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/sessions/game_session.h"
#include "sweepstake/v1/sessions.pb.h"

namespace sweepstake::rpc {
namespace {

// The game's time has run half out.
constexpr int64_t kAskAgainNs = int64_t{BoxViews::kUntilMs} * 1'000'000 / 2;

}  // namespace

void BoxViews::Connect(ClientStream& link, bool shows) {
  link_ = &link;
  shows_ = shows;
  if (shows) return Ask();
  for (BoxViewer* viewer : std::exchange(viewers_, {}))
    viewer->OnEnd(Refused(v1::ERROR_REASON_BOXES_NOT_SHOWN, "the game shows its boxes no more"));
}

void BoxViews::Disconnect() {
  link_ = nullptr;
  ++*turn_;
}

void BoxViews::End() {
  Disconnect();
  for (BoxViewer* viewer : std::exchange(viewers_, {})) viewer->OnEnd(absl::OkStatus());
}

absl::Status BoxViews::Add(BoxViewer& viewer) {
  if (!shows_) {
    return Refused(v1::ERROR_REASON_BOXES_NOT_SHOWN,
                   "this game does not show its boxes; build it with allow_box_view");
  }
  if (viewers_.size() >= kMaxViewers) {
    return Refused(v1::ERROR_REASON_TOO_MANY_WATCHERS,
                   "as many as may look at this session's boxes do so already");
  }
  viewers_.push_back(&viewer);
  if (viewers_.size() == 1) Ask();
  return absl::OkStatus();
}

void BoxViews::Remove(BoxViewer& viewer) {
  if (std::erase(viewers_, &viewer) == 0 || !viewers_.empty()) return;
  if (link_ != nullptr) link_->SendBoxRequest(0, 0, 0);
  ++*turn_;
}

void BoxViews::OnView(const v1::BoxView& view) {
  if (viewers_.empty()) return;
  v1::WatchBoxesResponse response;
  *response.mutable_view() = view;
  ToProto(hub_.NextStamp(), *response.mutable_stamp());
  const grpc::ByteBuffer message = Serialize(response);
  // One that ends meanwhile leaves.
  const std::vector<BoxViewer*> told = viewers_;
  for (BoxViewer* viewer : told) viewer->OnView(message);
}

void BoxViews::Ask() {
  if (link_ == nullptr || viewers_.empty()) return;
  link_->SendBoxRequest(kIntervalMs, kMaxBoxViewBytes, kUntilMs);
  loop_.PostAt(loop_.clock().NowNs() + kAskAgainNs,
               [this, weak = std::weak_ptr(turn_), turn = ++*turn_] {
                 const auto present = weak.lock();  // as long as this lives
                 if (present && *present == turn) Ask();
               });
}

}  // namespace sweepstake::rpc
