#include "tests/laboratory/bench/bench_report.h"

#include <algorithm>
#include <map>
#include <memory>

#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/cli/io/statistics.h"
#include "engine_client/cli/io/text_table.h"
#include "sweepstake/simd.h"
#include "tests/laboratory/bench/scene_timing.h"
#include "tests/laboratory/peers/peer.h"

namespace sweepstake::cli {
namespace {

// The thread pools of a run, one per thread count above 1.
class ThreadPools {
 public:
  explicit ThreadPools(const std::vector<uint32_t>& thread_counts) {
    for (const uint32_t count : thread_counts) {
      if (count > 1 && !pools_.contains(count)) pools_[count] = MakeThreadPool(count);
    }
  }
  Executor* Of(uint32_t thread_count) const {
    const auto pool = pools_.find(thread_count);
    return pool == pools_.end() ? nullptr : pool->second.get();
  }

 private:
  std::map<uint32_t, std::unique_ptr<Executor>> pools_;
};

// Runs one cell of the bench: all contestants on one scene with one object count. Row i holds the
// result of contestant i.
class CellRun {
 public:
  CellRun(BenchReport& report, const ThreadPools& pools) : report_(report), pools_(pools) {}

  void AddArm(const std::string& name, const std::string& simd, uint32_t thread_count) {
    rows_.push_back(NewRow(ContestantKind::kArm, name, name, thread_count));
    rows_.back().simd = simd;
    Executor* const executor = pools_.Of(thread_count);
    auto arm = MakeBroadPhase(name, {.executor = executor});
    contestants_.push_back({.broad_phase = std::move(*arm), .executor = executor, .simd = simd});
  }

  void AddPeer(const PeerKind& peer, uint32_t thread_count) {
    BenchRow row = NewRow(ContestantKind::kPeer, std::string(peer.family), std::string(peer.name),
                          thread_count);
    row.note = WhyLeftOut(peer, row);
    if (!row.note.empty()) {
      left_out_.push_back(std::move(row));
      return;
    }
    rows_.push_back(std::move(row));
    contestants_.push_back({.broad_phase = peer.make(peer.name, thread_count),
                            .cap_s = report_.options.peer_cap_s,
                            .valid_boxes_only = true});
  }

  void Measure(Scene& scene, const std::function<void(const std::string& name)>& on_step) {
    const BenchOptions& options = report_.options;
    auto timings = TimeScene(scene, contestants_, {options.warmup, options.frames, options.cold},
                             [&](size_t index, uint64_t) { on_step(rows_[index].name); });
    for (size_t i = 0; i < rows_.size(); ++i) {
      FillRow(timings[i], rows_[i]);
      rows_[i].difference = DifferenceFrom(timings.front(), timings[i]);
    }
    rows_.insert(rows_.end(), left_out_.begin(), left_out_.end());
    SortByFamily();
    report_.rows.insert(report_.rows.end(), rows_.begin(), rows_.end());
  }

  size_t size() const { return rows_.size(); }

 private:
  BenchRow NewRow(ContestantKind kind, std::string family, std::string name,
                  uint32_t thread_count) const {
    BenchRow row;
    row.cell = report_.cells.size() - 1;
    row.kind = kind;
    row.family = std::move(family);
    row.name = std::move(name);
    row.thread_count = thread_count;
    return row;
  }

  // Returns why the peer is not run in this cell: the scene is too large for it, or it was too slow
  // at a smaller object count. Returns an empty text if the peer is run.
  std::string WhyLeftOut(const PeerKind& peer, const BenchRow& row) const {
    const BenchCell& cell = report_.cells.back();
    if (cell.object_count > peer.max_object_count) {
      return "accepts at most " + std::to_string(peer.max_object_count) + " objects";
    }
    for (const BenchRow& before : report_.rows) {
      const BenchCell& smaller = report_.cells[before.cell];
      if (before.name != row.name || smaller.scene != cell.scene ||
          smaller.object_count >= cell.object_count || before.note.empty()) {
        continue;
      }
      const double growth = static_cast<double>(cell.object_count) / smaller.object_count;
      if (before.ms_mean * growth > 1000 * report_.options.peer_cap_s || before.frame_count == 0) {
        return "left out, because it was too slow with " + std::to_string(smaller.object_count) +
               " objects";
      }
    }
    return "";
  }

  void FillRow(const ContestantTiming& timing, BenchRow& row) const {
    row.first_step = 1;
    row.step_ms = timing.step_ms;
    row.frame_count = timing.measured_count;
    const auto measured = std::span(row.step_ms).last(row.frame_count);
    static_cast<TimeSummary&>(row) = Summarize(measured);
    for (const PairFingerprint& pairs : std::span(timing.step_pairs).last(row.frame_count)) {
      row.pairs_mean += static_cast<double>(pairs.count) / static_cast<double>(row.frame_count);
    }
    if (row.kind == ContestantKind::kArm) {
      row.aabb_checks_mean = timing.aabb_checks_mean;
      row.bytes = timing.bytes;
      row.bytes_with_pairs = timing.bytes_with_pairs;
    }
    if (timing.capped) {
      row.note = "stopped by the cap of " + Fixed(report_.options.peer_cap_s, 1) + " s";
    }
  }

  // Returns the first step in which `found` has other pairs than `right`, in words; empty if none.
  // `right` belongs to an arm; `sweepstake-lab check` tests whether the arms are correct.
  std::string DifferenceFrom(const ContestantTiming& right, const ContestantTiming& found) const {
    for (size_t i = 0; i < found.step_pairs.size(); ++i) {
      if (found.step_pairs[i] == right.step_pairs[i]) continue;
      return "step " + std::to_string(i + 1) + ": other pairs than " + rows_.front().name +
             " with " + rows_.front().simd + " (" + std::to_string(found.step_pairs[i].count) +
             " instead of " + std::to_string(right.step_pairs[i].count) + ")";
    }
    return "";
  }

