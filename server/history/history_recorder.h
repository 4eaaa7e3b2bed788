// Collects what sessions report (sessions/common/session_use.h), and passes it to the history a few
// seconds later, with the activity of each scene.
//
// Used on the decision loop only. The report of a scene's activity takes up to 0.84 ms
// (DecisionSession::Report), so a task of the loop adds at most kScenesPerTask of them. The memory
// is bounded by kMaxPending.
#pragma once

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "server/history/history_file.h"
#include "server/sessions/common/decision_loop.h"
#include "server/sessions/session_table.h"

namespace sweepstake::history {

class HistoryRecorder {
 public:
  // Sessions report after the same moment of the wall clock, at their next decisions.
  static constexpr int64_t kDelayNs = 5'000'000'000;
  static constexpr size_t kScenesPerTask = 8;
  // Maximum number of series that wait. Points of further series are lost.
  static constexpr size_t kMaxPending = 65'536;

  struct Outputs {
    std::function<v1::SceneActivity(const sessions::SceneActivity&)> encode;
    std::function<void(std::vector<HistoryEntry>)> write;
  };

  // Borrows the loop and the table.
  HistoryRecorder(sessions::DecisionLoop& loop, const sessions::SessionTable& sessions,
                  Outputs outputs)
      : loop_(loop), sessions_(sessions), outputs_(std::move(outputs)) {}

  void Add(const sessions::SessionIdentity& session, const sessions::SessionUse& use);
  // Passes everything on now, without activities. For the end of the daemon.
  void Finish();

 private:
  using Points = std::map<SeriesKey, v1::HistoryPoint>;

  void AddTo(SeriesKey key, const v1::HistoryPoint& point);
  void Begin();
  // Adds the activities of the next scenes, or passes all points on if none is left.
  void Continue(const SeriesKey& after);

  sessions::DecisionLoop& loop_;
  const sessions::SessionTable& sessions_;
  const Outputs outputs_;
  Points pending_;
  Points leaving_;  // points that Continue completes
  bool is_scheduled_ = false;
};

}  // namespace sweepstake::history
