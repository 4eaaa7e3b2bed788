#include "engine_client/cli/game/run_report.h"

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>
#include <numeric>

#include "engine_client/cli/io/csv_file.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array kReasons = {SwitchReason::kPolicy, SwitchReason::kExploration,
                                 SwitchReason::kBailOut, SwitchReason::kManual};

double Seconds(uint64_t ns) { return static_cast<double>(ns) * 1e-9; }

double Ratio(double part, double whole) { return whole > 0 ? part / whole : 0; }

uint64_t ActiveNs(const GameRun& run) {
  return std::accumulate(
      run.activities().begin(), run.activities().end(), uint64_t{0},
      [](uint64_t sum, const ArmActivity& activity) { return sum + activity.active_ns; });
}

size_t SwitchCount(const GameRun& run, SwitchReason reason) {
  return static_cast<size_t>(
      std::count_if(run.switches().begin(), run.switches().end(),
                    [&](const SwitchEvent& event) { return event.reason == reason; }));
}

double Evidence(const ArmBelief& belief) { return belief.alpha + belief.beta; }
double Mean(const ArmBelief& belief) { return belief.alpha / Evidence(belief); }

// What is known about one arm in the end.
struct ArmRow {
  std::string arm;
  ArmBelief belief;  // Beta(1,1) where nothing was heard
  ArmActivity activity;

  double mean() const { return Mean(belief); }
  double evidence() const { return Evidence(belief); }
  double fps() const {
    return Ratio(static_cast<double>(activity.frame_count), Seconds(activity.active_ns));
  }
  double detection_ms() const {
    return Ratio(Seconds(activity.detection_ns) * 1e3, static_cast<double>(activity.frame_count));
  }
};

std::vector<ArmRow> ArmRows(const GameRun& run, const SessionStats& stats) {
  std::vector<ArmRow> rows;
  rows.reserve(run.activities().size());
  for (size_t i = 0; i < run.activities().size(); ++i) {
    rows.push_back({run.adaptive().arms()[i], {}, run.activities()[i]});
    if (i < stats.beliefs.size()) rows.back().belief = stats.beliefs[i];
  }
  return rows;
}

void PrintArms(const GameRun& run, const SessionStats& stats, std::ostream& out) {
  TextTable table({"arm", "mean", "alpha", "beta", "n", "active_s", "active_%", "frames", "fps",
                   "detection_ms"});
  const double active_s = Seconds(ActiveNs(run));
  for (const ArmRow& row : ArmRows(run, stats)) {
    const double arm_s = Seconds(row.activity.active_ns);
    table.AddRow({row.arm, Fixed(row.mean(), 3), Fixed(row.belief.alpha, 2),
                  Fixed(row.belief.beta, 2), Fixed(row.evidence(), 2), Fixed(arm_s, 1),
                  Fixed(100 * Ratio(arm_s, active_s), 1), std::to_string(row.activity.frame_count),
                  Fixed(row.fps(), 0), Fixed(row.detection_ms(), 4)});
  }
  table.Print(out);
}

void PrintSwitches(const GameRun& run, std::ostream& out) {
  out << run.switches().size() << " switches";
  const char* separator = ": ";
  for (const SwitchReason reason : kReasons) {
    const size_t count = SwitchCount(run, reason);
    if (count == 0) continue;
    out << separator << count << ' ' << ReasonName(reason);
    separator = ", ";
  }
  out << '\n';
}

std::string StateName(ShadowState state) {
  switch (state) {
    case ShadowState::kOff:
      return "off";
    case ShadowState::kOneArm:
      return "off, there is one arm only";
    case ShadowState::kNoSpareCore:
      return "off, no core to spare";
    case ShadowState::kPaused:
      return "paused in manual mode";
    case ShadowState::kRunning:
      return "running";
    case ShadowState::kTooBig:
      return "off, the scene is too big for its memory";
  }
  return "unknown";
}

double BusyShare(const ShadowStats& stats, uint64_t elapsed_ns) {
  return Ratio(static_cast<double>(stats.busy_time_ns), static_cast<double>(elapsed_ns));
}

double CopyNsPerFrame(const ShadowStats& stats, uint64_t frame_count) {
  return Ratio(static_cast<double>(stats.copy_time_ns), static_cast<double>(frame_count));
}

Json ShadowJson(const ShadowStats& stats, uint64_t frame_count, uint64_t elapsed_ns) {
  return {{"state", StateName(stats.state)},
          {"sweeps", stats.sweep_count},
          {"visits", stats.visit_count},
          {"capped_visits", stats.capped_visit_count},
          {"busy_share", BusyShare(stats, elapsed_ns)},
          {"copied_frames", stats.copied_frame_count},
          {"copy_ns_per_frame", CopyNsPerFrame(stats, frame_count)},
          {"memory_bytes", stats.memory_bytes},
          {"warm_switches", stats.warm_switch_count},
          {"cold_switches", stats.cold_switch_count}};
}

