#include "tests/laboratory/replay/replay_output.h"

#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/numbers.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/session/policy_registry.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

const std::string& ArmName(const ReplayReport& report, uint32_t scene, uint32_t arm) {
  return report.scenes[scene].scene.arms()[arm];
}

Json VerdictsJson(const std::vector<double>& shares) {
  Json json = Json::object();
  for (size_t i = 0; i < shares.size(); ++i)
    json[std::string(decision::kVerdictNames[i])] = shares[i];
  return json;
}

// Returns the ranges of probability that contain decisions.
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
                             {"wilcoxon_p", row.against_paper->probability}};
  }
  return json;
}

// Formats a number with its sign, as "+1.23". Values that round to 0 get a plus.
std::string Signed(double value, int decimals) {
  const std::string text = Fixed(value, decimals);
  if (!text.starts_with('-')) return '+' + text;
  const bool is_zero = text.find_first_of("123456789") == std::string::npos;
  return is_zero ? '+' + text.substr(1) : text;
}

// Formats a ratio as "+1.23%".
std::string SignedPercent(double ratio, int decimals = 2) {
  return Signed(100 * ratio, decimals) + '%';
}

std::string IntervalText(const Interval& interval) {
  return SignedPercent(interval.low) + " to " + SignedPercent(interval.high);
}

std::string AgainstPaperText(const StudyRow& row) {
  if (!row.against_paper) return "-";
  return SignedPercent(row.against_paper->difference) + " (" +
         IntervalText(row.against_paper->ci95) + ")";
}

std::string SceneTitle(const StudyScene& scene, const StudyRow& first_row) {
  return scene.name + ": noise floor " + SignedPercent(std::abs(scene.scene.control_regret())) +
         ", headroom " + SignedPercent(first_row.headroom) + " with switches paid, " +
         SignedPercent(first_row.frame_headroom) + " frame by frame";
}

void PrintRegret(const ReplayReport& report, std::ostream& out) {
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
  out << "\nRegret: frame time relative to the best fixed arm on the same frames, mean of "
      << report.options.seed_count
      << " seeds with its 95 % interval;\nafter_start leaves out the first minute and the "
         "exploration; vs_oracle: against the best\nsequence of arms that pays for its switches; "
         "captured: of that oracle's gain over the\nbest fixed arm; share: of the dominant arm's "
         "time. Noise floor: the same arm measured twice.\n";
}

std::string SignedMs(double ms) { return Signed(ms, 4); }

std::string MsTitle(const StudyScene& scene, const FrameMs& ms) {
  return scene.name + ": " + GroupedWhole(scene.scene.mean_object_count()) +
         " objects, best fixed arm " + Fixed(ms.best, 4) + " ms, median " + Fixed(ms.median, 4) +
         ", worst " + Fixed(ms.worst, 4);
}

void PrintMs(const ReplayReport& report, std::ostream& out) {
  out << "\nMilliseconds per frame as recorded\n\n";
  TextTable table({"policy", "detection", "regret", "of_detection", "of_60hz", "vs_worst",
                   "vs_median", "vs_paper", "lane"});
  const StudyRow* before = nullptr;
  for (const StudyRow& row : report.rows) {
    if (before == nullptr || before->scene != row.scene) {
      table.AddTitle(MsTitle(report.scenes[row.scene], row.ms));
    }
    before = &row;
    const double ms = row.ms.detection;
    table.AddRow({report.options.players[row.player].name, Fixed(ms, 4), SignedMs(row.ms.regret()),
                  SignedPercent(row.ms.regret_ratio()),
                  SignedPercent(row.ms.regret() / kFrameMsAt60Hz, 3), SignedMs(ms - row.ms.worst),
                  SignedMs(ms - row.ms.median), row.paper_ms ? SignedMs(ms - *row.paper_ms) : "-",
                  Fixed(row.ms.lane, 4)});
  }
  table.Print(out);
  out << "\nof_detection, of_60hz: the regret as a share of the best fixed arm's detection, and of "
         "the\n16.67 ms of a frame at 60 Hz; vs: the difference to the worst and the median fixed "
         "arm, and to\nthe policy paper, negative is better; lane: CPU time of the shadow lane on "
         "another core.\n";
}

