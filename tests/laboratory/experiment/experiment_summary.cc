#include "tests/laboratory/experiment/experiment_summary.h"

#include <algorithm>
#include <numeric>

#include "engine_client/cli/io/statistics.h"

namespace sweepstake::cli {
namespace {

// Above this share of the window a preference is called strong. The paper's "strong stable" cell
// has 82 %; its "stable" cells have 41 to 72 %.
constexpr double kStrongPercent = 75;

Verdict MostFrequentVerdict(const std::vector<PlayedRun>& runs) {
  std::map<Verdict, size_t> counts;
  for (const PlayedRun& run : runs) ++counts[run.verdict];
  return std::max_element(counts.begin(), counts.end(),
                          [](const auto& a, const auto& b) { return a.second < b.second; })
      ->first;
}

std::vector<std::pair<std::string, uint32_t>> Dominance(const std::vector<PlayedRun>& runs) {
  std::vector<std::pair<std::string, uint32_t>> counts;
  for (const PlayedRun& run : runs) {
    const auto known = std::find_if(counts.begin(), counts.end(), [&](const auto& each) {
      return each.first == run.dominant_name();
    });
    if (known == counts.end()) {
      counts.emplace_back(run.dominant_name(), 1);
    } else {
      ++known->second;
    }
  }
  std::stable_sort(counts.begin(), counts.end(),
                   [](const auto& a, const auto& b) { return a.second > b.second; });
  return counts;
}

template <typename Measure>
Spread SpreadOver(const std::vector<PlayedRun>& runs, Measure measure) {
  std::vector<double> values;
  values.reserve(runs.size());
  for (const PlayedRun& run : runs) values.push_back(measure(run));
  return SpreadOf(values);
}

void FillSpreads(CellSummary& summary) {
  summary.switches = SpreadOver(
      summary.runs, [](const PlayedRun& run) { return static_cast<double>(run.switch_count); });
  std::vector<PlayedRun> dominant;
  for (const PlayedRun& run : summary.runs) {
    if (run.dominant_name() == summary.dominance.front().first) dominant.push_back(run);
  }
  summary.active_percent = SpreadOver(
      dominant, [](const PlayedRun& run) { return 100 * run.active_shares[run.dominant]; });
  summary.posterior_mean =
      SpreadOver(dominant, [](const PlayedRun& run) { return run.posterior_mean; });
  summary.evidence = SpreadOver(dominant, [](const PlayedRun& run) { return run.evidence; });
}

std::string Doubt(Verdict verdict) {
  switch (verdict) {
    case Verdict::kTie:
      return "; other arms are practically equal";
    case Verdict::kAmbiguous:
      return "; the best arm is not known with confidence";
    case Verdict::kDegraded:
      return "; even the best misses the frame-rate floor";
    case Verdict::kUnknown:
    case Verdict::kStable:
      break;
  }
  return "";
}

}  // namespace

Spread SpreadOf(const std::vector<double>& values) {
  return {Mean(values), SampleDeviation(values), values.size()};
}

std::vector<ArmPeriod> ArmPeriods(const RunRecord& record) {
  std::vector<ArmPeriod> periods{{record.initial_arm, 0, record.end_s, 0}};
  for (const RecordedSwitch& each : record.switches) {
    if (each.time_s >= record.end_s) break;
    periods.back().to_s = each.time_s;
    periods.push_back({each.to, each.time_s, record.end_s, each.reason});
  }
  return periods;
}

PlayedRun Summarize(const RunRecord& record) {
  PlayedRun summary;
  summary.record = &record;
  summary.active_shares.assign(record.arms.size(), 0);
  for (const ArmPeriod& period : ArmPeriods(record)) {
    const double from_s = std::max(period.from_s, record.exploration_s);
    const double active_s = std::max(0.0, period.to_s - from_s);
    summary.active_shares[period.arm] += active_s / record.observed_s();
  }
  for (const RecordedSwitch& each : record.switches) {
    if (each.time_s < record.exploration_s || each.time_s >= record.end_s) continue;
    ++summary.switches[each.reason < summary.switches.size() ? each.reason : 0];
    ++summary.switch_count;
  }
  const auto most = std::max_element(summary.active_shares.begin(), summary.active_shares.end());
  summary.dominant = static_cast<uint32_t>(most - summary.active_shares.begin());
  if (record.decisions.empty()) return summary;
  const RecordedDecision& last = record.decisions.back();
  const double alpha = last.alpha[summary.dominant], beta = last.beta[summary.dominant];
  summary.posterior_mean = alpha / (alpha + beta);
  summary.evidence = alpha + beta;
  for (const RecordedDecision& each : record.decisions) {
    if (each.verdict != 0) summary.verdict = static_cast<Verdict>(each.verdict);
  }
  return summary;
}

std::string CellSummary::DominanceText() const {
  std::string text;
  for (const auto& [arm, count] : dominance) {
    text += (text.empty() ? "" : "; ") + arm + " " + std::to_string(count) + "/" +
            std::to_string(runs.size());
  }
  return text;
}

std::string CellSummary::Interpretation() const {
  const std::string& leader = dominance.front().first;
  if (dominance.size() > 1) {
    return "Transitional between " + leader + " and " + dominance[1].first + Doubt(verdict) + ".";
  }
  const bool strong = active_percent.mean >= kStrongPercent;
  if (verdict == Verdict::kStable) {
    return (strong ? "Strong stable preference for " : "Stable preference for ") + leader + ".";
  }
  return (strong ? "Strong preference for " : "Preference for ") + leader + Doubt(verdict) + ".";
}

std::vector<CellSummary> SummarizeCells(const ExperimentPlan& plan,
                                        const std::vector<RunRecord>& records) {
  std::vector<CellSummary> cells;
  for (const std::string& policy : plan.options.policies) {
    for (const ExperimentCell& cell : plan.cells) {
      CellSummary summary;
      summary.cell = cell;
      summary.policy = policy;
      for (const RunRecord& record : records) {
        if (record.cell == cell && record.policy == policy) {
          summary.runs.push_back(Summarize(record));
        }
      }
      if (summary.runs.empty()) continue;
      summary.dominance = Dominance(summary.runs);
      summary.verdict = MostFrequentVerdict(summary.runs);
      FillSpreads(summary);
      cells.push_back(std::move(summary));
    }
  }
  return cells;
}

}  // namespace sweepstake::cli
