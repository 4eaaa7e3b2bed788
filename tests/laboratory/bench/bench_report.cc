#include "tests/laboratory/bench/bench_report.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <span>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

using Rows = std::vector<const BenchRow*>;

bool IsComparable(const BenchRow& row) { return row.frame_count > 0 && row.difference.empty(); }

Rows RowsWhere(const BenchReport& report, const auto& wanted) {
  Rows rows;
  for (const BenchRow& row : report.rows) {
    if (IsComparable(row) && wanted(row)) rows.push_back(&row);
  }
  return rows;
}

// A range of steps of the scene, from `begin` to before `end`.
struct Steps {
  uint64_t begin;
  uint64_t end;
};

Steps TakenBy(const BenchRow& row) { return {row.first_step, row.first_step + row.step_ms.size()}; }

Steps MeasuredBy(const BenchRow& row) {
  const Steps taken = TakenBy(row);
  return {taken.end - row.frame_count, taken.end};
}

std::span<const double> TimesIn(const BenchRow& row, Steps steps) {
  return std::span(row.step_ms).subspan(steps.begin - row.first_step, steps.end - steps.begin);
}

// How many times faster one contestant (an arm or a peer) is than another, by median and by mean.
struct Speedup {
  double median;
  double mean;
};

// Compares two contestants on the measured frames of the contestant that has fewer of them. Returns
// nothing if the two have no frame in common.
std::optional<Speedup> SpeedupOver(const BenchRow& ours, const BenchRow& other) {
  const bool ours_is_shorter = ours.frame_count < other.frame_count;
  const Steps measured = MeasuredBy(ours_is_shorter ? ours : other);
  const Steps taken = TakenBy(ours_is_shorter ? other : ours);
  const Steps common = {std::max(measured.begin, taken.begin), std::min(measured.end, taken.end)};
  if (common.begin >= common.end) return std::nullopt;
  const TimeSummary our_times = Summarize(TimesIn(ours, common));
  const TimeSummary other_times = Summarize(TimesIn(other, common));
  if (our_times.ms_median <= 0 || our_times.ms_mean <= 0) return std::nullopt;
  return Speedup{other_times.ms_median / our_times.ms_median,
                 other_times.ms_mean / our_times.ms_mean};
}

BenchRatio RatioOf(RatioKind kind, const BenchRow& ours, std::string_view other, double value) {
  BenchRatio ratio;
  ratio.cell = ours.cell;
  ratio.kind = kind;
  ratio.family = ours.family;
  ratio.ours = ours.name;
  ratio.simd = ours.simd;
  ratio.other = other;
  ratio.thread_count = ours.thread_count;
  ratio.value = value;
  return ratio;
}

BenchRatio Against(RatioKind kind, const BenchRow& ours, std::string_view other, Speedup speedup) {
  BenchRatio ratio = RatioOf(kind, ours, other, speedup.median);
  ratio.value_mean = speedup.mean;
  return ratio;
}

std::optional<BenchRatio> AgainstBest(RatioKind kind, const BenchRow& ours, const Rows& peers) {
  std::optional<BenchRatio> lowest;
  for (const BenchRow* peer : peers) {
    const auto speedup = SpeedupOver(ours, *peer);
    if (!speedup || (lowest && lowest->value <= speedup->median)) continue;
    lowest = Against(kind, ours, peer->name, *speedup);
  }
  return lowest;
}

// Compares an arm with one thread to the best peer of its family.
void AddFamily(const BenchReport& report, const BenchRow& ours, std::vector<BenchRatio>& ratios) {
  const Rows peers = RowsWhere(report, [&](const BenchRow& row) {
    return row.cell == ours.cell && row.kind == ContestantKind::kPeer && row.thread_count == 1;
  });
  Rows family = peers;
  std::erase_if(family, [&](const BenchRow* peer) { return peer->family != ours.family; });
  if (const auto ratio = AgainstBest(RatioKind::kFamily, ours, family)) {
    ratios.push_back(*ratio);
  }
}

const BenchRow* Fastest(const Rows& rows) {
  const auto fastest = std::min_element(
      rows.begin(), rows.end(),
      [](const BenchRow* a, const BenchRow* b) { return a->ms_median < b->ms_median; });
  return fastest == rows.end() ? nullptr : *fastest;
}

