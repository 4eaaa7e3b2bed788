#include "tests/laboratory/experiment/experiment_summary.h"

#include <algorithm>
#include <array>

#include "engine_client/cli/io/statistics.h"

namespace sweepstake::cli {
namespace {

// Above this share of the window a preference is called strong. The paper's "strong stable" cell
// has 82 %; its "stable" cells have 41 to 72 %.
constexpr double kStrongPercent = 75;

// clang-format off
constexpr std::array<PaperCell, 9> kCells{{
    {{{20.2, 0.8}, {45.5, 6.3}, {0.977, 0.007}, {196.4, 27.5}},
     "brownian", 1000, "AxisSweep 5/5", "Stable sweep-based preference.", "AxisSweep", 5},
    {{{12.2, 2.8}, {67.8, 7.0}, {0.967, 0.004}, {295.8, 32.3}},
     "brownian", 2000, "AxisSweep 5/5", "Stable sweep-based preference.", "AxisSweep", 5},
    {{{16.0, 2.1}, {52.9, 6.9}, {0.900, 0.023}, {203.0, 35.5}},
     "brownian", 3000, "KDTree 3/5; AxisSweep 2/5", "Transitional workload between sweeping and hierarchy.", "KDTree", 3},
    {{{20.0, 1.2}, {42.3, 2.9}, {0.905, 0.006}, {179.0, 13.0}},
     "rotating-gravity", 1000, "SAP 3/5; AxisSweep 2/5", "Ambiguous low-density cyclic workload.", "SAP", 3},
    {{{9.8, 1.5}, {60.4, 8.8}, {0.807, 0.113}, {164.4, 35.3}},
     "rotating-gravity", 2000, "AxisSweep 5/5", "Stable sweep-based preference under cyclic motion.", "AxisSweep", 5},
    {{{11.2, 1.5}, {44.7, 9.2}, {0.244, 0.008}, {63.6, 16.3}},
     "rotating-gravity", 3000, "KDTree 5/5", "Stable hierarchical preference under dense cyclic clustering.", "KDTree", 5},
    {{{21.0, 0.0}, {41.2, 2.2}, {0.970, 0.006}, {176.2, 9.0}},
     "hurricane", 1000, "AxisSweep 5/5", "Stable sweep-based preference.", "AxisSweep", 5},
    {{{6.6, 1.7}, {82.5, 3.9}, {0.954, 0.004}, {355.8, 21.3}},
     "hurricane", 2000, "AxisSweep 5/5", "Strong stable sweep-based preference.", "AxisSweep", 5},
    {{{8.8, 1.8}, {72.0, 6.1}, {0.831, 0.025}, {245.0, 40.7}},
     "hurricane", 3000, "KDTree 5/5", "Stable hierarchical preference at high density.", "KDTree", 5},
}};
// clang-format on

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
  return {Mean(values), SampleDeviation(values), values.size()};
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
  if (verdict == Verdict::kTie) return "; other arms are practically equal";
  if (verdict == Verdict::kAmbiguous) return "; the best arm is not known with confidence";
  return verdict == Verdict::kDegraded
             ? "; even with the best, the broad phase misses the frame-rate floor"
             : "";
}

}  // namespace

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
    const bool observed = each.time_s >= record.exploration_s && each.time_s < record.end_s;
    if (observed) ++summary.switch_count;
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

std::span<const PaperCell> PaperCells() { return kCells; }

const PaperCell* FindPaperCell(std::string_view scene, uint32_t object_count) {
  const auto cell = std::find_if(kCells.begin(), kCells.end(), [&](const PaperCell& each) {
    return each.scene == scene && each.object_count == object_count;
  });
  return cell == kCells.end() ? nullptr : &*cell;
}

}  // namespace sweepstake::cli
