// The rows of a bench as its page wants them: one per contestant and cell. Borrows the report,
// which must outlive it. Immutable, safe from any thread.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

#include "engine_client/cli/bench/bench_report.h"
#include "engine_client/cli/html/chart_marks.h"

namespace sweepstake::cli {

// A row of the tables and a line of the charts: an arm or a peer, with the fewest threads it was
// run with.
struct BenchContestant {
  std::string name;
  std::string family;
  ContestantKind kind = ContestantKind::kArm;
  uint32_t thread_count = 1;
  html::SeriesStyle style;            // colour by family, ours solid
  std::vector<const BenchRow*> rows;  // by cell; null where it measured nothing
};

// Neighbouring cells of one scene.
struct SceneCells {
  std::string name;
  std::vector<size_t> cells;  // by object count
};

class BenchIndex {
 public:
  explicit BenchIndex(const BenchReport& report);

  const BenchReport& report() const { return report_; }
  const std::vector<SceneCells>& scenes() const { return scenes_; }
  // The cells of all scenes, in that order.
  const std::vector<size_t>& cells() const { return cells_; }
  // Families together, in the paper's order; ours before the peers in each.
  const std::vector<BenchContestant>& contestants() const { return contestants_; }
  // Those there are, in the paper's order.
  const std::vector<std::string>& families() const { return families_; }
  // Numbers of threads that ours were run with, ascending.
  const std::vector<uint32_t>& thread_counts() const { return thread_counts_; }
  bool has_peers() const;

  // The least median in `cell`; null when nobody measured anything.
  const BenchRow* Fastest(size_t cell) const;
  // Null when it measured nothing there.
  const BenchRow* Find(size_t cell, const std::string& name, uint32_t thread_count) const;

 private:
  void AddRow(const BenchRow& row);
  void AddThreadCount(const BenchRow& row);
  void OrderContestants();

  const BenchReport& report_;
  std::vector<SceneCells> scenes_;
  std::vector<size_t> cells_;
  std::vector<BenchContestant> contestants_;
  std::vector<std::string> families_;
  std::vector<uint32_t> thread_counts_;
};

}  // namespace sweepstake::cli