// Compares our fastest arm with this instruction set and thread count to the fastest peer with at
// most as many threads.
void AddOverall(const BenchReport& report, size_t cell, std::string_view simd,
                uint32_t thread_count, std::vector<BenchRatio>& ratios) {
  const BenchRow* ours = Fastest(RowsWhere(report, [&](const BenchRow& row) {
    return row.cell == cell && row.kind == ContestantKind::kArm && row.simd == simd &&
           row.thread_count == thread_count;
  }));
  if (ours == nullptr) return;
  const Rows peers = RowsWhere(report, [&](const BenchRow& row) {
    return row.cell == cell && row.kind == ContestantKind::kPeer &&
           row.thread_count <= thread_count;
  });
  if (const auto ratio = AgainstBest(RatioKind::kOverall, *ours, peers)) {
    ratios.push_back(*ratio);
  }
}

bool IsSameArm(const BenchRow& row, const BenchRow& ours) {
  return row.name == ours.name && row.kind == ours.kind;
}

void AddThreads(const BenchReport& report, const BenchRow& ours, std::vector<BenchRatio>& ratios) {
  const Rows alone = RowsWhere(report, [&](const BenchRow& row) {
    return row.cell == ours.cell && IsSameArm(row, ours) && row.simd == ours.simd &&
           row.thread_count == 1;
  });
  if (alone.empty()) return;
  const auto speedup = SpeedupOver(ours, *alone.front());
  if (!speedup) return;
  ratios.push_back(Against(RatioKind::kThreads, ours, "1 thread", *speedup));
}

bool IsNearLinear(std::string_view family) {
  return family == "Grid" || family == "DBVT" || family == "Tracy" || family == "KDTree";
}

// Compares the times per object at 1,000,000 and at 10,000 objects of the same scene.
void AddGrowth(const BenchReport& report, const BenchRow& ours, std::vector<BenchRatio>& ratios) {
  constexpr uint32_t kFrom = 10'000;
  constexpr uint32_t kTo = 1'000'000;
  const BenchCell& cell = report.cells[ours.cell];
  if (cell.object_count != kTo || !IsNearLinear(ours.family)) return;
  const Rows small = RowsWhere(report, [&](const BenchRow& row) {
    return report.cells[row.cell].scene == cell.scene &&
           report.cells[row.cell].object_count == kFrom && IsSameArm(row, ours) &&
           row.simd == ours.simd && row.thread_count == ours.thread_count;
  });
  if (small.empty() || small.front()->ms_median <= 0) return;
  const double per_object = (ours.ms_median / kTo) / (small.front()->ms_median / kFrom);
  ratios.push_back(RatioOf(RatioKind::kGrowth, ours, "10000 objects", per_object));
}

void AddSpike(const BenchReport& report, const BenchRow& ours, std::vector<BenchRatio>& ratios) {
  constexpr uint64_t kEnoughFrames = 100;
  if (ours.family != "KDTree" || ours.frame_count < kEnoughFrames || ours.ms_median <= 0) return;
  if (!report.cells[ours.cell].scene.starts_with("suite-")) return;
  ratios.push_back(RatioOf(RatioKind::kSpike, ours, "median", ours.ms_p99 / ours.ms_median));
}

// Compares an arm to itself with the next better instruction set that was measured.
void AddSimd(const BenchReport& report, const BenchRow& ours, std::vector<BenchRatio>& ratios) {
  const auto& sets = report.options.simd;
  const auto own = std::find(sets.begin(), sets.end(), ours.simd);
  if (own == sets.begin() || own == sets.end()) return;
  const std::string& better = *std::prev(own);
  const Rows with_better = RowsWhere(report, [&](const BenchRow& row) {
    return row.cell == ours.cell && IsSameArm(row, ours) && row.simd == better &&
           row.thread_count == ours.thread_count;
  });
  if (with_better.empty()) return;
  if (const auto speedup = SpeedupOver(*with_better.front(), ours)) {
    ratios.push_back(Against(RatioKind::kSimd, ours, better, *speedup));
  }
}

Json NameOrNull(const std::string& name) { return name.empty() ? Json() : Json(name); }

const char* KindName(ContestantKind kind) { return kind == ContestantKind::kArm ? "arm" : "peer"; }

