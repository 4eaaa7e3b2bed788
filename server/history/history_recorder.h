// Collects what sessions report (sessions/common/session_use.h), and passes it to the history a few
// seconds later, with the activity of each scene.
//
// Used on the decision loop only. Reports are only copied here; the history's thread adds them up.
// The memory is bounded by kMaxReports.
#pragma once

#include <cstdint>
#include <functional>
#include <set>
#include <utility>

#include "server/history/history_point.h"
#include "server/sessions/common/decision_loop.h"
#include "server/sessions/session_identity.h"
#include "server/sessions/session_table.h"

namespace sweepstake::history {

class HistoryRecorder {
 public:
  // Sessions report after the same moment of the wall clock, at their next decisions.
  static constexpr int64_t kDelayNs = 5'000'000'000;
  // The number of activities that one task of the loop computes. Each takes up to 0.84 ms
  // (DecisionSession::Report).
  static constexpr size_t kScenesPerTask = 4;
  // Maximum number of reports that wait; further ones are lost.
  static constexpr size_t kMaxReports = 50'000;

  struct Outputs {
    std::function<v1::SceneActivity(const sessions::SceneActivity&)> encode;
    std::function<void(HistoryBatch)> write;
  };

  // Borrows the loop and the table.
  HistoryRecorder(sessions::DecisionLoop& loop, const sessions::SessionTable& sessions,
                  Outputs outputs)
      : loop_(loop), sessions_(sessions), outputs_(std::move(outputs)) {}

  void Add(const sessions::SessionIdentity& session, sessions::SessionUse use);
  // Passes everything on now, without further activities. For the end of the daemon.
  void Finish();

 private:
  void Begin();
  // Adds the activities of the next scenes, or passes the batch on if none is left.
  void Continue();

  sessions::DecisionLoop& loop_;
  const sessions::SessionTable& sessions_;
  const Outputs outputs_;
  HistoryBatch waiting_;
  HistoryBatch leaving_;               // gets its activities
  std::set<priors::SceneKey> scenes_;  // of leaving_, without an activity so far
  bool is_scheduled_ = false;
};

}  // namespace sweepstake::history
