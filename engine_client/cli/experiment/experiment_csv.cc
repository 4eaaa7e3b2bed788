#include "engine_client/cli/experiment/experiment_csv.h"

#include <functional>
#include <string>

#include "engine_client/cli/experiment/experiment_summary.h"
#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/io/csv_file.h"
#include "engine_client/cli/io/text_table.h"
#include "server/audit/cell_text.h"

namespace sweepstake::cli {
namespace {

std::string Seconds(double seconds) { return Fixed(seconds, 6); }
std::string Exact(double value) { return Fixed(value, 9); }

std::string ReasonText(uint32_t reason) {
  return reason == 0 ? "" : ReasonName(static_cast<SwitchReason>(reason));
}

// Whether the observation window was under way.
std::string Observed(const RunRecord& record, double time_s) {
  return time_s >= record.exploration_s ? "1" : "0";
}

std::string OutcomeName(uint32_t outcome) {
  std::string name;
  decision::AppendName(name, decision::kOutcomeNames, outcome);
  return name;
}

using RowWriter =
    std::function<void(const RunRecord& record, const std::string& run, CsvFile& csv)>;

Status WriteOne(std::span<const RunRecord> records, const std::filesystem::path& path,
                std::initializer_list<std::string_view> header, const RowWriter& write) {
  auto csv = CsvFile::Create(path, header);
  if (!csv.ok()) return csv.status();
  for (const RunRecord& record : records) write(record, RunLabel(record), **csv);
  return (*csv)->Commit();
}

void ActivationRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  for (const ArmPeriod& each : ArmPeriods(record)) {
    csv.Row({run, record.arms[each.arm], Seconds(each.from_s), Seconds(each.to_s),
             ReasonText(each.reason), Observed(record, each.from_s)});
  }
}

void SwitchRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  for (const RecordedSwitch& each : record.switches) {
    csv.Row({run, Seconds(each.time_s), std::to_string(each.frame), record.arms[each.from],
             record.arms[each.to], ReasonText(each.reason), Observed(record, each.time_s),
             std::to_string(each.rebuild_ns), std::to_string(each.settling_ns)});
  }
}

void DecisionRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  for (const RecordedDecision& each : record.decisions) {
    const bool known = !each.best_probability.empty();
    csv.Row({run, Seconds(each.time_s), record.arms[each.active_arm],
             each.candidate < 0 ? "" : record.arms[static_cast<size_t>(each.candidate)],
             OutcomeName(each.outcome), ReasonText(each.reason),
             each.reward < 0 ? "" : Exact(each.reward), known ? record.arms[each.leader] : "",
             known ? Exact(each.best_probability[each.leader]) : "",
             known ? Exact(each.expected_loss_ratio) : "",
             VerdictName(static_cast<Verdict>(each.verdict))});
  }
}

void PosteriorRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  for (const RecordedDecision& each : record.decisions) {
    for (size_t arm = 0; arm < record.arms.size(); ++arm) {
      csv.Row({run, Seconds(each.time_s), record.arms[arm], Exact(each.alpha[arm]),
               Exact(each.beta[arm]),
               each.best_probability.empty() ? "" : Exact(each.best_probability[arm])});
    }
  }
}

void FinalRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  const RunSummary summary = Summarize(record);
  for (size_t arm = 0; arm < record.arms.size(); ++arm) {
    const double alpha = record.decisions.empty() ? 1 : record.decisions.back().alpha[arm];
    const double beta = record.decisions.empty() ? 1 : record.decisions.back().beta[arm];
    const ArmControl& control = record.controls[arm];
    csv.Row({run, record.arms[arm], Exact(alpha), Exact(beta), Exact(alpha / (alpha + beta)),
             Exact(alpha + beta), Exact(summary.active_shares[arm]),
             arm == summary.dominant ? "1" : "0", std::to_string(record.observed[arm].frame_count),
             std::to_string(record.observed[arm].frame_ns),
             std::to_string(record.observed[arm].detection_ns), std::to_string(control.frame_count),
             Fixed(control.detection_ns_mean, 1)});
  }
}

void MetricRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  for (const MetricWindow& each : record.windows) {
    csv.Row({run, Seconds(each.time_s), record.arms[each.arm], std::to_string(each.frame_count),
             Fixed(each.frame_us_mean, 3), Fixed(each.frame_us_max, 3),
             Fixed(each.detection_us_mean, 3), Fixed(each.check_count_mean, 1),
             Fixed(each.pair_count_mean, 1), std::to_string(each.native_bytes_max),
             std::to_string(each.object_count)});
  }
}

void TimeRows(const RunRecord& record, const std::string& run, CsvFile& csv) {
  const TimeShares& time = record.time;
  csv.Row({run, record.start_utc, Seconds(record.exploration_s), Seconds(record.end_s),
           std::to_string(time.scene_step_ns), std::to_string(time.detection_ns),
           std::to_string(time.rebuild_ns), std::to_string(time.copying_ns),
           std::to_string(time.around_ns), std::to_string(time.frame_end_ns),
           std::to_string(time.intake_ns), std::to_string(time.decision_ns),
           std::to_string(time.longest_decision_ns), std::to_string(time.lane_ns),
           std::to_string(record.shadow_visit_count), std::to_string(record.warm_switch_count),
           std::to_string(record.decisions.size()), std::to_string(record.dropped_frame_count)});
}

}  // namespace

Status WriteRawCsv(std::span<const RunRecord> records, const std::filesystem::path& folder) {
  const struct {
    const char* name;
    std::initializer_list<std::string_view> header;
    RowWriter write;
  } files[] = {
      {"activations.csv", {"run", "arm", "from_s", "to_s", "reason", "observed"}, ActivationRows},
      {"switches.csv",
       {"run", "time_s", "frame", "from", "to", "reason", "observed", "rebuild_ns", "settling_ns"},
       SwitchRows},
      {"decisions.csv",
       {"run", "time_s", "active", "candidate", "outcome", "reason", "reward", "leader",
        "leader_best_probability", "expected_loss_ratio", "verdict"},
       DecisionRows},
      {"posteriors.csv",
       {"run", "time_s", "arm", "alpha", "beta", "best_probability"},
       PosteriorRows},
      {"final.csv",
       {"run", "arm", "alpha", "beta", "mu", "n", "active_share", "dominant", "observed_frames",
        "observed_frame_ns", "observed_detection_ns", "control_frames", "control_detection_ns"},
       FinalRows},
      {"metrics.csv",
       {"run", "time_s", "arm", "frames", "frame_us_mean", "frame_us_max", "detection_us_mean",
        "aabb_checks_mean", "pairs_mean", "native_bytes_max", "objects"},
       MetricRows},
      {"time.csv",
       {"run", "start_utc", "exploration_s", "end_s", "scene_step_ns", "detection_ns", "rebuild_ns",
        "copying_ns", "around_ns", "frame_end_ns", "intake_ns", "decision_ns",
        "longest_decision_ns", "lane_ns", "shadow_visits", "warm_switches", "decisions",
        "dropped_frames"},
       TimeRows},
  };
  for (const auto& file : files) {
    if (Status status = WriteOne(records, folder / file.name, file.header, file.write);
        !status.ok()) {
      return status;
    }
  }
  return {};
}

}  // namespace sweepstake::cli
