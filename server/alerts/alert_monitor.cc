#include "server/alerts/alert_monitor.h"

#include <algorithm>
#include <set>
#include <string_view>
#include <tuple>
#include <utility>

#include "server/sessions/common/unix_time.h"

namespace sweepstake::alerts {
namespace {

SceneFigures FiguresOf(const priors::SceneKey& scene, const sessions::SceneActivity& activity,
                       const sessions::GameSession& session) {
  const decision::Diagnosis& diagnosis = session.decisions().diagnosis();
  SceneFigures figures;
  figures.project = scene.project;
  figures.scene = scene.scene;
  figures.machine_class = scene.machine_class;
  figures.session_count = activity.run.session_count;
  figures.active_arm = activity.run.active_arm;
  if (!diagnosis.best_probability.empty())
    figures.leader_probability = diagnosis.best_probability[diagnosis.leader];
  if (diagnosis.verdict != Verdict::kUnknown) figures.expected_loss_us = ExpectedLossUs(session);
  figures.saved_against_initial_us = activity.report.total.saved_against_initial_us;
  figures.saved_against_single_us = activity.report.total.saved_against_single_us;
  figures.saved_against_reference_us = activity.report.total.saved_against_reference_us;
  return figures;
}

}  // namespace

absl::Status AlertMonitor::Start() {
  absl::Status restored;
  if (!options_.silences.empty()) {
    restored = board_.Restore(options_.silences, loop_.clock().NowNs(), priors::UnixNowMs());
  }
  BeginLook();
  return restored;
}

void AlertMonitor::BeginLook() {
  if (stopped_) return;
  look_ns_ = loop_.clock().NowNs();
  ++look_count_;
  LookAtSessions("");
}

void AlertMonitor::LookAtSessions(const std::string& after) {
  if (stopped_) return;
  const std::string last = sessions_.Visit(
      after, kSessionsPerTask, [this](const auto& session, auto state) { LookAt(session, state); });
  if (!last.empty()) return loop_.PostLater([this, last] { LookAtSessions(last); });
  LookAtGone();
  if (options_.checks) {
    for (const CheckResult& check : options_.checks()) findings_.Add(check);
  }
  // Each step of a large look is a task of its own.
  loop_.PostLater([this] {
    const auto found = std::make_shared<Found>(findings_.Take(AlertBoard::kMaxAlerts));
    loop_.PostLater([this, found] { UpdateBoard(std::move(*found)); });
  });
}

void AlertMonitor::LookAt(const sessions::GameSession& session, sessions::SessionState state) {
  Seen& seen = seen_[session.identity().id];
  if (seen.look == 0) seen.scene = session.identity().scene;
  seen.look = look_count_;
  const uint64_t bail_out_count = session.decisions().counts().charged_bail_out_count;
  if (bail_out_count > std::exchange(seen.bail_out_count, bail_out_count))
    seen.bailed_out_ns = look_ns_;
  if (session.dropped_frame_count() >
      std::exchange(seen.dropped_frame_count, session.dropped_frame_count()))
    seen.dropped_ns = look_ns_;
  SessionFacts facts = FactsOf(session, state);
  facts.bailed_out = IsRecent(seen.bailed_out_ns);
  facts.dropped_frames = IsRecent(seen.dropped_ns);
  findings_.Add(facts);
  if (facts.is_connected && options_.max_metric_scenes > 0) ++session_counts_[facts.scene];
}

bool AlertMonitor::IsRecent(std::optional<int64_t> time_ns) const {
  return time_ns && look_ns_ - *time_ns < kLatelyNs;
}

void AlertMonitor::LookAtGone() {
  size_t gone_count = 0;
  std::erase_if(seen_, [&](const auto& each) {
    const auto& [id, seen] = each;
    if (seen.look == look_count_) return false;
    const bool bailed_out = IsRecent(seen.bailed_out_ns);
    const bool dropped_frames = IsRecent(seen.dropped_ns);
    if ((!bailed_out && !dropped_frames) || ++gone_count > kMaxGone) return true;
    findings_.Add({.id = id,
                   .scene = seen.scene,
                   .bailed_out = bailed_out,
                   .dropped_frames = dropped_frames});
    return false;
  });
}

void AlertMonitor::UpdateBoard(Found found) {
  const AlertChanges changes = board_.Update(std::move(found), look_ns_, priors::UnixNowMs());
  SaveSilences();
  if (options_.announce && (!changes.begun.empty() || !changes.ended.empty()))
    options_.announce(changes);
  next_figures_.alerts = board_.Counts();
  loop_.PostLater(
      [this] { CollectScenes(std::make_shared<const std::vector<SceneKey>>(ChooseScenes()), 0); });
}

void AlertMonitor::SaveSilences() {
  if (board_.TakeSilencesChanged() && options_.save_silences)
    options_.save_silences(board_.SilencesText());
}

std::vector<priors::SceneKey> AlertMonitor::ChooseScenes() {
  std::vector<const std::pair<const SceneKey, uint32_t>*> played;
  played.reserve(session_counts_.size());
  for (const auto& scene : session_counts_) played.push_back(&scene);
  // Scenes with equally many sessions stay in the order of their keys.
  std::stable_sort(played.begin(), played.end(),
                   [](const auto* a, const auto* b) { return a->second > b->second; });
  // The labels of a series do not contain the version of the reward.
  std::set<std::tuple<std::string_view, std::string_view, std::string_view>> names;
  std::vector<SceneKey> chosen;
  for (const auto* scene : played) {
    if (chosen.size() >= options_.max_metric_scenes) break;
    const SceneKey& key = scene->first;
    if (names.emplace(key.project, key.scene, key.machine_class).second) chosen.push_back(key);
  }
  session_counts_.clear();
  std::sort(chosen.begin(), chosen.end());
  return chosen;
}

void AlertMonitor::CollectScenes(const std::shared_ptr<const std::vector<SceneKey>>& scenes,
                                 size_t next) {
  const size_t end = std::min(next + kReportsPerTask, scenes->size());
  for (; next < end; ++next) {
    const sessions::SceneActivity activity = sessions_.ActivityOf((*scenes)[next]);
    const auto session = sessions_.Find(activity.run.session_id);
    if (session == nullptr) continue;  // the last session has disconnected since the choice
    next_figures_.scenes.push_back(FiguresOf((*scenes)[next], activity, *session));
  }
  if (next == scenes->size()) return EndLook();
  loop_.PostLater([this, scenes, next] { CollectScenes(scenes, next); });
}

void AlertMonitor::EndLook() {
  auto figures = std::make_shared<const AlertFigures>(std::exchange(next_figures_, {}));
  {
    const std::lock_guard lock(mutex_);
    figures_ = std::move(figures);
  }
  loop_.PostAt(look_ns_ + kLookIntervalNs, [this] { BeginLook(); });
}

absl::Status AlertMonitor::AddSilence(Silence silence, int64_t duration_ms) {
  silence.unix_until_ms = duration_ms == 0 ? 0 : priors::UnixNowMs() + duration_ms;
  absl::Status added = board_.Add(std::move(silence), loop_.clock().NowNs());
  SaveSilences();
  return added;
}

bool AlertMonitor::Unsilence(const std::string& id) {
  const bool ended = board_.Unsilence(id);
  SaveSilences();
  return ended;
}

std::shared_ptr<const AlertFigures> AlertMonitor::figures() const {
  const std::lock_guard lock(mutex_);
  return figures_;
}

}  // namespace sweepstake::alerts