Json RowJson(const BenchRow& row, const BenchCell& cell) {
  Json json = {{"scene", cell.scene},
               {"objects", cell.object_count},
               {"arm", row.name},
               {"simd", NameOrNull(row.simd)},
               {"threads", row.thread_count},
               {"frames", row.frame_count},
               {"ms_median", row.ms_median},
               {"ms_mean", row.ms_mean},
               {"ms_min", row.ms_min},
               {"ms_p99", row.ms_p99},
               {"pairs_mean", row.pairs_mean},
               {"aabb_checks_mean", OrNull(row.aabb_checks_mean)},
               {"bytes", OrNull(row.bytes)},
               {"bytes_with_pairs", OrNull(row.bytes_with_pairs)},
               {"kind", KindName(row.kind)},
               {"family", row.family}};
  if (!row.note.empty()) json["note"] = row.note;
  if (!row.difference.empty()) json["difference"] = row.difference;
  return json;
}

Json RatioJson(const BenchRatio& ratio, const BenchCell& cell) {
  return {{"scene", cell.scene},
          {"objects", cell.object_count},
          {"threads", ratio.thread_count},
          {"kind", kRatioKindNames[static_cast<size_t>(ratio.kind)]},
          {"family", ratio.family},
          {"ours", ratio.ours},
          {"simd", ratio.simd},
          {"other", ratio.other},
          {"value", ratio.value},
          {"value_mean", OrNull(ratio.value_mean)}};
}

std::string OrDash(const std::optional<uint64_t>& value) {
  return value ? std::to_string(*value) : "-";
}
std::string OrDash(const std::string& name) { return name.empty() ? "-" : name; }

bool HasSeveralSimd(const BenchReport& report) { return report.options.simd.size() > 1; }

std::string Title(const BenchCell& cell) {
  return cell.scene + ", " + std::to_string(cell.object_count) + " objects";
}

// Returns the cell's title with the mean pair count of an arm. The count of a peer is not used,
// because a peer that was stopped early has run fewer frames.
std::string TitleWithPairs(const BenchReport& report, size_t cell) {
  const auto arm = std::find_if(report.rows.begin(), report.rows.end(), [&](const BenchRow& row) {
    return row.cell == cell && row.kind == ContestantKind::kArm;
  });
  std::string title = Title(report.cells[cell]);
  if (arm == report.rows.end()) return title;
  return title + ", " + Fixed(arm->pairs_mean, 1) + " pairs per frame";
}

// The table must fit a terminal. Values that all rows of a cell share are therefore in the cell's
// title. Columns for peers and for instruction sets appear only if the run has peers or several
// instruction sets.
std::vector<std::string> RowHeader(const BenchReport& report) {
  std::vector<std::string> header;
  if (report.options.peers) header.emplace_back("family");
  header.emplace_back("arm");
  if (HasSeveralSimd(report)) header.emplace_back("simd");
  header.emplace_back("thr");
  if (report.options.peers) header.emplace_back("frames");
  for (const char* column : {"ms_median", "ms_mean", "ms_min", "ms_p99", "aabb_checks", "bytes"}) {
    header.emplace_back(column);
  }
  return header;
}

std::vector<std::string> RowCells(const BenchReport& report, const BenchRow& row) {
  std::vector<std::string> cells;
  if (report.options.peers) cells.push_back(row.family);
  cells.push_back(row.name);
  if (HasSeveralSimd(report)) cells.push_back(OrDash(row.simd));
  cells.push_back(std::to_string(row.thread_count));
  if (report.options.peers) cells.push_back(std::to_string(row.frame_count));
  for (const double ms : {row.ms_median, row.ms_mean, row.ms_min, row.ms_p99}) {
    cells.push_back(Fixed(ms, 4));
  }
  cells.push_back(row.aabb_checks_mean ? Fixed(*row.aabb_checks_mean, 0) : "-");
  cells.push_back(OrDash(row.bytes));
  return cells;
}

TextTable RowTable(const BenchReport& report) {
  TextTable table(RowHeader(report));
  const BenchRow* before = nullptr;
  for (const BenchRow& row : report.rows) {
    if (before == nullptr || before->cell != row.cell)
      table.AddTitle(TitleWithPairs(report, row.cell));
    before = &row;
    table.AddRow(RowCells(report, row));
  }
  return table;
}