Json SwitchJson(const SwitchEvent& event, const AdaptiveBroadPhase& adaptive) {
  return {{"frame", event.frame_index},
          {"time_s", Seconds(event.time_ns)},
          {"from", adaptive.arms()[event.from]},
          {"to", adaptive.arms()[event.to]},
          {"reason", ReasonName(event.reason)}};
}

std::string TimeText(uint64_t time_ns, uint64_t frame_index) {
  return Fixed(Seconds(time_ns), 1) + " s  frame " + std::to_string(frame_index) + ": ";
}

Json VerdictJson(const SceneVerdict& verdict, const AdaptiveBroadPhase& adaptive) {
  Json document = {{"verdict", VerdictName(verdict.verdict)}};
  if (verdict.verdict == Verdict::kUnknown) return document;
  document["leader_arm"] = adaptive.arms()[verdict.leader_arm];
  document["leader_probability"] = verdict.leader_probability;
  return document;
}

Json VerdictChangeJson(const VerdictEvent& event, const AdaptiveBroadPhase& adaptive) {
  Json document = {{"frame", event.frame_index}, {"time_s", Seconds(event.time_ns)}};
  document.update(VerdictJson(event.verdict, adaptive));
  return document;
}

Json ArmJson(const ArmRow& row) {
  return {{"arm", row.arm},
          {"alpha", row.belief.alpha},
          {"beta", row.belief.beta},
          {"mean", row.mean()},
          {"n", row.evidence()},
          {"active_s", Seconds(row.activity.active_ns)},
          {"frames", row.activity.frame_count},
          {"fps", row.fps()},
          {"detection_ms", row.detection_ms()}};
}

// Of the switch with this epoch; zeros where it did not settle before the end.
SwitchOutcome OutcomeOf(const GameRun& run, uint32_t switch_epoch) {
  for (const SwitchOutcome& outcome : run.outcomes()) {
    if (outcome.executed == 1 && outcome.switch_epoch == switch_epoch) return outcome;
  }
  return {};
}

Status WriteSwitches(const GameRun& run, const std::filesystem::path& path) {
  auto csv = CsvFile::Create(
      path, {"frame", "time_s", "from", "to", "reason", "rebuild_time_ns", "settling_cost_ns"});
  if (!csv.ok()) return csv.status();
  const auto arms = run.adaptive().arms();
  for (const SwitchEvent& event : run.switches()) {
    const SwitchOutcome outcome = OutcomeOf(run, event.switch_epoch);
    (*csv)->Row({std::to_string(event.frame_index), Fixed(Seconds(event.time_ns), 6),
                 arms[event.from], arms[event.to], ReasonName(event.reason),
                 std::to_string(outcome.rebuild_time_ns),
                 std::to_string(outcome.settling_cost_ns)});
  }
  return (*csv)->Commit();
}

Status WritePosteriors(const GameRun& run, const SessionStats& stats,
                       const std::filesystem::path& path) {
  auto csv = CsvFile::Create(
      path, {"arm", "backend_version", "alpha", "beta", "mean", "n", "active_s", "frames"});
  if (!csv.ok()) return csv.status();
  const auto versions = run.adaptive().arm_versions();
  size_t index = 0;
  for (const ArmRow& row : ArmRows(run, stats)) {
    (*csv)->Row({row.arm, std::to_string(versions[index++]), Fixed(row.belief.alpha, 9),
                 Fixed(row.belief.beta, 9), Fixed(row.mean(), 9), Fixed(row.evidence(), 9),
                 Fixed(Seconds(row.activity.active_ns), 6),
                 std::to_string(row.activity.frame_count)});
  }
  return (*csv)->Commit();
}

}  // namespace

std::string PriorsText(const RunSetup& setup, const SessionStats& stats) {
  if (stats.prior_source_count == 0 && !setup.priors_file.empty()) {
    return setup.priors_file + " has no priors of these backends for " + setup.priors_key +
           ": every arm starts from Beta(1,1)";
  }
  if (stats.prior_source_count == 0) return "no priors yet: every arm starts from Beta(1,1)";
  return "starts from priors of " + std::to_string(stats.prior_source_count) +
         (stats.prior_source_count == 1 ? " earlier session" : " earlier sessions");
}

std::string SwitchText(const SwitchEvent& event, const AdaptiveBroadPhase& adaptive) {
  return TimeText(event.time_ns, event.frame_index) + adaptive.arms()[event.from] + " → " +
         adaptive.arms()[event.to] + " (" + ReasonName(event.reason) + ")";
}

std::string VerdictText(const SceneVerdict& verdict, const AdaptiveBroadPhase& adaptive) {
  const std::string name = VerdictName(verdict.verdict);
  if (verdict.verdict == Verdict::kUnknown) return name;
  return name + ": " + adaptive.arms()[verdict.leader_arm] + " is the best with probability " +
         Fixed(verdict.leader_probability, 2);
}

std::string VerdictChangeText(const VerdictEvent& event, const AdaptiveBroadPhase& adaptive) {
  return TimeText(event.time_ns, event.frame_index) + "verdict " +
         VerdictText(event.verdict, adaptive);
}