// Returns the reliability over all scenes for each policy that reports P(best).
std::vector<std::pair<std::string, Reliability>> ReliabilityOfPolicies(const ReplayReport& report) {
  std::vector<std::pair<std::string, Reliability>> policies;
  for (uint32_t player = 0; player < report.options.players.size(); ++player) {
    Reliability sum;
    for (const StudyRow& row : report.rows)
      if (row.player == player) sum += row.reliability;
    if (sum.decision_count() > 0) policies.push_back({report.options.players[player].name, sum});
  }
  return policies;
}

std::vector<std::string> ReliabilityHeader() {
  std::vector<std::string> header{"policy"};
  for (size_t i = 0; i < Reliability::kBinCount; ++i)
    header.push_back(Fixed(Reliability::kEdges[i], 2) + "-" + Fixed(Reliability::kEdges[i + 1], 2));
  header.push_back("error");
  return header;
}

void PrintReliability(const ReplayReport& report, std::ostream& out) {
  const auto policies = ReliabilityOfPolicies(report);
  if (policies.empty()) return;
  out << "\nShare of decisions in which the leader was the fastest arm, by range of its "
         "P(best)\n\n";
  TextTable table(ReliabilityHeader());
  for (const auto& [policy, reliability] : policies) {
    std::vector<std::string> cells{policy};
    for (const ReliabilityBin& bin : reliability.bins()) {
      const auto count = static_cast<double>(bin.decision_count);
      cells.push_back(bin.decision_count == 0
                          ? "-"
                          : Fixed(100 * static_cast<double>(bin.best_count) / count, 0) + "% (" +
                                Grouped(bin.decision_count) + ")");
    }
    cells.push_back(Fixed(reliability.error(), 3));
    table.AddRow(std::move(cells));
  }
  table.Print(out);
  out << "\nJudged by the frames since the previous decision. In brackets: number of decisions. "
         "error: mean\ndifference between P(best) and that share.\n";
}

}  // namespace

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
  PrintRegret(report, out);
  PrintMs(report, out);
  PrintReliability(report, out);
}

void PrintReplayJson(const ReplayReport& report, std::ostream& out) {
  Json document = {
      {"command", "replay"},
      {"seeds", report.options.seed_count},
      {"own_policy", decision::PolicyKindOf("default", decision::ShippedPolicies()).name},
      {"scenes", Json::array()},
      {"rows", Json::array()}};
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

Result<std::unique_ptr<CsvFile>> CreateReplayCsv(const std::string& path) {
  return CsvFile::Create(
      path, {"costs", "policy", "seed", "regret_best_fixed", "regret_oracle", "regret_after_start",
             "headroom", "switches", "active_share", "dominant", "bail_outs", "first_best_s"});
}

void WriteReplayCsv(const ReplayReport& report, CsvFile& csv) {
  for (const StudyRow& row : report.rows) {
    for (size_t i = 0; i < row.games.size(); ++i) {
      const StudyGame& game = row.games[i];
      csv.Row({report.scenes[row.scene].name, report.options.players[row.player].name,
               std::to_string(i + 1), Fixed(game.regret_best_fixed, 9),
               Fixed(game.regret_oracle, 9),
               game.regret_after_start_up ? Fixed(*game.regret_after_start_up, 9) : "",
               Fixed(game.headroom, 9), std::to_string(game.switch_count),
               Fixed(game.active_share, 9), ArmName(report, row.scene, game.dominant_arm),
               game.bail_out_count ? std::to_string(*game.bail_out_count) : "",
               game.first_best_s ? Fixed(*game.first_best_s, 3) : ""});
    }
  }
}

}  // namespace sweepstake::cli
