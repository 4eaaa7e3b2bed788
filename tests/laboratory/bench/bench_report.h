// The result of one run of `sweepstake-lab bench` as plain values: the machine, the options, a cell
// per scene and object count, and a row per contestant in a cell. A contestant is one of our arms
// or a peer, which is a broad phase of another library. The ratios are derived from the rows. All
// outputs of the command are made from these values alone.
//
// Times are in milliseconds per frame, sizes in bytes. Optional values are absent if they are
// unknown or were not measured.
#pragma once

#include <cstddef>
#include <cstdint>
#include <functional>
#include <optional>
#include <ostream>
#include <string>
#include <vector>

#include "engine_client/cli/io/statistics.h"
#include "sweepstake/status.h"
#include "tests/laboratory/game/machine.h"

namespace sweepstake::cli {

struct BenchOptions {
  std::vector<std::string> scenes;
  std::vector<uint32_t> object_counts{1000};
  uint64_t frames = 120;
  uint64_t warmup = 20;
  uint64_t seed = 1;
  std::vector<std::string> arms{"all"};
  std::vector<uint32_t> thread_counts{1};
  bool cold = false;  // caches are evicted before each frame (scene_timing.h)
  // Instruction sets to measure each arm with: `all` or some of SimdTargets() (simd.h), or empty
  // for SimdTarget(). In a report: the measured instruction sets, the best first.
  std::vector<std::string> simd;
  bool peers = false;
  double peer_cap_s = 5;  // maximum total time of one peer in one cell
  bool json = false;
  std::string command_line;  // as the user typed it
};

// One scene with one object count. All contestants of a cell saw the same frames.
struct BenchCell {
  std::string scene;
  uint32_t object_count = 0;  // in the first frame
};

enum class ContestantKind { kArm, kPeer };

// The result of one contestant in one cell.
struct BenchRow : TimeSummary {
  size_t cell = 0;  // index in BenchReport::cells
  ContestantKind kind = ContestantKind::kArm;
  std::string family;  // BruteForce, Grid, SAP, AxisSweep, DBVT, Tracy or KDTree
  std::string name;    // name of the arm or of the peer
  std::string simd;    // the instruction set; empty for peers, which have their own
  uint32_t thread_count = 1;
  uint64_t frame_count = 0;  // measured frames; 0: not run, for the reason in `note`
  double pairs_mean = 0;
  std::optional<double> aabb_checks_mean;    // arms only
  std::optional<uint64_t> bytes;             // arms only: maximum over the measured frames
  std::optional<uint64_t> bytes_with_pairs;  // `bytes` plus the pair buffer
  // The first frame with wrong pairs and what is wrong; empty if all are right.
  std::string difference;
  std::string note;             // why fewer frames were measured; else empty
  uint64_t first_step = 0;      // number of the scene's step in step_ms[0]
  std::vector<double> step_ms;  // time per step, warm-up included
};

enum class RatioKind {
  kFamily,   // compares an arm with the best peer of its family
  kOverall,  // compares the best arm with the best of all peers
  kGrowth,   // compares the times per object at 1,000,000 and 10,000 objects
  kThreads,  // compares several threads with one thread
  kSpike,    // compares the 99th percentile of the frame times with the median
  kSimd,     // compares an instruction set with the next better measured set
};
// The names of the kinds in JSON, indexed by RatioKind.
inline constexpr const char* kRatioKindNames[] = {"family",  "overall", "growth",
                                                  "threads", "spike",   "simd"};

// A comparison between rows of one run.
// - kFamily, kOverall, kThreads: `value` is how many times faster `ours` is than `other`, by the
//   median over the frames that both measured.
// - kGrowth, kSpike: `value` is a quotient that should be small.
// - kSimd: `value` is how many times longer the arm takes with `simd` than with `other`. All other
//   kinds compare arms that ran with the same instruction set.
struct BenchRatio {
  size_t cell = 0;
  RatioKind kind = RatioKind::kFamily;
  std::string family;  // the family of `ours`
  std::string ours;    // the arm
  std::string simd;    // the arm's instruction set
  std::string other;   // name of the peer, or words such as "1 thread"
  uint32_t thread_count = 1;
  double value = 0;
  std::optional<double> value_mean;  // computed from means instead of medians
};

// How many times faster an arm is than a peer, over the frames that both measured. Both have one
// thread.
struct BenchSpeedup {
  size_t cell = 0;
  std::string arm;
  std::string simd;  // the arm's instruction set
  std::string peer;
  double median = 0;
  double mean = 0;
};

struct BenchReport {
  Machine machine;
  BenchOptions options;
  std::vector<BenchCell> cells;
  std::vector<BenchRow> rows;  // by cell, family, kind, name, threads and instruction set
  std::vector<BenchRatio> ratios;
  std::vector<BenchSpeedup> speedups;  // one per arm and peer of a cell
};

// Returns the comparisons of the report's rows. Leaves out rows with a `difference`. RatiosOf and
// SpeedupsOf are pure and safe from any thread.
std::vector<BenchRatio> RatiosOf(const BenchReport& report);

// Returns how many times faster each arm is than each peer of its cell, with one thread each.
std::vector<BenchSpeedup> SpeedupsOf(const BenchReport& report);

// Runs every arm with every thread count, and every peer, on the same frames of each cell. Calls
// `on_progress` with the finished share and the name of the current cell. Afterwards the process
// uses the best of the measured instruction sets. If an arm or a peer finds wrong pairs, its row
// contains the difference; this is not an error. Errors: those of UseSimdTarget, ChooseArms and
// OpenScene. Not thread-safe. Cost: the contestants' own time; a peer exceeds its cap by at most
// one frame. Memory: all contestants of a cell exist at the same time.
Result<BenchReport> RunBench(
    const BenchOptions& options,
    const std::function<void(double share, const std::string& text)>& on_progress);

// Returns whether any contestant has found wrong pairs.
bool AnyDiffers(const BenchReport& report);

void PrintBenchJson(const BenchReport& report, std::ostream& out);
// Prints the rows as a table, without ratios. `tests/bench/judge.py bench` prints the ratios of the
// JSON document, with their goals.
void PrintBenchTable(const BenchReport& report, std::ostream& out);

}  // namespace sweepstake::cli
