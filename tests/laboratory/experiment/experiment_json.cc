// Makes the JSON document of an experiment.
#include <algorithm>
#include <map>
#include <nlohmann/json.hpp>

#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/decider/types.h"
#include "sweepstake/broad_phase.h"
#include "tests/laboratory/experiment/experiment_output.h"
#include "tests/laboratory/experiment/paper_tables.h"
#include "tests/laboratory/replay/replay_output.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

// A chart of a run's posteriors is about 200 pixels wide, so more points would not be visible.
constexpr size_t kMaxPosteriorPoints = 50;

// Adds the columns that come from the trace: the fastest arm and the policy's regret.
void AddTruth(const CellTruth& truth, const CellSummary& cell, Json& row) {
  row["truly_fastest"] = truth.ranking.front().arm;
  for (const ReplayedPlayer& player : truth.players) {
    if (player.name == OwnPolicyName(cell.policy)) row["replay_regret"] = player.regret;
  }
  for (const Agreement& each : truth.agreements) {
    if (each.policy != cell.policy) continue;
    row["live_regret"] = each.regret;
    row["live_regret_agrees"] = each.regret_agrees();
    row["active_share_agrees"] = each.share_agrees();
  }
}

// Returns the row of a cell and policy, which is flat except for the list of dominant arms.
Json RowJson(const ExperimentReport& report, const CellSummary& cell) {
  Json row = {{"policy", cell.policy},
              {"scene", cell.cell.scene},
              {"objects", cell.cell.object_count},
              {"runs", cell.runs.size()},
              {"dominance", cell.DominanceText()},
              {"dominant", cell.dominance.front().first},
              {"verdict", VerdictName(cell.verdict)},
              {"switches", cell.switches.mean},
              {"switches_sd", cell.switches.deviation},
              {"active_percent", cell.active_percent.mean},
              {"active_percent_sd", cell.active_percent.deviation},
              {"mu", cell.posterior_mean.mean},
              {"mu_sd", cell.posterior_mean.deviation},
              {"n", cell.evidence.mean},
              {"n_sd", cell.evidence.deviation}};
  if (const CellTruth* truth = report.truths.Of(cell.cell)) AddTruth(*truth, cell, row);
  row["cell"] = cell.cell.label();
  row["own_policy"] = OwnPolicyName(cell.policy);
  row["interpretation"] = cell.Interpretation();
  row["dominant_runs"] = Json::array();
  for (const auto& [arm, runs] : cell.dominance) {
    row["dominant_runs"].push_back({{"arm", arm}, {"runs", runs}});
  }
  return row;
}

Json PeriodsJson(const RunRecord& record) {
  Json periods = Json::array();
  for (const ArmPeriod& period : ArmPeriods(record)) {
    const std::string reason =
        period.reason == 0 ? "" : ReasonName(static_cast<SwitchReason>(period.reason));
    periods.push_back({{"arm", period.arm},
                       {"from_s", period.from_s},
                       {"to_s", period.to_s},
                       {"reason", reason}});
  }
  return periods;
}

// Returns whether the policy wanted another arm but was not allowed to switch.
bool IsHeldBack(const RecordedDecision& decision) {
  const auto outcome = static_cast<DecisionOutcome>(decision.outcome);
  return decision.candidate >= 0 && decision.candidate != decision.active_arm &&
         outcome != DecisionOutcome::kSwitched && outcome != DecisionOutcome::kExploring;
}

Json HeldBackJson(const RunRecord& record) {
  Json times = Json::array();
  for (const RecordedDecision& decision : record.decisions) {
    if (IsHeldBack(decision)) times.push_back(decision.time_s);
  }
  return times;
}

Json BailOutsJson(const RunRecord& record) {
  Json bail_outs = Json::array();
  for (const RecordedSwitch& each : record.switches) {
    if (each.reason != static_cast<uint32_t>(SwitchReason::kBailOut)) continue;
    bail_outs.push_back({{"time_s", each.time_s}, {"arm", each.from}});
  }
  return bail_outs;
}

