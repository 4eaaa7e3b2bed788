// Summarizes live runs by the paper's measures (section 6.2): the dominant arm of each run, and the
// values of Tables 3 and 4 for each cell and policy. Plain values and pure functions, safe from any
// thread.
#pragma once

#include <cstdint>
#include <map>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "sweepstake/frame_sample.h"
#include "tests/laboratory/experiment/experiment_folder.h"

namespace sweepstake::cli {

// A mean, its sample standard deviation and the number of values.
struct Spread {
  double mean = 0;
  double deviation = 0;
  size_t count = 0;
};

// A period in which one arm was active.
struct ArmPeriod {
  uint32_t arm = 0;
  double from_s = 0;  // since the run began
  double to_s = 0;
  uint32_t reason = 0;  // SwitchReason of the switch that began it; 0: the run's start
};

// Returns the periods of the whole run, exploration included.
std::vector<ArmPeriod> ArmPeriods(const RunRecord& record);

struct PlayedRun {
  const RunRecord* record = nullptr;
  std::vector<double> active_shares;    // per arm, in the observation window; sum 1
  uint32_t dominant = 0;                // the arm with the largest share
  uint32_t switch_count = 0;            // executed in the window
  double posterior_mean = 0;            // μ* of the dominant arm at the end of the run
  double evidence = 0;                  // n* = α + β of the dominant arm at the end of the run
  Verdict verdict = Verdict::kUnknown;  // the verdict of the last decision that has one

  const std::string& dominant_name() const { return record->arms[dominant]; }
};

// Summarizes a run. The result keeps a pointer to `record`.
PlayedRun Summarize(const RunRecord& record);

// The figures of a row of Table 4. All but `switches` are taken over the runs in which the most
// frequent dominant arm is the dominant one.
struct CellFigures {
  Spread switches;  // after the exploration, over all runs
  Spread active_percent;
  Spread posterior_mean;  // μ* = α ÷ (α + β)
  Spread evidence;        // n* = α + β
};

// A row of the tables: all runs of one cell and policy.
struct CellSummary : CellFigures {
  ExperimentCell cell;
  std::string policy;
  std::vector<PlayedRun> runs;                              // by run number
  std::vector<std::pair<std::string, uint32_t>> dominance;  // arms with run counts, descending
  Verdict verdict = Verdict::kUnknown;                      // the most frequent verdict of the runs

  // Returns the dominance as text, such as "KDTree 3/5; AxisSweep 2/5".
  std::string DominanceText() const;
  // Returns Table 3's interpretation, derived from dominance, shares and verdicts.
  std::string Interpretation() const;
};

// Summarizes all runs in the order of the plan. Cells and policies without a finished run are left
// out. The result keeps pointers to `records`.
std::vector<CellSummary> SummarizeCells(const ExperimentPlan& plan,
                                        const std::vector<RunRecord>& records);

// A cell of the paper's grid (5 runs of 15 minutes) with its rows of Tables 3 and 4 as printed in
// section 7, for comparison with an experiment's results. The counts of its spreads are 0.
struct PaperCell : CellFigures {
  std::string_view scene;  // a value of --scene
  uint32_t object_count = 0;
  std::string_view dominance;       // Table 3's column, as "KDTree 3/5; AxisSweep 2/5"
  std::string_view interpretation;  // Table 3's column
  std::string_view dominant;        // Table 4: the most frequent dominant arm
  uint32_t dominant_run_count = 0;  // out of kPaperRunCount runs
};

inline constexpr uint32_t kPaperRunCount = 5;

// Returns the cells in the paper's order.
std::span<const PaperCell> PaperCells();

// Returns null if the paper does not have this cell.
const PaperCell* FindPaperCell(std::string_view scene, uint32_t object_count);
inline const PaperCell* PaperOf(const CellSummary& summary) {
  return FindPaperCell(summary.cell.scene, summary.cell.object_count);
}
// Returns whether μ* and n* of this row are the same quantities as in the paper. Other policies
// have another reward or count a window as another number of observations.
inline bool HasPaperPosterior(const CellSummary& summary) { return summary.policy == "paper"; }

}  // namespace sweepstake::cli
