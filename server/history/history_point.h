// Sums of points of the history. A point is a message sweepstake.v1.HistoryPoint.
#pragma once

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "server/sessions/common/session_use.h"
#include "server/sessions/prior_store.h"
#include "sweepstake/v1/history.pb.h"

namespace sweepstake::history {

// The key of a series. Keys are ordered by kind, project, scene, machine class, reward version,
// build and session.
struct SeriesKey {
  v1::HistoryKind kind = v1::HISTORY_KIND_SCENE;
  priors::SceneKey scene;
  std::string build = {};    // empty in a series of all builds
  std::string session = {};  // empty in a series of several sessions

  // NOLINTNEXTLINE(modernize-use-nullptr): clang-tidy reads a 0 into the defaulted comparison.
  friend auto operator<=>(const SeriesKey&, const SeriesKey&) = default;
};

void ToProto(const sessions::LogHistogram& histogram, v1::LogHistogram& message);

// What a session ran since its previous report.
struct SessionReport {
  priors::SceneKey scene = {};
  std::string build = {};
  std::string session = {};
  std::vector<std::string> arms = {};
  sessions::SessionUse use = {};
};

// Reports of sessions, and the activity of their scenes at the end of the reports.
struct HistoryBatch {
  std::vector<SessionReport> reports = {};
  std::map<priors::SceneKey, v1::SceneActivity> activities = {};
};

using HistoryEntry = std::pair<SeriesKey, v1::HistoryPoint>;

// Returns the point of one report. It has no activity.
v1::HistoryPoint PointOf(const SessionReport& report);
// Returns the sums of the reports for their scenes, builds and sessions.
std::vector<HistoryEntry> EntriesOf(const HistoryBatch& batch);

// Adds `point` to `sum`. The period of the sum then includes that of the point, and the activity is
// that of the later one. If a histogram has more than LogHistogram::kMaxBuckets buckets, the lowest
// ones are joined; if a count exceeds 32 bits, all counts are halved.
void Add(const v1::HistoryPoint& point, v1::HistoryPoint& sum);

}  // namespace sweepstake::history
