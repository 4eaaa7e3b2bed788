#include "engine_client/cli/game/run_summary.h"

#include <algorithm>
#include <numeric>

#include "engine_client/cli/io/duration.h"

namespace sweepstake::cli {
namespace {

// Returns part ÷ whole, or 0 if `whole` is 0.
double Ratio(double part, double whole) { return whole > 0 ? part / whole : 0; }

std::vector<ArmRow> ArmRows(const GameRun& run, const SessionStats& session) {
  std::vector<ArmRow> rows;
  rows.reserve(run.activities().size());
  for (size_t i = 0; i < run.activities().size(); ++i) {
    rows.push_back(
        {run.adaptive().arms()[i], run.adaptive().arm_versions()[i], {}, run.activities()[i]});
    if (i < session.beliefs.size()) rows.back().belief = session.beliefs[i];
  }
  return rows;
}

}  // namespace

double ArmRow::mean() const { return belief.alpha / (belief.alpha + belief.beta); }

double ArmRow::fps() const { return Ratio(static_cast<double>(activity.frame_count), active_s()); }

double ArmRow::detection_ms() const {
  return Ratio(Seconds(activity.detection_ns) * 1e3, static_cast<double>(activity.frame_count));
}

uint64_t RunSummary::active_ns() const {
  return std::accumulate(
      arms.begin(), arms.end(), uint64_t{0},
      [](uint64_t sum, const ArmRow& row) { return sum + row.activity.active_ns; });
}

double RunSummary::fps() const { return Ratio(static_cast<double>(frame_count), active_s()); }

size_t RunSummary::SwitchCount(SwitchReason reason) const {
  return static_cast<size_t>(
      std::count_if(switches.begin(), switches.end(),
                    [&](const SwitchRow& row) { return row.reason == reason; }));
}

double RunSummary::shadow_busy_ratio() const {
  return Ratio(static_cast<double>(shadow.busy_time_ns), static_cast<double>(active_ns()));
}

double RunSummary::shadow_frame_share() const {
  return Ratio(static_cast<double>(shadow.slowdown_time_ns + shadow.copy_time_ns),
               static_cast<double>(active_ns()));
}

double RunSummary::shadow_copy_ns_per_frame() const {
  return Ratio(static_cast<double>(shadow.copy_time_ns), static_cast<double>(frame_count));
}

double RunSummary::shadow_ms_per_frame() const {
  return Ratio(Seconds(shadow.busy_time_ns) * 1e3, static_cast<double>(frame_count));
}

double RunSummary::detection_ms() const {
  double sum_ms = 0;
  for (const ArmRow& row : arms) sum_ms += Seconds(row.activity.detection_ns) * 1e3;
  return Ratio(sum_ms, static_cast<double>(frame_count));
}

SwitchRow ToRow(const SwitchEvent& event, const AdaptiveBroadPhase& adaptive) {
  return {.frame_index = event.frame_index,
          .time_s = Seconds(event.time_ns),
          .from = adaptive.arms()[event.from],
          .to = adaptive.arms()[event.to],
          .reason = event.reason};
}

VerdictRow ToRow(const SceneVerdict& verdict, const AdaptiveBroadPhase& adaptive) {
  if (verdict.verdict == Verdict::kUnknown) return {};
  return {.name = VerdictName(verdict.verdict),
          .leader_arm = adaptive.arms()[verdict.leader_arm],
          .leader_probability = verdict.leader_probability};
}

VerdictChangeRow ToRow(const VerdictEvent& event, const AdaptiveBroadPhase& adaptive) {
  return {event.frame_index, Seconds(event.time_ns), ToRow(event.verdict, adaptive)};
}

RunSummary Summarize(const RunSetup& setup, const GameRun& run, const SessionStats& session) {
  const AdaptiveBroadPhase& adaptive = run.adaptive();
  RunSummary summary{.setup = setup,
                     .session = session,
                     .shadow = adaptive.shadow_stats(),
                     .frame_count = run.frame_count(),
                     .suspended_frame_count = run.suspended_frame_count(),
                     .invalid_box_count = adaptive.last_sample().invalid_box_count,
                     .initial_arm = adaptive.arms()[adaptive.initial_arm()],
                     .active_arm = adaptive.arms()[adaptive.active_arm()],
                     .verdict = ToRow(session.verdict, adaptive),
                     .arms = ArmRows(run, session),
                     .switches = {},
                     .verdict_changes = {}};
  for (const SwitchEvent& event : run.switches()) {
    SwitchRow row = ToRow(event, adaptive);
    const SwitchOutcome outcome = OutcomeOf(run.outcomes(), event.switch_epoch);
    row.rebuild_time_ns = outcome.rebuild_time_ns;
    row.settling_cost_ns = outcome.settling_cost_ns;
    row.trial_detection_time_ns = outcome.trial_detection_time_ns;
    summary.switches.push_back(std::move(row));
  }
  for (const VerdictEvent& event : run.verdicts()) {
    summary.verdict_changes.push_back(ToRow(event, adaptive));
  }
  return summary;
}

}  // namespace sweepstake::cli
