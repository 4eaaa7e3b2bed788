#include "engine_client/cli/experiment/experiment_html_runs.h"

#include <algorithm>

#include "engine_client/cli/experiment/experiment_html_words.h"
#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/html/area_marks.h"
#include "engine_client/cli/html/small_multiples.h"
#include "engine_client/cli/html/timeline_chart.h"
#include "engine_client/cli/io/text_table.h"
#include "server/decision/types.h"

namespace sweepstake::cli {
namespace {

using html::Markup;

// Of each posterior's line; a panel is some 200 units wide.
constexpr size_t kPanelPoints = 50;

// In minutes as the paper counts them: before the time scale.
double Minutes(const RunRecord& record, double seconds) { return seconds * record.time_scale / 60; }

std::string MinutesText(const RunRecord& record, double seconds) {
  return Fixed(Minutes(record, seconds), 1) + " min";
}

std::string RunName(const RunSummary& run) {
  return PolicyShortName(run.record->policy) + " " + std::to_string(run.record->run);
}

bool IsHeldBack(const RecordedDecision& decision) {
  const auto outcome = static_cast<decision::Outcome>(decision.outcome);
  return decision.candidate >= 0 && decision.candidate != decision.active_arm &&
         outcome != decision::Outcome::kSwitched && outcome != decision::Outcome::kExploring;
}

html::TimelineLane LaneOf(const RunSummary& run) {
  const RunRecord& record = *run.record;
  html::TimelineLane lane{RunName(run), {}, {}, {}};
  for (const ArmPeriod& period : ArmPeriods(record)) {
    const bool exploring = period.from_s < record.exploration_s;
    std::string text = record.arms[period.arm] + " from " + MinutesText(record, period.from_s) +
                       " to " + MinutesText(record, period.to_s);
    if (period.reason != 0) {
      text += " (" + ReasonName(static_cast<SwitchReason>(period.reason)) + ")";
    }
    lane.stretches.push_back({Minutes(record, period.from_s), Minutes(record, period.to_s),
                              ArmKind(record.arms[period.arm]), text, exploring});
  }
  for (const RecordedDecision& decision : record.decisions) {
    if (IsHeldBack(decision)) lane.ticks.push_back(Minutes(record, decision.time_s));
  }
  for (const RecordedSwitch& each : record.switches) {
    if (each.reason != static_cast<uint32_t>(SwitchReason::kBailOut)) continue;
    lane.marks.push_back(
        {Minutes(record, each.time_s),
         "bail-out from " + record.arms[each.from] + " at " + MinutesText(record, each.time_s)});
  }
  return lane;
}

// The runs of a cell, of all policies.
std::vector<const RunSummary*> RunsOf(const ExperimentReport& report, const ExperimentCell& cell) {
  std::vector<const RunSummary*> runs;
  for (const CellSummary& summary : report.cells) {
    if (summary.cell != cell) continue;
    for (const RunSummary& run : summary.runs) runs.push_back(&run);
  }
  return runs;
}

html::PanelLine LineOf(const RunSummary& run, size_t arm) {
  const RunRecord& record = *run.record;
  html::PanelLine line{ArmKind(record.arms[arm]), arm == run.dominant, {}};
  const size_t count = record.decisions.size();
  const size_t step = std::max<size_t>(1, count / kPanelPoints);
  for (size_t i = 0; i < count; i += step) {
    // The last one is where the run ended.
    const RecordedDecision& decision = record.decisions[i + step < count ? i : count - 1];
    const double sum = decision.alpha[arm] + decision.beta[arm];
    line.points.push_back({Minutes(record, decision.time_s), decision.alpha[arm] / sum});
  }
  return line;
}

html::Panel PanelOf(const RunSummary& run) {
  html::Panel panel{RunName(run), ShareText(run.active_shares[run.dominant]) + " active", {}};
  for (size_t arm = 0; arm < run.record->arms.size(); ++arm)
    panel.lines.push_back(LineOf(run, arm));
  return panel;
}

}  // namespace

Markup SwitchTimelines(const ExperimentReport& report) {
  Markup charts = html::AreaLegend(ArmKinds());
  size_t number = 0;
  for (const ExperimentCell& cell : report.plan.cells) {
    html::TimelineChart chart{"timeline-" + std::to_string(++number),
                              CellName(cell),
                              "",
                              "Minutes, as the paper counts them",
                              0,
                              ArmKinds(),
                              {}};
    for (const RunSummary* run : RunsOf(report, cell)) {
      chart.lanes.push_back(LaneOf(*run));
      chart.end = std::max(chart.end, Minutes(*run->record, run->record->end_s));
    }
    if (!chart.lanes.empty()) charts += html::DrawTimelineChart(chart);
  }
  return charts;
}

Markup PosteriorPanels(const ExperimentReport& report) {
  Markup charts = html::AreaLegend(ArmKinds());
  size_t number = 0;
  for (const ExperimentCell& cell : report.plan.cells) {
    html::SmallMultiples chart{"posteriors-" + std::to_string(++number),
                               CellName(cell),
                               "Posterior mean against minutes, as the paper counts them.",
                               "minutes",
                               "posterior mean",
                               ArmKinds(),
                               {}};
    for (const RunSummary* run : RunsOf(report, cell)) chart.panels.push_back(PanelOf(*run));
    if (!chart.panels.empty()) charts += html::DrawSmallMultiples(chart);
  }
  return charts;
}

}  // namespace sweepstake::cli
