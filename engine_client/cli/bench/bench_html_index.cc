#include "engine_client/cli/bench/bench_html_index.h"

#include <algorithm>
#include <tuple>

#include "sweepstake/broad_phase.h"

namespace sweepstake::cli {
namespace {

// The place in the paper's order; families that it does not know come last.
size_t FamilyRank(const std::string& family) {
  const auto known = BroadPhaseNames();
  return static_cast<size_t>(std::find(known.begin(), known.end(), family) - known.begin());
}

std::vector<SceneCells> SceneRuns(const BenchReport& report) {
  std::vector<SceneCells> scenes;
  for (size_t i = 0; i < report.cells.size(); ++i) {
    const std::string& name = report.cells[i].scene;
    if (scenes.empty() || scenes.back().name != name) scenes.push_back({name, {}});
    scenes.back().cells.push_back(i);
  }
  for (SceneCells& scene : scenes) {
    std::stable_sort(scene.cells.begin(), scene.cells.end(), [&](size_t a, size_t b) {
      return report.cells[a].object_count < report.cells[b].object_count;
    });
  }
  return scenes;
}

}  // namespace

BenchIndex::BenchIndex(const BenchReport& report) : report_(report), scenes_(SceneRuns(report)) {
  for (const SceneCells& scene : scenes_) {
    cells_.insert(cells_.end(), scene.cells.begin(), scene.cells.end());
  }
  for (const BenchRow& row : report.rows) {
    if (row.frame_count == 0) continue;
    AddRow(row);
    AddThreadCount(row);
  }
  std::sort(thread_counts_.begin(), thread_counts_.end());
  OrderContestants();
}

void BenchIndex::AddRow(const BenchRow& row) {
  auto known =
      std::find_if(contestants_.begin(), contestants_.end(), [&](const BenchContestant& other) {
        return other.name == row.name && other.kind == row.kind && other.family == row.family;
      });
  if (known == contestants_.end()) {
    contestants_.push_back({row.name, row.family, row.kind, row.thread_count, {}, {}});
    known = contestants_.end() - 1;
  }
  if (known->rows.empty() || row.thread_count < known->thread_count) {
    known->thread_count = row.thread_count;
    known->rows.assign(report_.cells.size(), nullptr);
  }
  if (row.thread_count == known->thread_count) known->rows[row.cell] = &row;
}

void BenchIndex::AddThreadCount(const BenchRow& row) {
  if (row.kind != ContestantKind::kArm) return;
  const auto end = thread_counts_.end();
  if (std::find(thread_counts_.begin(), end, row.thread_count) == end) {
    thread_counts_.push_back(row.thread_count);
  }
}

void BenchIndex::OrderContestants() {
  std::stable_sort(contestants_.begin(), contestants_.end(),
                   [](const BenchContestant& a, const BenchContestant& b) {
                     const size_t rank_a = FamilyRank(a.family), rank_b = FamilyRank(b.family);
                     return std::tie(rank_a, a.family, a.kind) < std::tie(rank_b, b.family, b.kind);
                   });
  for (BenchContestant& contestant : contestants_) {
    contestant.style = {FamilyRank(contestant.family), contestant.kind == ContestantKind::kArm};
    if (families_.empty() || families_.back() != contestant.family) {
      families_.push_back(contestant.family);
    }
  }
}

bool BenchIndex::has_peers() const {
  return std::any_of(contestants_.begin(), contestants_.end(), [](const BenchContestant& each) {
    return each.kind == ContestantKind::kPeer;
  });
}

const BenchRow* BenchIndex::Fastest(size_t cell) const {
  const BenchRow* fastest = nullptr;
  for (const BenchContestant& contestant : contestants_) {
    const BenchRow* row = contestant.rows[cell];
    if (row != nullptr && (fastest == nullptr || row->ms_median < fastest->ms_median)) {
      fastest = row;
    }
  }
  return fastest;
}

const BenchRow* BenchIndex::Find(size_t cell, const std::string& name,
                                 uint32_t thread_count) const {
  for (const BenchRow& row : report_.rows) {
    if (row.cell == cell && row.name == name && row.thread_count == thread_count &&
        row.frame_count > 0) {
      return &row;
    }
  }
  return nullptr;
}

}  // namespace sweepstake::cli
