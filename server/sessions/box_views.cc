#include "server/sessions/box_views.h"

#include <algorithm>
#include <utility>

#include "server/sessions/common/options.h"
#include "server/sessions/common/reasons.h"
#include "server/sessions/game_session.h"

namespace sweepstake::sessions {
namespace {

// Interval at which the box request is renewed: half of the time for which a request is valid.
constexpr int64_t kAskAgainNs = int64_t{BoxViews::kUntilMs} * 1'000'000 / 2;

}  // namespace

void BoxViews::Connect(ClientStream& link, bool shows) {
  link_ = &link;
  shows_ = shows;
  if (shows) return Ask();
  for (BoxViewListener* viewer : std::exchange(viewers_, {}))
    viewer->OnEnd(Refused(reasons::kBoxesNotShown, "the game no longer sends its boxes"));
}

void BoxViews::Disconnect() {
  link_ = nullptr;
  ++*turn_;
}

void BoxViews::End() {
  Disconnect();
  for (BoxViewListener* viewer : std::exchange(viewers_, {})) viewer->OnEnd(absl::OkStatus());
}

absl::Status BoxViews::Add(BoxViewListener& viewer) {
  if (!shows_) {
    return Refused(reasons::kBoxesNotShown,
                   "this game does not send its boxes; set allow_box_view in the game");
  }
  if (viewers_.size() >= kMaxViewers) {
    return Refused(reasons::kTooManyWatchers,
                   "this session's boxes have the maximum number of viewers; try again later");
  }
  viewers_.push_back(&viewer);
  if (viewers_.size() == 1) Ask();
  return absl::OkStatus();
}

void BoxViews::Remove(BoxViewListener& viewer) {
  if (std::erase(viewers_, &viewer) == 0 || !viewers_.empty()) return;
  if (link_ != nullptr) link_->SendBoxRequest(0, 0, 0);
  ++*turn_;
}

void BoxViews::OnView(const std::string& view) {
  // Iterate over a copy, because OnView can end a viewer, which removes it from viewers_.
  const std::vector<BoxViewListener*> viewers = viewers_;
  for (BoxViewListener* viewer : viewers) viewer->OnView(view);
}

void BoxViews::Ask() {
  if (link_ == nullptr || viewers_.empty()) return;
  link_->SendBoxRequest(kIntervalMs, kMaxBoxViewBytes, kUntilMs);
  loop_.PostAt(loop_.clock().NowNs() + kAskAgainNs,
               [this, weak = std::weak_ptr(turn_), turn = ++*turn_] {
                 const auto present = weak.lock();  // null after *this is destroyed
                 if (present && *present == turn) Ask();
               });
}

}  // namespace sweepstake::sessions