void PrintNotes(const BenchReport& report, std::ostream& out) {
  for (const BenchRow& row : report.rows) {
    const BenchCell& cell = report.cells[row.cell];
    const bool name_is_enough = row.simd.empty() || !HasSeveralSimd(report);
    const std::string where = row.name + (name_is_enough ? "" : " with " + row.simd) + " in " +
                              cell.scene + " (" + std::to_string(cell.object_count) + " objects): ";
    if (!row.note.empty()) out << where << row.note << '\n';
    if (!row.difference.empty()) out << "FAILED " << where << row.difference << '\n';
  }
}

void PrintMachine(const BenchReport& report, std::ostream& out) {
  const Machine& machine = report.machine;
  out << machine.cpu << ", " << machine.core_count << " cores\n"
      << machine.compiler << ", " << machine.simd_target
      << (report.options.cold ? ", cold caches, " : ", ") << machine.date_utc << '\n';
  for (const LibraryVersion& library : machine.libraries) {
    out << library.name << ' ' << library.version
        << (&library == &machine.libraries.back() ? "\n" : ", ");
  }
  for (const std::string& absent : machine.absent_peers) out << "Left out: " << absent << '\n';
}

}  // namespace

std::vector<BenchRatio> RatiosOf(const BenchReport& report) {
  std::vector<BenchRatio> ratios;
  const Rows arms =
      RowsWhere(report, [](const BenchRow& row) { return row.kind == ContestantKind::kArm; });
  for (size_t cell = 0; cell < report.cells.size(); ++cell) {
    for (const std::string& simd : report.options.simd) {
      for (const uint32_t thread_count : report.options.thread_counts) {
        AddOverall(report, cell, simd, thread_count, ratios);
      }
    }
    for (const BenchRow* arm : arms) {
      if (arm->cell != cell) continue;
      if (arm->thread_count == 1) AddFamily(report, *arm, ratios);
      if (arm->thread_count != 1) AddThreads(report, *arm, ratios);
      AddGrowth(report, *arm, ratios);
      AddSpike(report, *arm, ratios);
      AddSimd(report, *arm, ratios);
    }
  }
  return ratios;
}

std::vector<BenchSpeedup> SpeedupsOf(const BenchReport& report) {
  const auto rows_of = [&](ContestantKind kind) {
    return RowsWhere(
        report, [&](const BenchRow& row) { return row.kind == kind && row.thread_count == 1; });
  };
  std::vector<BenchSpeedup> speedups;
  const Rows peers = rows_of(ContestantKind::kPeer);
  for (const BenchRow* arm : rows_of(ContestantKind::kArm)) {
    for (const BenchRow* peer : peers) {
      if (peer->cell != arm->cell) continue;
      const auto speedup = SpeedupOver(*arm, *peer);
      if (!speedup) continue;
      speedups.push_back(
          {arm->cell, arm->name, arm->simd, peer->name, speedup->median, speedup->mean});
    }
  }
  return speedups;
}

void PrintBenchJson(const BenchReport& report, std::ostream& out) {
  const BenchOptions& options = report.options;
  Json document = {{"command", "bench"},
                   {"command_line", options.command_line},
                   {"frames", options.frames},
                   {"warmup", options.warmup},
                   {"seed", options.seed},
                   {"cold", options.cold},
                   {"simd", options.simd},
                   {"threads", options.thread_counts},
                   {"peers", options.peers},
                   {"peer_cap_s", options.peer_cap_s},
                   {"machine", MachineJson(report.machine)},
                   {"rows", Json::array()},
                   {"ratios", Json::array()},
                   {"speedups", Json::array()}};
  for (const BenchRow& row : report.rows) {
    document["rows"].push_back(RowJson(row, report.cells[row.cell]));
  }
  for (const BenchRatio& ratio : report.ratios) {
    document["ratios"].push_back(RatioJson(ratio, report.cells[ratio.cell]));
  }
  for (const BenchSpeedup& speedup : report.speedups) {
    const BenchCell& cell = report.cells[speedup.cell];
    document["speedups"].push_back({{"scene", cell.scene},
                                    {"objects", cell.object_count},
                                    {"arm", speedup.arm},
                                    {"simd", speedup.simd},
                                    {"peer", speedup.peer},
                                    {"median", speedup.median},
                                    {"mean", speedup.mean}});
  }
  PrintJson(document, out);
}

void PrintBenchTable(const BenchReport& report, std::ostream& out) {
  RowTable(report).Print(out);
  PrintNotes(report, out);
  out << '\n';
  PrintMachine(report, out);
}

}  // namespace sweepstake::cli
