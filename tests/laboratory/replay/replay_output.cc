#include "tests/laboratory/replay/replay_output.h"

#include <cmath>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/text/counts.h"
#include "tests/laboratory/policies/study_policies.h"

namespace sweepstake::cli {
namespace {

using decision::AuditDifference;
using decision::AuditReport;

const std::string& ArmName(const ReplayReport& report, uint32_t scene, uint32_t arm) {
  return report.scenes[scene].scene.arms()[arm];
}

Json VerdictsJson(const std::vector<double>& shares) {
  Json json = Json::object();
  for (size_t i = 0; i < shares.size(); ++i)
    json[std::string(decision::kVerdictNames[i])] = shares[i];
  return json;
}

// Returns the bins of the reliability table that contain decisions.
Json ReliabilityJson(const Reliability& reliability) {
  Json json = Json::array();
  for (size_t i = 0; i < Reliability::kBinCount; ++i) {
    const ReliabilityBin& bin = reliability.bins()[i];
    if (bin.decision_count == 0) continue;
    const auto count = static_cast<double>(bin.decision_count);
    json.push_back({{"low", Reliability::kEdges[i]},
                    {"high", Reliability::kEdges[i + 1]},
                    {"decisions", bin.decision_count},
                    {"predicted", bin.probability_sum / count},
                    {"best", static_cast<double>(bin.best_count) / count},
                    {"best_or_tie", static_cast<double>(bin.tie_count) / count}});
  }
  return json;
}

Json RowJson(const ReplayReport& report, const StudyRow& row) {
  Json json = {{"costs", report.scenes[row.scene].name},
               {"policy", report.options.players[row.player].name},
               {"priors", kReplayPriorsNames[static_cast<size_t>(report.options.priors)]},
               {"pass_ns", report.scenes[row.scene].scene.options().pass_ns},
               {"regret_best_fixed", row.regret_best_fixed},
               {"regrets", row.Values(&StudyGame::regret_best_fixed)},
               {"regret_oracle", row.regret_oracle},
               {"ci95", IntervalJson(row.ci95)},
               {"switches", row.switches},
               {"switches_after_start", row.after_start_up_switches},
               {"active_share", row.active_share},
               {"bail_outs", OrNull(row.bail_outs)},
               {"regret_after_start", OrNull(row.regret_after_start_up)},
               {"regret_after_start_ci95",
                row.after_start_up_ci95 ? IntervalJson(*row.after_start_up_ci95) : Json()},
               {"headroom", row.headroom},
               {"headroom_frame", row.frame_headroom},
               {"headroom_captured", OrNull(row.headroom_captured)},
               {"dominant", ArmName(report, row.scene, row.dominant_arm)},
               {"seeds", row.games.size()},
               {"first_best_s", OrNull(row.first_best_s)},
               {"first_right", OrNull(row.first_right)},
               {"regret_first_10_s", OrNull(row.opening_regret)},
               {"shadow_share", row.shadow_share},
               {"verdicts", VerdictsJson(row.verdict_shares)},
               {"regret_detection", row.ms.regret_ratio()},
               {"regret_60hz", row.ms.regret() / kFrameMsAt60Hz},
               {"ms_per_frame", FrameMsJson(row.ms, row.paper_ms)},
               {"reliability", ReliabilityJson(row.reliability)}};
  if (row.against_paper) {
    json["against_paper"] = {{"difference", row.against_paper->difference},
                             {"ci95", IntervalJson(row.against_paper->ci95)},
                             {"wilcoxon_p", row.against_paper->wilcoxon.probability}};
  }
  return json;
}

std::string AgainstPaperText(const StudyRow& row) {
  if (!row.against_paper) return "-";
  return SignedPercent(row.against_paper->difference) + " (" +
         IntervalText(row.against_paper->ci95) + ")";
}

std::string SceneTitle(const StudyScene& scene, const StudyRow& first_row) {
  return scene.name + ": noise floor " + SignedPercent(std::abs(scene.scene.control_regret())) +
         ", headroom " + SignedPercent(first_row.headroom) + " including switches, " +
         SignedPercent(first_row.frame_headroom) + " without their cost";
}

// Returns the reliability of each policy that states P(best), over all scenes.
Json CalibrationJson(const ReplayReport& report) {
  Json json = Json::array();
  for (uint32_t player = 0; player < report.options.players.size(); ++player) {
    Reliability sum;
    for (const StudyRow& row : report.rows)
      if (row.player == player) sum += row.reliability;
    if (sum.decision_count() == 0) continue;
    json.push_back({{"policy", report.options.players[player].name},
                    {"error", sum.error()},
                    {"bins", ReliabilityJson(sum)}});
  }
  return json;
}

Result<std::string> ReadLog(const std::string& path) {
  std::error_code unknown;
  std::ifstream file(path, std::ios::binary);
  if (!file || std::filesystem::is_directory(path, unknown)) {
    return Status(StatusCode::kNotFound,
                  path + " cannot be read; check the path and the permissions");
  }
  return std::string{std::istreambuf_iterator<char>(file), std::istreambuf_iterator<char>()};
}

Json DifferenceJson(const std::optional<AuditDifference>& difference) {
  if (!difference) return nullptr;
  return {{"line", difference->line},       {"session", difference->session},
          {"segment", difference->segment}, {"row", difference->row},
          {"column", difference->column},   {"message", difference->message}};
}

std::string UnderivedText(const AuditReport& report) {
  if (report.incomplete_segment_count == 0) return "";
  return text::Counted(report.underived_decision_count, "decision") + " in " +
         text::Counted(report.incomplete_segment_count, "segment") +
         " cannot be re-derived: earlier rows are missing, because the size of the log is "
         "limited or a write failed\n";
}

}  // namespace

std::string Signed(double value, int decimals) {
  const std::string text = Fixed(value, decimals);
  return text.starts_with('-') ? text : '+' + text;
}

std::string SignedPercent(double ratio, int decimals) {
  return Signed(100 * ratio, decimals) + '%';
}

std::string IntervalText(const Interval& interval) {
  return SignedPercent(interval.low) + " to " + SignedPercent(interval.high);
}

Json DecisionJson(const decision::DecisionOptions& options) {
  return {{"decision_interval_ns", options.decision_interval_ns},
          {"cooldown_ns", options.cooldown_ns},
          {"settling_ns", options.settling_ns},
          {"bail_out_ns", options.bail_out_ns},
          {"exploration_warm_up_ns", options.exploration_warm_up_ns},
          {"exploration_measure_ns", options.exploration_measure_ns},
          {"bail_out_penalty", options.bail_out_penalty},
          {"fps_floor", options.fps_floor},
          {"weights",
           {{"fps", options.weights.fps},
            {"detection", options.weights.detection},
            {"memory", options.weights.memory},
            {"checks", options.weights.checks}}}};
}

Json FrameMsJson(const FrameMs& ms, const std::optional<double>& paper) {
  return {{"detection", ms.detection},
          {"best", ms.best},
          {"median", ms.median},
          {"worst", ms.worst},
          {"paper", OrNull(paper)},
          {"regret", ms.regret()},
          {"lane", ms.lane}};
}

void PrintReplayTable(const ReplayReport& report, std::ostream& out) {
  TextTable table({"policy", "regret", "ci95", "after_start", "vs_oracle", "captured", "switches",
                   "share", "dominant", "bail_outs", "vs_paper"});
  const StudyRow* before = nullptr;
  for (const StudyRow& row : report.rows) {
    if (before == nullptr || before->scene != row.scene) {
      table.AddTitle(SceneTitle(report.scenes[row.scene], row));
    }
    before = &row;
    table.AddRow({report.options.players[row.player].name, SignedPercent(row.regret_best_fixed),
                  IntervalText(row.ci95),
                  row.regret_after_start_up ? SignedPercent(*row.regret_after_start_up) : "-",
                  SignedPercent(row.regret_oracle),
                  row.headroom_captured ? Fixed(100 * *row.headroom_captured, 0) + "%" : "-",
                  Fixed(row.switches, 1), Fixed(row.active_share, 2),
                  ArmName(report, row.scene, row.dominant_arm),
                  row.bail_outs ? Fixed(*row.bail_outs, 2) : "-", AgainstPaperText(row)});
  }
  table.Print(out);
  out << "\nRegret is frame time ÷ that of the best fixed arm on the same frames, minus 1; the "
         "table has the mean of\n"
      << report.options.seed_count
      << " seeds and its 95 % interval. after_start leaves out the first minute and the "
         "exploration. vs_oracle compares\nwith the oracle, the best sequence of arms including "
         "its switches. Headroom is the oracle's gain over the\nbest fixed arm. Column captured is "
         "the policy's gain over the best fixed arm, in percent of the\nheadroom. share is the "
         "time on the dominant arm. The noise floor is the difference of two measurements\nof one "
         "arm.\n";
}

void PrintReplayJson(const ReplayReport& report, std::ostream& out) {
  Json document = {
      {"command", "replay"},
      {"seeds", report.options.seed_count},
      {"own_policy", decision::PolicyKindOf("default", decision::ShippedPolicies()).name},
      {"decider", DecisionJson(report.options.decision)},
      {"scenes", Json::array()},
      {"rows", Json::array()},
      {"calibration", CalibrationJson(report)}};
  for (const StudyScene& each : report.scenes) {
    const GameOptions& game = each.scene.options();
    document["scenes"].push_back({{"costs", each.name},
                                  {"arms", each.scene.arms()},
                                  {"trace_frames", each.scene.trace_frame_count()},
                                  {"frames", each.scene.frame_count()},
                                  {"frame_ns", game.frame_ns},
                                  {"run_ns", game.run_ns},
                                  {"pass_ns", game.pass_ns},
                                  {"other_work_ns", game.other_work_ns},
                                  {"objects", each.scene.mean_object_count()},
                                  {"control_regret", each.scene.control_regret()}});
  }
  for (const StudyRow& row : report.rows) document["rows"].push_back(RowJson(report, row));
  PrintJson(document, out);
}

Result<AuditReport> ReplayLog(const std::string& file) {
  const auto text = ReadLog(file);
  if (!text.ok()) return text.status();
  AuditReport report = decision::RederiveCsv(*text, decision::StudyPolicies());
  if (!report.difference && report.decision_count + report.underived_decision_count == 0) {
    return Status(
        StatusCode::kInvalidArgument,
        file + " contains no decisions; `sweepstake audit list` shows the sessions that have some");
  }
  return report;
}

Json ReplayLogJson(const AuditReport& report, const std::string& file) {
  return {{"command", "replay"},
          {"log", file},
          {"sessions", report.session_count},
          {"segments", report.segment_count},
          {"rows", report.row_count},
          {"decisions", report.decision_count},
          {"incomplete_segments", report.incomplete_segment_count},
          {"underived_decisions", report.underived_decision_count},
          {"equal", !report.difference},
          {"difference", DifferenceJson(report.difference)}};
}

std::string ReplayLogText(const AuditReport& report) {
  return text::Counted(report.decision_count, "decision") + " in " +
         text::Counted(report.segment_count, "segment") + " re-derived, " +
         (report.difference
              ? "then a row differs (or another build wrote the log):\n" + report.difference->Text()
              : "all equal") +
         '\n' + UnderivedText(report);
}

}  // namespace sweepstake::cli
