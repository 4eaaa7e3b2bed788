#include "server/history/history_recorder.h"

#include <utility>

namespace sweepstake::history {

void HistoryRecorder::Add(const sessions::SessionIdentity& session,
                          const sessions::SessionUse& use) {
  const v1::HistoryPoint point = PointOf(session, use);
  AddTo({.kind = v1::HISTORY_KIND_SCENE, .scene = session.scene}, point);
  AddTo({.kind = v1::HISTORY_KIND_BUILD, .scene = session.scene, .build = session.origin.build},
        point);
  AddTo({.kind = v1::HISTORY_KIND_SESSION,
         .scene = session.scene,
         .build = session.origin.build,
         .session = session.id},
        point);
  if (std::exchange(is_scheduled_, true)) return;
  loop_.PostAt(loop_.clock().NowNs() + kDelayNs, [this] { Begin(); });
}

void HistoryRecorder::AddTo(SeriesKey key, const v1::HistoryPoint& point) {
  if (pending_.size() >= kMaxPending && !pending_.contains(key)) return;
  history::Add(point, pending_[std::move(key)]);
}

void HistoryRecorder::Begin() {
  if (!leaving_.empty()) {  // the previous points are not passed on yet
    loop_.PostAt(loop_.clock().NowNs() + kDelayNs, [this] { Begin(); });
    return;
  }
  is_scheduled_ = false;
  leaving_ = std::exchange(pending_, {});
  Continue({});
}

void HistoryRecorder::Continue(const SeriesKey& after) {
  size_t count = 0;
  auto next = leaving_.lower_bound(after);
  for (; next != leaving_.end() && next->first.kind == v1::HISTORY_KIND_SCENE; ++next) {
    if (++count > kScenesPerTask)
      return loop_.PostLater([this, key = next->first] { Continue(key); });
    const sessions::SceneActivity activity = sessions_.ActivityOf(next->first.scene);
    if (activity.run.session_count > 0)
      *next->second.mutable_activity() = outputs_.encode(activity);
  }
  std::vector<HistoryEntry> entries(std::make_move_iterator(leaving_.begin()),
                                    std::make_move_iterator(leaving_.end()));
  leaving_.clear();
  if (!entries.empty()) outputs_.write(std::move(entries));
}

void HistoryRecorder::Finish() {
  for (auto& [key, point] : std::exchange(pending_, {})) history::Add(point, leaving_[key]);
  std::vector<HistoryEntry> entries(leaving_.begin(), leaving_.end());
  leaving_.clear();
  if (!entries.empty()) outputs_.write(std::move(entries));
}

}  // namespace sweepstake::history