// Returns the posterior means over time, thinned to a few points; the last point is the run's end.
Json PosteriorsJson(const RunRecord& record) {
  Json points = Json::array();
  const size_t count = record.decisions.size();
  const size_t step = std::max<size_t>(1, count / kMaxPosteriorPoints);
  for (size_t i = 0; i < count; i += step) {
    const RecordedDecision& decision = record.decisions[i + step < count ? i : count - 1];
    Json means = Json::array();
    for (size_t arm = 0; arm < record.arms.size(); ++arm) {
      means.push_back(decision.alpha[arm] / (decision.alpha[arm] + decision.beta[arm]));
    }
    points.push_back({{"time_s", decision.time_s}, {"means", std::move(means)}});
  }
  return points;
}

// Returns the number of decisions in the observation window per verdict.
Json VerdictsJson(const RunRecord& record) {
  std::map<uint32_t, uint64_t> counts;
  for (const RecordedDecision& decision : record.decisions) {
    if (decision.time_s >= record.exploration_s) ++counts[decision.verdict];
  }
  Json json = Json::object();
  for (const auto& [verdict, count] : counts) {
    json[VerdictName(static_cast<Verdict>(verdict))] = count;
  }
  return json;
}

Json TimeJson(const TimeShares& time) {
  return {{"scene_step", time.scene_step_ns},
          {"detection", time.detection_ns},
          {"rebuild", time.rebuild_ns},
          {"copying", time.copying_ns},
          {"around", time.around_ns},
          {"frame_end", time.frame_end_ns},
          {"intake", time.intake_ns},
          {"decision", time.decision_ns},
          {"lane", time.lane_ns}};
}

Json RunJson(const PlayedRun& run) {
  const RunRecord& record = *run.record;
  return {{"cell", record.cell.label()},
          {"policy", record.policy},
          {"run", record.run},
          {"arms", record.arms},
          {"exploration_s", record.exploration_s},
          {"end_s", record.end_s},
          {"time_scale", record.time_scale},
          {"dominant", run.dominant_name()},
          {"active_shares", run.active_shares},
          {"periods", PeriodsJson(record)},
          {"held_back_s", HeldBackJson(record)},
          {"bail_outs", BailOutsJson(record)},
          {"posteriors", PosteriorsJson(record)},
          {"verdicts", VerdictsJson(record)},
          {"time_ns", TimeJson(record.time)},
          {"decisions", record.decisions.size()},
          {"longest_decision_ns", record.time.longest_decision_ns},
          {"dropped_frames", record.dropped_frame_count}};
}

Json PlayerJson(const ReplayedPlayer& player) {
  return {{"name", player.name},
          {"is_policy", player.is_policy},
          {"regret", player.regret},
          {"ci95", IntervalJson(player.ci95)},
          {"after_start_up", OrNull(player.after_start_up)},
          {"switches", player.switches},
          {"active_share", player.active_share},
          {"regret_detection", player.ms.regret_ratio()},
          {"regret_60hz", player.ms.regret() / kFrameMsAt60Hz},
          {"ms_per_frame", FrameMsJson(player.ms, player.paper_ms)}};
}

Json ComparisonJson(const PairedComparison& each) {
  return {{"policy", each.policy},
          {"baseline", each.baseline},
          {"pairs", each.wilcoxon.pair_count},
          {"difference", each.difference},
          {"ci95", IntervalJson(each.ci95)},
          {"p", each.wilcoxon.probability},
          {"p_corrected", each.corrected_probability},
          {"effect", each.wilcoxon.rank_correlation}};
}

Json AgreementJson(const Agreement& each) {
  return {{"policy", each.policy},
          {"runs", each.runs.size()},
          {"regret", each.regret},
          {"replayed_regret", IntervalJson(each.replayed_regret)},
          {"regret_agrees", each.regret_agrees()},
          {"active_share", each.active_share},
          {"replayed_active_share", IntervalJson(each.replayed_active_share)},
          {"share_agrees", each.share_agrees()},
          {"measured_regret", each.measured_regret}};
}

