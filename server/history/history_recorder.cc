#include "server/history/history_recorder.h"

#include <iterator>

namespace sweepstake::history {

void HistoryRecorder::Add(const sessions::SessionIdentity& session, sessions::SessionUse use) {
  if (waiting_.reports.size() >= kMaxReports) return;
  waiting_.reports.push_back({.scene = session.scene,
                              .build = session.origin.build,
                              .session = session.id,
                              .arms = session.arms,
                              .use = std::move(use)});
  if (std::exchange(is_scheduled_, true)) return;
  loop_.PostAt(loop_.clock().NowNs() + kDelayNs, [this] { Begin(); });
}

void HistoryRecorder::Begin() {
  if (!leaving_.reports.empty()) {  // the previous batch is not passed on yet
    loop_.PostAt(loop_.clock().NowNs() + kDelayNs, [this] { Begin(); });
    return;
  }
  is_scheduled_ = false;
  leaving_ = std::exchange(waiting_, {});
  for (const SessionReport& report : leaving_.reports) scenes_.insert(report.scene);
  Continue();
}

void HistoryRecorder::Continue() {
  for (size_t i = 0; i < kScenesPerTask && !scenes_.empty(); ++i) {
    const priors::SceneKey scene = *scenes_.begin();
    scenes_.erase(scenes_.begin());
    const sessions::SceneActivity activity = sessions_.ActivityOf(scene);
    if (activity.run.session_count > 0) leaving_.activities[scene] = outputs_.encode(activity);
  }
  if (!scenes_.empty()) return loop_.PostLater([this] { Continue(); });
  if (!leaving_.reports.empty()) outputs_.write(std::exchange(leaving_, {}));
}

void HistoryRecorder::Finish() {
  scenes_.clear();
  Continue();
  leaving_ = std::exchange(waiting_, {});
  Continue();
}

}  // namespace sweepstake::history
