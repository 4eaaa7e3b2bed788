#include "tests/laboratory/experiment/experiment_output.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <nlohmann/json.hpp>
#include <span>
#include <utility>

#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/cli/io/whole_file.h"
#include "engine_client/decider/types.h"
#include "engine_client/text/counts.h"
#include "engine_client/text/csv.h"
#include "sweepstake/broad_phase.h"
#include "tests/laboratory/replay/replay_output.h"

namespace sweepstake::cli {
namespace {

namespace fs = std::filesystem;
// A chart of a run's posteriors is about 200 pixels wide, so more points would not be visible.
constexpr size_t kMaxPosteriorPoints = 50;

template <typename Values, typename ToJson>
Json ListJson(const Values& values, const ToJson& to_json) {
  Json list = Json::array();
  for (const auto& value : values) list.push_back(to_json(value));
  return list;
}

std::string ReasonText(uint32_t reason) {
  return reason == 0 ? "" : ReasonName(static_cast<SwitchReason>(reason));
}

Json FiguresJson(const CellFigures& cell) {
  return {{"switches", cell.switches.mean},
          {"switches_sd", cell.switches.deviation},
          {"active_percent", cell.active_percent.mean},
          {"active_percent_sd", cell.active_percent.deviation},
          {"mu", cell.posterior_mean.mean},
          {"mu_sd", cell.posterior_mean.deviation},
          {"n", cell.evidence.mean},
          {"n_sd", cell.evidence.deviation}};
}

// Returns the row of a cell and policy as a flat object, apart from the list of dominant arms.
Json RowJson(const ExperimentReport& report, const CellSummary& cell) {
  Json row = {{"policy", cell.policy},
              {"scene", cell.cell.scene},
              {"objects", cell.cell.object_count},
              {"runs", cell.runs.size()},
              {"dominance", cell.DominanceText()},
              {"dominant", cell.dominance.front().first},
              {"verdict", VerdictName(cell.verdict)}};
  row.update(FiguresJson(cell));
  row.update({{"cell", cell.cell.label()},
              {"own_policy", OwnPolicyName(cell.policy)},
              {"interpretation", cell.Interpretation()},
              {"dominant_runs", ListJson(cell.dominance, [](const auto& dominant) -> Json {
                 return {{"arm", dominant.first}, {"runs", dominant.second}};
               })}});
  const CellTruth* const truth = report.truths.Of(cell.cell);
  if (truth == nullptr) return row;
  row["truly_fastest"] = truth->ranking.front().arm;
  for (const ReplayedPlayer& player : truth->players) {
    if (player.name == row["own_policy"]) row["replay_regret"] = player.row.regret_best_fixed;
  }
  return row;
}

// Returns the paper's printed values of a cell, with the keys of our own rows.
Json PaperJson(const PaperCell& cell) {
  Json row = {{"scene", cell.scene},         {"objects", cell.object_count},
              {"dominance", cell.dominance}, {"interpretation", cell.interpretation},
              {"dominant", cell.dominant},   {"dominant_runs", cell.dominant_run_count},
              {"runs", kPaperRunCount}};
  row.update(FiguresJson(cell));
  return row;
}

// Returns whether the policy chose another arm but was not allowed to switch.
bool IsHeldBack(const RecordedDecision& decision) {
  const auto outcome = static_cast<DecisionOutcome>(decision.outcome);
  return decision.candidate >= 0 && decision.candidate != decision.active_arm &&
         outcome != DecisionOutcome::kSwitched && outcome != DecisionOutcome::kExploring;
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

Json RunJson(const PlayedRun& run) {
  const RunRecord& record = *run.record;
  Json json = {{"cell", record.cell.label()},
               {"policy", record.policy},
               {"run", record.run},
               {"scene_seed", record.scene_seed},
               {"arms", record.arms},
               {"exploration_s", record.exploration_s},
               {"end_s", record.end_s},
               {"time_scale", record.time_scale},
               {"dominant", run.dominant_name()},
               {"active_shares", run.active_shares},
               {"periods", ListJson(ArmPeriods(record),
                                    [](const ArmPeriod& period) -> Json {
                                      return {{"arm", period.arm},
                                              {"from_s", period.from_s},
                                              {"to_s", period.to_s},
                                              {"reason", ReasonText(period.reason)}};
                                    })},
               {"held_back_s", Json::array()},
               {"bail_outs", Json::array()},
               {"posteriors", PosteriorsJson(record)},
               {"verdicts", Json::object()},
               {"time", nlohmann::json(record.time)},
               {"decisions", record.decisions.size()},
               {"dropped_frames", record.dropped_frame_count}};
  std::map<uint32_t, uint64_t> verdicts;
  for (const RecordedDecision& decision : record.decisions) {
    if (IsHeldBack(decision)) json["held_back_s"].push_back(decision.time_s);
    if (decision.time_s >= record.exploration_s) ++verdicts[decision.verdict];
  }
  for (const RecordedSwitch& each : record.switches) {
    if (each.reason != static_cast<uint32_t>(SwitchReason::kBailOut)) continue;
    json["bail_outs"].push_back({{"time_s", each.time_s}, {"arm", each.from}});
  }
  for (const auto& [verdict, count] : verdicts) {
    json["verdicts"][VerdictName(static_cast<Verdict>(verdict))] = count;
  }
  return json;
}

Json RankedJson(const ArmCost& arm) {
  return {{"arm", arm.arm}, {"mean_ns", arm.mean_ns}, {"ratio", arm.ratio}};
}

Json PlayerJson(const ReplayedPlayer& player) {
  const StudyRow& row = player.row;
  return {{"name", player.name},
          {"is_policy", player.is_policy},
          {"regret", row.regret_best_fixed},
          {"ci95", IntervalJson(row.ci95)},
          {"after_start_up", OrNull(row.regret_after_start_up)},
          {"switches", row.switches},
          {"active_share", row.active_share},
          {"regret_detection", row.ms.regret_ratio()},
          {"regret_60hz", row.ms.regret() / kFrameMsAt60Hz},
          {"ms_per_frame", FrameMsJson(row.ms, row.paper_ms)}};
}

Json ComparisonJson(const PairedComparison& each) {
  return {{"policy", each.policy},
          {"baseline", each.baseline},
          {"pairs", each.wilcoxon.pair_count},
          {"difference", each.difference},
          {"ci95", IntervalJson(each.ci95)},
          {"p", each.wilcoxon.probability},
          {"p_corrected", each.corrected_probability},
          {"p_smallest", each.wilcoxon.smallest_probability},
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

Json WorthJson(const Worth& worth) {
  return {{"best_arm", worth.best_arm},     {"best_ms", worth.best_ms},
          {"always_ms", worth.always_ms},   {"oracle_ms", worth.oracle_ms},
          {"decided_ms", worth.decided_ms}, {"nothing", worth.is_nothing()}};
}

Json TruthJson(const CellTruth& truth) {
  return {{"cell", truth.cell.label()},
          {"scenes", truth.scene_count},
          {"ranking", ListJson(truth.ranking, RankedJson)},
          {"control_ratio", truth.control_ratio},
          {"headroom", truth.headroom},
          {"worth", truth.worth ? WorthJson(*truth.worth) : Json()},
          {"players", ListJson(truth.players, PlayerJson)},
          {"comparisons", ListJson(truth.comparisons, ComparisonJson)},
          {"agreements", ListJson(truth.agreements, AgreementJson)}};
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

// Appends the members of an object as cells: their names if `names` is true, else their values. A
// list of two numbers is an interval and gives the cells `NAME_low` and `NAME_high`. Other lists
// are left out.
void AppendCells(const Json& row, bool names, std::string& line) {
  const auto append = [&](const std::string& name, const Json& value) {
    if (!line.empty()) line += ',';
    const std::string text = value.is_string() ? value.get<std::string>()
                             : value.is_null() ? ""
                                               : value.dump();
    text::AppendCsv(line, names ? name : text);
  };
  for (const auto& [name, value] : row.items()) {
    if (!value.is_array()) {
      append(name, value);
    } else if (value.size() == 2 && value[0].is_number()) {
      append(name + "_low", value[0]);
      append(name + "_high", value[1]);
    }
  }
}

// Writes a CSV file from objects with the same members, which `rows_of` returns for each group.
template <typename Groups, typename RowsOf>
Status WriteCsv(const fs::path& path, const Groups& groups, const RowsOf& rows_of) {
  auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  bool has_header = false;
  for (const auto& group : groups) {
    for (const Json& row : rows_of(group)) {
      for (const bool names : {true, false}) {
        if (names && std::exchange(has_header, true)) continue;
        std::string line;
        AppendCells(row, names, line);
        (*file)->Write(line + "\r\n");
      }
    }
  }
  return (*file)->Commit();
}

// Returns a copy of the object `row` with one more member at the front.
Json With(const char* name, const std::string& value, const Json& row) {
  Json all = {{name, value}};
  all.update(row);
  return all;
}

// Returns 1 if the observation window has begun at this time, else 0.
int Observed(const RunRecord& record, double time_s) {
  return time_s >= record.exploration_s ? 1 : 0;
}

Json ActivationRows(const RunRecord& record) {
  return ListJson(ArmPeriods(record), [&](const ArmPeriod& each) -> Json {
    return {{"arm", record.arms[each.arm]},
            {"from_s", each.from_s},
            {"to_s", each.to_s},
            {"reason", ReasonText(each.reason)},
            {"observed", Observed(record, each.from_s)}};
  });
}

Json SwitchRows(const RunRecord& record) {
  return ListJson(record.switches, [&](const RecordedSwitch& each) -> Json {
    return {{"time_s", each.time_s},
            {"frame", each.frame},
            {"from", record.arms[each.from]},
            {"to", record.arms[each.to]},
            {"reason", ReasonText(each.reason)},
            {"observed", Observed(record, each.time_s)},
            {"rebuild_ns", each.rebuild_ns},
            {"settling_ns", each.settling_ns}};
  });
}

Json DecisionRows(const RunRecord& record) {
  return ListJson(record.decisions, [&](const RecordedDecision& each) -> Json {
    const bool known = !each.best_probability.empty();
    const auto if_known = [&](const auto& value) { return known ? Json(value) : Json(); };
    return {
        {"time_s", each.time_s},
        {"active", record.arms[each.active_arm]},
        {"candidate", each.candidate < 0 ? "" : record.arms[static_cast<size_t>(each.candidate)]},
        {"outcome", decision::NameOf(decision::kOutcomeNames, each.outcome)},
        {"reason", ReasonText(each.reason)},
        {"reward", each.reward < 0 ? Json() : Json(each.reward)},
        {"leader", if_known(record.arms[each.leader])},
        {"leader_best_probability", known ? Json(each.best_probability[each.leader]) : Json()},
        {"expected_loss_ratio", if_known(each.expected_loss_ratio)},
        {"verdict", VerdictName(static_cast<Verdict>(each.verdict))}};
  });
}

Json PosteriorRows(const RunRecord& record) {
  Json rows = Json::array();
  for (const RecordedDecision& each : record.decisions) {
    for (size_t arm = 0; arm < record.arms.size(); ++arm) {
      const bool known = !each.best_probability.empty();
      rows.push_back({{"time_s", each.time_s},
                      {"arm", record.arms[arm]},
                      {"alpha", each.alpha[arm]},
                      {"beta", each.beta[arm]},
                      {"best_probability", known ? Json(each.best_probability[arm]) : Json()}});
    }
  }
  return rows;
}

Json FinalRows(const RunRecord& record) {
  const PlayedRun summary = Summarize(record);
  Json rows = Json::array();
  for (size_t arm = 0; arm < record.arms.size(); ++arm) {
    const double alpha = record.decisions.empty() ? 1 : record.decisions.back().alpha[arm];
    const double beta = record.decisions.empty() ? 1 : record.decisions.back().beta[arm];
    rows.push_back({{"arm", record.arms[arm]},
                    {"alpha", alpha},
                    {"beta", beta},
                    {"mu", alpha / (alpha + beta)},
                    {"n", alpha + beta},
                    {"active_share", summary.active_shares[arm]},
                    {"dominant", arm == summary.dominant ? 1 : 0},
                    {"observed_frames", record.observed[arm].frame_count},
                    {"observed_frame_ns", record.observed[arm].active_ns},
                    {"observed_detection_ns", record.observed[arm].detection_ns},
                    {"control_frames", record.controls[arm].frame_count},
                    {"control_detection_ns", record.controls[arm].detection_ns}});
  }
  return rows;
}

Json MetricRows(const RunRecord& record) {
  return ListJson(record.windows, [&](const MetricWindow& each) -> Json {
    return {{"time_s", each.time_s},
            {"arm", record.arms[each.arm]},
            {"frames", each.frame_count},
            {"frame_us_mean", each.frame_us_mean},
            {"frame_us_max", each.frame_us_max},
            {"detection_us_mean", each.detection_us_mean},
            {"aabb_checks_mean", each.check_count_mean},
            {"pairs_mean", each.pair_count_mean},
            {"native_bytes_max", each.native_bytes_max},
            {"objects", each.object_count}};
  });
}

Json TimeRows(const RunRecord& record) {
  Json row = {{"scene_seed", record.scene_seed},
              {"decision_seed", record.seed},
              {"start_utc", record.start_utc},
              {"exploration_s", record.exploration_s},
              {"end_s", record.end_s}};
  row.update(nlohmann::json(record.time));
  row.update({{"shadow_visits", record.shadow_visit_count},
              {"warm_switches", record.warm_switch_count},
              {"decisions", record.decisions.size()},
              {"dropped_frames", record.dropped_frame_count}});
  return Json::array({row});
}

Status WriteRunCsv(std::span<const RunRecord> records, const fs::path& folder) {
  const std::pair<const char*, Json (*)(const RunRecord&)> files[] = {
      {"activations.csv", ActivationRows},
      {"switches.csv", SwitchRows},
      {"decisions.csv", DecisionRows},
      {"posteriors.csv", PosteriorRows},
      {"final.csv", FinalRows},
      {"metrics.csv", MetricRows},
      {"time.csv", TimeRows}};
  for (const auto& [name, rows_of] : files) {
    const auto of_run = [rows = rows_of](const RunRecord& record) {
      return ListJson(rows(record),
                      [&](const Json& row) { return With("run", record.label(), row); });
    };
    if (Status status = WriteCsv(folder / name, records, of_run); !status.ok()) return status;
  }
  return {};
}

Json RegretRows(const CellTruth& truth) {
  Json rows = Json::array();
  for (const ReplayedPlayer& player : truth.players) {
    const size_t games_per_scene = player.row.games.size() / player.scene_regrets.size();
    for (size_t i = 0; i < player.row.games.size(); ++i) {
      rows.push_back({{"player", player.name},
                      {"scene", i / games_per_scene + 1},
                      {"seed", i % games_per_scene + 1},
                      {"regret", player.row.games[i].regret_best_fixed}});
    }
  }
  return rows;
}

Json LiveRegretRows(const CellTruth& truth) {
  Json rows = Json::array();
  for (const Agreement& each : truth.agreements) {
    for (const LiveRegret& run : each.runs) {
      rows.push_back({{"policy", each.policy},
                      {"run", run.run},
                      {"measured_regret", run.measured},
                      {"regret_by_trace", run.by_trace},
                      {"active_share", run.active_share}});
    }
  }
  return rows;
}

Status WriteTruthCsv(const ExperimentTruths& truths, const fs::path& folder) {
  const std::pair<const char*, Json (*)(const CellTruth&)> files[] = {
      {"worth.csv",
       [](const CellTruth& truth) {
         return truth.worth ? Json::array({WorthJson(*truth.worth)}) : Json::array();
       }},
      {"ranking.csv", [](const CellTruth& truth) { return ListJson(truth.ranking, RankedJson); }},
      {"regret.csv", RegretRows},
      {"agreement.csv",
       [](const CellTruth& truth) { return ListJson(truth.agreements, AgreementJson); }},
      {"live_regret.csv", LiveRegretRows}};
  for (const auto& [name, rows_of] : files) {
    const auto of_cell = [rows = rows_of](const CellTruth& truth) {
      return ListJson(rows(truth),
                      [&](const Json& row) { return With("cell", truth.cell.label(), row); });
    };
    if (Status status = WriteCsv(folder / name, truths.cells, of_cell); !status.ok()) return status;
  }
  std::vector<std::pair<std::string, std::span<const PairedComparison>>> comparisons = {
      {"all", truths.over_cells}};
  for (const CellTruth& truth : truths.cells) {
    comparisons.emplace_back(truth.cell.label(), truth.comparisons);
  }
  return WriteCsv(folder / "comparisons.csv", comparisons, [](const auto& group) {
    return ListJson(group.second, [&](const PairedComparison& each) {
      return With("cell", group.first, ComparisonJson(each));
    });
  });
}

// Returns the rows of Tables 3 and 4 with the paper's values as `paper_…`; a value is empty if the
// paper has none of the same quantity.
Json TableRows(const ExperimentReport& report, const CellSummary& cell) {
  Json row = RowJson(report, cell);
  for (const char* by_trace : {"truly_fastest", "replay_regret"}) row.erase(by_trace);
  const PaperCell* const paper = PaperOf(cell);
  const Json printed = PaperJson(paper == nullptr ? PaperCells().front() : *paper);
  for (const auto& [name, value] : printed.items()) {
    if (name == "scene" || name == "objects") continue;
    const bool is_posterior = name.starts_with("mu") || name == "n" || name == "n_sd";
    const bool compares = paper != nullptr && (!is_posterior || HasPaperPosterior(cell));
    row["paper_" + name] = compares ? value : Json();
  }
  return Json::array({row});
}

// Returns the scene's name in the paper's tables; other scenes keep their own name.
std::string PaperSceneName(const std::string& scene) {
  if (scene == "brownian") return "Brownian";
  if (scene == "rotating-gravity") return "Rotating Grav";
  if (scene == "hurricane") return "Hurricane";
  return scene;
}

std::string PaperText(const Spread& figure, int decimals) {
  return SpreadText({figure.mean, figure.deviation, kPaperRunCount}, decimals);
}

std::string Frequency(uint32_t count, size_t of) {
  return std::to_string(count) + " / " + std::to_string(of);
}

// Returns milliseconds with three significant digits, as far as they show a thousandth.
std::string MsText(double ms) {
  return Fixed(ms, std::abs(ms) < 1 ? 3 : std::abs(ms) < 10 ? 2 : 1) + " ms";
}

std::string CellName(const ExperimentCell& cell) {
  return PaperSceneName(cell.scene) + " " + text::Grouped(cell.object_count);
}

void AddTable3Row(const CellSummary& cell, TextTable& table) {
  const PaperCell* paper = PaperOf(cell);
  table.AddRow({PaperSceneName(cell.cell.scene), text::Grouped(cell.cell.object_count),
                cell.DominanceText(), cell.Interpretation(),
                paper == nullptr ? "–" : std::string(paper->dominance)});
}

void AddTable4Rows(const CellSummary& cell, TextTable& table) {
  const auto& [dominant, count] = cell.dominance.front();
  table.AddRow({PaperSceneName(cell.cell.scene), text::Grouped(cell.cell.object_count), dominant,
                Frequency(count, cell.runs.size()), SpreadText(cell.switches, 1),
                SpreadText(cell.active_percent, 1),
                SpreadText(cell.posterior_mean, 3) + " / " + SpreadText(cell.evidence, 1)});
  const PaperCell* paper = PaperOf(cell);
  if (paper == nullptr) return;
  table.AddRow({"  paper", "", std::string(paper->dominant),
                Frequency(paper->dominant_run_count, kPaperRunCount), PaperText(paper->switches, 1),
                PaperText(paper->active_percent, 1),
                HasPaperPosterior(cell)
                    ? PaperText(paper->posterior_mean, 3) + " / " + PaperText(paper->evidence, 1)
                    : "–"});
}

void PrintTables(std::span<const CellSummary> cells, std::ostream& out) {
  TextTable table3({"Scenario", "Objects", "Dominance frequency", "Interpretation", "Paper"});
  TextTable table4({"Scenario", "Obj.", "Dominant", "Freq.", "Switches", "Active (%)", "μ* / n*"});
  std::string policy;
  for (const CellSummary& cell : cells) {
    if (std::exchange(policy, cell.policy) != cell.policy) {
      for (TextTable* const table : {&table3, &table4}) table->AddTitle("Policy " + cell.policy);
    }
    AddTable3Row(cell, table3);
    AddTable4Rows(cell, table4);
  }
  out << "\nTable 3. Dominant algorithms across the runs.\n\n"
      << table3.Text()
      << "\nTable 4. Switches over all runs; active time, posterior mean μ* and n* = α + β of the "
         "dominant arm over its runs; mean ± sample standard deviation. The paper's μ* and n* "
         "stand "
         "only below those of its own policy, because other policies measure other quantities.\n\n"
      << table4.Text();
}

}  // namespace

std::string SpreadText(const Spread& spread, int decimals) {
  const std::string mean = Fixed(spread.mean, decimals);
  return spread.count > 1 ? mean + "±" + Fixed(spread.deviation, decimals) : mean;
}

std::string WorthText(const ExperimentTruths& truths) {
  std::vector<const CellTruth*> cells;
  for (const CellTruth& truth : truths.cells) {
    if (truth.worth) cells.push_back(&truth);
  }
  if (cells.empty()) return "";
  double best_ms = 0, always_ms = 0, decided_ms = 0;
  std::string nothing;
  size_t nothing_count = 0;
  const CellTruth* most = cells.front();
  for (const CellTruth* cell : cells) {
    const Worth& worth = *cell->worth;
    const double share = 1 / static_cast<double>(cells.size());
    best_ms += share * worth.saved_to_best_ms();
    always_ms += share * worth.saved_to_always_ms();
    decided_ms += share * (worth.always_ms - worth.decided_ms);
    if (worth.saved_to_always_ms() > most->worth->saved_to_always_ms()) most = cell;
    if (!worth.is_nothing()) continue;
    ++nothing_count;
    nothing += (nothing.empty() ? "" : ", ") + CellName(cell->cell);
  }
  const std::string always = "always " + std::string(kAlwaysArm);
  std::string text = "The best sequence of algorithms saves " + MsText(always_ms) +
                     " of detection per frame against " + always + " and " + MsText(best_ms) +
                     " against the best single algorithm of each cell, on average over " +
                     text::Counted(cells.size(), "cell") + ". AI Decides " +
                     (decided_ms < 0 ? "loses " : "saves ") + MsText(std::abs(decided_ms)) +
                     " against " + always + ". ";
  if (nothing_count < cells.size()) {
    text += "Choosing is worth most in " + CellName(most->cell) + ": " +
            MsText(most->worth->saved_to_always_ms()) + " of " + MsText(most->worth->always_ms) +
            " against " + always + ". ";
  }
  if (nothing_count == 0) return text + "Choosing is worth something in every cell.";
  return text + "Choosing is worth nothing (less than " + Percent(kMinHeadroom, 1) +
         " of detection, or less than " + MsText(kMinWorthMs) + ") in " +
         std::to_string(nothing_count) + " of " + text::Counted(cells.size(), "cell") + ": " +
         nothing + ".";
}

void PrintExperiment(const ExperimentReport& report, const fs::path& folder, std::ostream& out) {
  if (!report.complete()) {
    out << "PARTIAL: " << report.records.size() << " of " << report.plan.runs.size()
        << " runs are finished; continue with --resume " << folder.string() << "\n";
  }
  if (const std::string worth = WorthText(report.truths); !worth.empty()) {
    out << '\n' << worth << '\n';
  }
  PrintTables(report.cells, out);
}

Status WriteExperimentCsv(const ExperimentReport& report, const fs::path& folder) {
  Status status = WriteCsv(folder / "tables.csv", report.cells,
                           [&](const CellSummary& cell) { return TableRows(report, cell); });
  if (status.ok()) status = WriteRunCsv(report.records, folder);
  return status.ok() ? WriteTruthCsv(report.truths, folder) : status;
}

void PrintExperimentJson(const ExperimentReport& report, const fs::path& folder,
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
                         {"options", nlohmann::json(report.plan.options)},
                         {"sittings", nlohmann::json(report.sessions)},
                         {"arms", BroadPhaseNames()},
                         {"cells", ListJson(report.plan.cells, cell_json)},
                         {"runs", RunsJson(report)},
                         {"truths", ListJson(report.truths.cells, TruthJson)},
                         {"worth_text", WorthText(report.truths)},
                         {"over_cells", ListJson(report.truths.over_cells, ComparisonJson)},
                         {"paper", ListJson(PaperCells(), PaperJson)}};
  PrintJson(document, out);
}

}  // namespace sweepstake::cli