template <typename Values, typename ToJson>
Json ListJson(const Values& values, const ToJson& to_json) {
  Json list = Json::array();
  for (const auto& value : values) list.push_back(to_json(value));
  return list;
}

Json TruthJson(const CellTruth& truth) {
  const auto arm_json = [](const ArmCost& arm) -> Json {
    return {{"arm", arm.arm}, {"mean_ns", arm.mean_ns}, {"ratio", arm.ratio}};
  };
  return {{"cell", truth.cell.label()},
          {"ranking", ListJson(truth.ranking, arm_json)},
          {"control_ratio", truth.control_ratio},
          {"headroom", truth.headroom},
          {"players", ListJson(truth.players, PlayerJson)},
          {"comparisons", ListJson(truth.comparisons, ComparisonJson)},
          {"agreements", ListJson(truth.agreements, AgreementJson)}};
}

Json OptionsJson(const ExperimentOptions& options) {
  return {{"policies", options.policies},
          {"run_count", options.run_count},
          {"window", options.window},
          {"seed", options.seed},
          {"trace_frame_count", options.trace_frame_count},
          {"replay_seed_count", options.replay_seed_count}};
}

Json SessionJson(const ExperimentSession& session) {
  return {{"command_line", session.command_line},
          {"start_utc", session.start_utc},
          {"end_utc", session.end_utc}};
}

// Returns the paper's printed values of a cell, with the keys of our own rows.
Json PaperJson(const PaperCell& cell) {
  return {{"scene", cell.scene},
          {"objects", cell.object_count},
          {"dominance", cell.dominance},
          {"interpretation", cell.interpretation},
          {"dominant", cell.dominant},
          {"dominant_runs", cell.dominant_run_count},
          {"runs", kPaperRunCount},
          {"switches", cell.switches.mean},
          {"switches_sd", cell.switches.deviation},
          {"active_percent", cell.active_percent.mean},
          {"active_percent_sd", cell.active_percent.deviation},
          {"mu", cell.posterior_mean.mean},
          {"mu_sd", cell.posterior_mean.deviation},
          {"n", cell.evidence.mean},
          {"n_sd", cell.evidence.deviation}};
}

// Returns the runs ordered by cell, so that the policies of a cell are adjacent.
Json RunsJson(const ExperimentReport& report) {
  Json runs = Json::array();
  for (const ExperimentCell& cell : report.plan.cells) {
    for (const CellSummary& summary : report.cells) {
      if (summary.cell != cell) continue;
      for (const PlayedRun& run : summary.runs) runs.push_back(RunJson(run));
    }
  }
  return runs;
}

}  // namespace

void PrintExperimentJson(const ExperimentReport& report, const std::filesystem::path& folder,
                         std::ostream& out) {
  const auto row_json = [&](const CellSummary& cell) { return RowJson(report, cell); };
  const auto cell_json = [](const ExperimentCell& cell) -> Json {
    return {{"cell", cell.label()}, {"scene", cell.scene}, {"objects", cell.object_count}};
  };
  const Json document = {{"command", "experiment"},
                         {"folder", folder.string()},
                         {"complete", report.complete()},
                         {"finished_runs", report.records.size()},
                         {"planned_runs", report.plan.runs.size()},
                         {"time_scale", report.plan.options.time_scale},
                         {"rows", ListJson(report.cells, row_json)},
                         {"own_policy", OwnPolicyName("default")},
                         {"machine", MachineJson(report.machine)},
                         {"options", OptionsJson(report.plan.options)},
                         {"sittings", ListJson(report.sessions, SessionJson)},
                         {"arms", BroadPhaseNames()},
                         {"cells", ListJson(report.plan.cells, cell_json)},
                         {"runs", RunsJson(report)},
                         {"truths", ListJson(report.truths.cells, TruthJson)},
                         {"over_cells", ListJson(report.truths.over_cells, ComparisonJson)},
                         {"over_live", ListJson(report.truths.over_live, ComparisonJson)},
                         {"paper", ListJson(PaperCells(), PaperJson)}};
  PrintJson(document, out);
}

}  // namespace sweepstake::cli