std::string BeliefsText(std::span<const ArmBelief> beliefs) {
  std::vector<ArmBelief> best_first(beliefs.begin(), beliefs.end());
  std::stable_sort(best_first.begin(), best_first.end(),
                   [](const ArmBelief& a, const ArmBelief& b) { return Mean(a) > Mean(b); });
  std::string text;
  for (const ArmBelief& belief : best_first) {
    text += (text.empty() ? "" : " · ") + belief.arm + " " + Fixed(Mean(belief), 2) +
            (text.empty() ? " (n " : " (") + Fixed(Evidence(belief), 0) + ")";
  }
  return text;
}

std::string ShadowText(const ShadowStats& stats, uint64_t frame_count, uint64_t elapsed_ns) {
  std::string text = "Shadow lane: " + StateName(stats.state);
  if (stats.visit_count > 0) {
    text += ", " + std::to_string(stats.visit_count) + " visits in " +
            std::to_string(stats.sweep_count) + " sweeps, " +
            Fixed(100 * BusyShare(stats, elapsed_ns), 1) +
            " % of its thread's time, copying took " +
            Fixed(CopyNsPerFrame(stats, frame_count), 0) + " ns per frame";
  }
  return text + "; " + std::to_string(stats.warm_switch_count) + " warm and " +
         std::to_string(stats.cold_switch_count) + " cold switches";
}

std::string DroppedText(uint64_t dropped_count, uint64_t frame_count) {
  if (dropped_count == 0) return "no samples dropped";
  return std::to_string(dropped_count) + " of " + std::to_string(frame_count) +
         " samples were dropped because the queue was full (frames come faster than they are "
         "sent): the evidence is thinner, the frames themselves were not affected";
}

void PrintRunReport(const RunSetup& setup, const GameRun& run, const SessionStats& stats,
                    std::ostream& out) {
  const double active_s = Seconds(ActiveNs(run));
  out << "\nPosteriors learnt in " << setup.scene.name << " with " << setup.scene.object_count
      << " objects (" << PriorsText(setup, stats) << ")\n";
  PrintArms(run, stats, out);
  if (stats.beliefs.empty()) out << "Nothing was learnt yet: these are Beta(1,1)\n";
  out << run.frame_count() << " frames in " << Fixed(active_s, 1) << " s, "
      << Fixed(Ratio(static_cast<double>(run.frame_count()), active_s), 0) << " frames/s\n"
      << DroppedText(stats.dropped_frame_count, run.frame_count()) << '\n';
  PrintSwitches(run, out);
  out << ShadowText(run.adaptive().shadow_stats(), run.frame_count(), ActiveNs(run)) << '\n';
  out << "Verdict: " << VerdictText(stats.verdict, run.adaptive()) << '\n';
}

nlohmann::ordered_json RunReportJson(const RunSetup& setup, const GameRun& run,
                                     const SessionStats& stats) {
  const double active_s = Seconds(ActiveNs(run));
  Json document = {
      {"command", "run"},
      {"scene", setup.scene.name},
      {"objects", setup.scene.object_count},
      {"seed", setup.scene.seed},
      {"mode", setup.mode},
      {"decider", setup.decider},
      {"session_id", stats.session_id},
      {"connections", stats.connection_count},
      {"last_error", stats.last_error},
      {"prior_sources", stats.prior_source_count},
      {"frames", run.frame_count()},
      {"seconds", active_s},
      {"fps", Ratio(static_cast<double>(run.frame_count()), active_s)},
      {"sent_frames", stats.sent_frame_count},
      {"dropped_frames", stats.dropped_frame_count},
      {"resent_messages", stats.resent_message_count},
      {"commands", stats.command_count},
      {"active_arm", run.adaptive().arms()[run.adaptive().active_arm()]},
      {"shadow", ShadowJson(run.adaptive().shadow_stats(), run.frame_count(), ActiveNs(run))},
      {"arms", Json::array()},
      {"switches_by_reason", Json::object()},
      {"switches", Json::array()},
      {"verdict_changes", Json::array()},
  };
  for (const ArmRow& row : ArmRows(run, stats)) document["arms"].push_back(ArmJson(row));
  for (const SwitchReason reason : kReasons) {
    document["switches_by_reason"][ReasonName(reason)] = SwitchCount(run, reason);
  }
  for (const SwitchEvent& event : run.switches()) {
    document["switches"].push_back(SwitchJson(event, run.adaptive()));
  }
  document.update(VerdictJson(stats.verdict, run.adaptive()));
  for (const VerdictEvent& event : run.verdicts()) {
    document["verdict_changes"].push_back(VerdictChangeJson(event, run.adaptive()));
  }
  return document;
}

Status WriteRunReportCsv(const GameRun& run, const SessionStats& stats,
                         const std::filesystem::path& folder) {
  if (Status status = WriteSwitches(run, folder / "switches.csv"); !status.ok()) return status;
  return WritePosteriors(run, stats, folder / "posteriors.csv");
}

}  // namespace sweepstake::cli