  void SortByFamily() {
    const auto families = BroadPhaseNames();
    const auto place = [&](const BenchRow& row) {
      return std::find(families.begin(), families.end(), row.family) - families.begin();
    };
    // The sort is stable: contestants were added by instruction set, the best set first, and rows
    // that compare equal keep that order.
    std::stable_sort(rows_.begin(), rows_.end(), [&](const BenchRow& a, const BenchRow& b) {
      return std::tuple(place(a), a.kind, a.name, a.thread_count) <
             std::tuple(place(b), b.kind, b.name, b.thread_count);
    });
  }

  BenchReport& report_;
  const ThreadPools& pools_;
  std::vector<BenchRow> rows_;
  std::vector<Contestant> contestants_;
  std::vector<BenchRow> left_out_;
};

void AddContestants(const std::vector<std::string>& arms, std::span<const PeerLibrary> peers,
                    const BenchOptions& options, CellRun& cell) {
  const std::vector<uint32_t>& thread_counts = options.thread_counts;
  for (const std::string& arm : arms) {
    for (const uint32_t thread_count : thread_counts) {
      for (const std::string& simd : options.simd) cell.AddArm(arm, simd, thread_count);
    }
  }
  for (const PeerLibrary& library : peers) {
    for (const PeerKind& peer : library.kinds) {
      if (!peer.takes_threads) cell.AddPeer(peer, 1);
      for (const uint32_t thread_count : thread_counts) {
        if (peer.takes_threads) cell.AddPeer(peer, thread_count);
      }
    }
  }
}

void AddLibraries(const std::vector<PeerLibrary>& peers, Machine& machine) {
  for (const PeerLibrary& library : peers) {
    const std::string name(library.name);
    if (library.kinds.empty()) {
      machine.absent_peers.push_back(name + ": install " + std::string(library.package) +
                                     " and build with -DSWEEPSTAKE_PEERS=ON");
    } else {
      machine.libraries.push_back({name, library.version});
    }
  }
}

Status RunCell(const SceneChoice& choice, const std::vector<std::string>& arms,
               std::span<const PeerLibrary> peers, const ThreadPools& pools,
               const std::function<void(double share, const std::string& text)>& on_progress,
               BenchReport& report) {
  auto scene = OpenScene(choice);
  if (!scene.ok()) return scene.status();
  const auto object_count = static_cast<uint32_t>((*scene)->max_object_count());
  report.cells.push_back({choice.name, object_count});
  CellRun cell(report, pools);
  AddContestants(arms, peers, report.options, cell);
  const std::string label = choice.name + ", " + std::to_string(object_count) + " objects, ";
  const auto steps =
      static_cast<double>((report.options.warmup + report.options.frames) * cell.size());
  uint64_t done = 0;
  cell.Measure(**scene, [&](const std::string& name) {
    on_progress(static_cast<double>(++done) / steps, label + name);
  });
  return {};
}

// Returns the instruction sets in `names` (all sets for `all`) without repetitions, the best first,
// and selects the best one. For an empty list, returns the instruction set in use. Errors: those of
// UseSimdTarget.
Result<std::vector<std::string>> ChooseSimd(const std::vector<std::string>& names) {
  if (names.empty()) return std::vector<std::string>{std::string(SimdTarget())};
  const auto usable = SimdTargets();
  std::vector<std::string> chosen(usable.begin(), usable.end());
  if (names != std::vector<std::string>{"all"}) {
    const std::string_view before = SimdTarget();
    for (const std::string& name : names) {
      const Status status = UseSimdTarget(name);
      if (status.ok()) continue;
      (void)UseSimdTarget(before);
      return status;
    }
    std::erase_if(chosen, [&](const std::string& each) {
      return std::find(names.begin(), names.end(), each) == names.end();
    });
  }
  if (Status status = UseSimdTarget(chosen.front()); !status.ok()) return status;
  return chosen;
}

}  // namespace

Result<BenchReport> RunBench(
    const BenchOptions& options,
    const std::function<void(double share, const std::string& text)>& on_progress) {
  auto simd = ChooseSimd(options.simd);
  if (!simd.ok()) return simd.status();
  const auto arms = ChooseArms(options.arms);
  if (!arms.ok()) return arms.status();
  const auto scenes = ExpandScenes(options.scenes, options.object_counts, options.seed);
  const auto peers = options.peers ? PeerLibraries() : std::vector<PeerLibrary>();
  const ThreadPools pools(options.thread_counts);
  BenchReport report;
  report.machine = DescribeMachine();
  AddLibraries(peers, report.machine);
  report.options = options;
  report.options.simd = std::move(*simd);
  const auto cell_count = static_cast<double>(scenes.size());
  for (const SceneChoice& scene : scenes) {
    const auto before = static_cast<double>(report.cells.size());
    const Status status = RunCell(
        scene, *arms, peers, pools,
        [&](double share, const std::string& text) {
          on_progress((before + share) / cell_count, text);
        },
        report);
    if (!status.ok()) return status;
  }
  report.ratios = RatiosOf(report);
  report.speedups = SpeedupsOf(report);
  return report;
}

bool AnyDiffers(const BenchReport& report) {
  return std::any_of(report.rows.begin(), report.rows.end(),
                     [](const BenchRow& row) { return !row.difference.empty(); });
}

}  // namespace sweepstake::cli
