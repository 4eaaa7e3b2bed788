#include "tests/laboratory/bench/bench_output.h"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

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
          {"kind", RatioKindName(ratio.kind)},
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

// Returns the cell's title with the mean pair count of an arm. A peer's count is not used, because
// a peer that was stopped early saw fewer frames.
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

TextTable RatioTable(const BenchReport& report) {
  std::vector<std::string> header = {"compared", "ours", "thr", "with", "ratio", "mean"};
  if (HasSeveralSimd(report)) header.insert(header.begin() + 2, "simd");
  TextTable table(std::move(header));
  const BenchRatio* before = nullptr;
  for (const BenchRatio& ratio : report.ratios) {
    if (before == nullptr || before->cell != ratio.cell) {
      table.AddTitle(Title(report.cells[ratio.cell]));
    }
    before = &ratio;
    std::vector<std::string> cells = {RatioKindName(ratio.kind),
                                      ratio.ours,
                                      std::to_string(ratio.thread_count),
                                      ratio.other,
                                      Fixed(ratio.value, 2),
                                      ratio.value_mean ? Fixed(*ratio.value_mean, 2) : "-"};
    if (HasSeveralSimd(report)) cells.insert(cells.begin() + 2, ratio.simd);
    table.AddRow(std::move(cells));
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

const char* RatioKindName(RatioKind kind) {
  switch (kind) {
    case RatioKind::kFamily:
      return "family";
    case RatioKind::kOverall:
      return "overall";
    case RatioKind::kGrowth:
      return "growth";
    case RatioKind::kThreads:
      return "threads";
    case RatioKind::kSpike:
      return "spike";
    case RatioKind::kSimd:
      return "simd";
  }
  return "";
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

void PrintBenchTables(const BenchReport& report, std::ostream& out) {
  RowTable(report).Print(out);
  PrintNotes(report, out);
  if (!report.ratios.empty()) {
    out << '\n';
    RatioTable(report).Print(out);
  }
  out << '\n';
  PrintMachine(report, out);
}

}  // namespace sweepstake::cli
