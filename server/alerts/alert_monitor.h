// Looks at all sessions and health checks every few seconds, keeps the alerts, and collects the
// figures for metrics.
//
// A look is spread over several tasks of the decision loop, so that it does not delay decisions: a
// task reads kSessionsPerTask sessions, or computes the reports of kReportsPerTask scenes. Used on
// the decision loop, except figures(), which is thread-safe. REQUIRES: the loop has ended before
// the monitor is destroyed.
#pragma once

#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <mutex>
#include <optional>
#include <string>
#include <vector>

#include "server/alerts/alert_board.h"
#include "server/alerts/alert_options.h"
#include "server/alerts/alert_rules.h"
#include "server/sessions/common/decision_loop.h"
#include "server/sessions/session_table.h"

namespace sweepstake::alerts {

// The figures of a scene that is played now. The session that has been connected the longest stands
// for its scene. Times are per frame in µs; absent: not known.
struct SceneFigures {
  std::string project;
  std::string scene;
  std::string machine_class;
  uint32_t session_count = 0;
  std::string active_arm;
  double leader_probability = 0;
  std::optional<double> expected_loss_us;
  std::optional<double> saved_against_initial_us;  // a loss is negative
  std::optional<double> saved_against_single_us;
  std::optional<double> saved_against_reference_us;  // against decision::kReferenceArm
};

struct AlertFigures {
  AlertCounts alerts = {};
  std::vector<SceneFigures> scenes = {};  // ordered by project, scene and machine class
};

class AlertMonitor {
 public:
  static constexpr int64_t kLookIntervalNs = 5'000'000'000;
  static constexpr size_t kSessionsPerTask = 100;
  static constexpr size_t kReportsPerTask = 4;
  // Maximum number of sessions that have left memory, whose recent bail-outs and dropped frames
  // still count.
  static constexpr size_t kMaxGone = 1'000;

  // Borrows all arguments.
  AlertMonitor(const AlertOptions& options, sessions::DecisionLoop& loop,
               const sessions::SessionTable& sessions)
      : options_(options), loop_(loop), sessions_(sessions) {}

  // Restores the silences and begins the first look. Error: DATA_LOSS (the text of the silences is
  // damaged, and there are none; the looks begin nevertheless).
  absl::Status Start();
  // No look begins after this call.
  void Stop() { stopped_ = true; }

  const AlertBoard& board() const { return board_; }
  // As AlertBoard, and saves the silences. A silence lasts `duration_ms` from now; 0: until the
  // alert ends.
  absl::Status AddSilence(Silence silence, int64_t duration_ms);
  bool Unsilence(const std::string& id);

  // The figures of the latest complete look.
  std::shared_ptr<const AlertFigures> figures() const;

 private:
  using SceneKey = priors::SceneKey;
  using Found = std::map<AlertKey, Finding>;
  // What the looks have seen of a session.
  struct Seen {
    SceneKey scene;
    uint64_t look = 0;  // number of the latest look that found it
    uint64_t bail_out_count = 0;
    uint64_t dropped_frame_count = 0;
    std::optional<int64_t> bailed_out_ns;  // time of the look that found the latest bail-out
    std::optional<int64_t> dropped_ns;
  };

  void BeginLook();
  void LookAtSessions(const std::string& after);
  void LookAt(const sessions::GameSession& session, sessions::SessionState state);
  bool IsRecent(std::optional<int64_t> time_ns) const;
  // Adds the recent events of sessions that have left memory, and forgets the others.
  void LookAtGone();
  void UpdateBoard(Found found);
  void SaveSilences();
  // Chooses the scenes with metrics: those with the most connected sessions.
  std::vector<SceneKey> ChooseScenes();
  void CollectScenes(const std::shared_ptr<const std::vector<SceneKey>>& scenes, size_t next);
  void EndLook();

  const AlertOptions& options_;
  sessions::DecisionLoop& loop_;
  const sessions::SessionTable& sessions_;
  bool stopped_ = false;
  AlertBoard board_;
  std::map<std::string, Seen> seen_;  // by session
  // The members below belong to the present look.
  int64_t look_ns_ = 0;
  uint64_t look_count_ = 0;
  Findings findings_;
  std::map<SceneKey, uint32_t> session_counts_;  // connected sessions; empty without metrics
  AlertFigures next_figures_;

  mutable std::mutex mutex_;
  std::shared_ptr<const AlertFigures> figures_ =
      std::make_shared<const AlertFigures>();  // guarded by mutex_
};

}  // namespace sweepstake::alerts
