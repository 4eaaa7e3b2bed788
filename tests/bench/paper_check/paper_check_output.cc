#include "tests/bench/paper_check/paper_check_output.h"

#include <algorithm>
#include <nlohmann/json.hpp>
#include <string>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

int DecimalsOf(const PaperCheckFigure& figure) { return figure.paper.mean < 1 ? 3 : 1; }

std::string Percent(double ratio) { return Fixed(100 * ratio, 0) + " %"; }

std::string RangeText(const Interval& interval, int decimals) {
  return Fixed(interval.low, decimals) + " – " + Fixed(interval.high, decimals);
}

std::string NameOf(const PaperCell& cell) {
  return std::string(cell.scene) + " " + std::to_string(cell.object_count);
}

std::string TitleOf(const PaperCheckRow& row) {
  std::string title = NameOf(row.cell) + ": " + std::string(row.cell.dominant) + " dominant in " +
                      std::to_string(row.cell.dominant_run_count) +
                      " of 5 of the paper's runs, in " + Percent(row.dominance_ratio) + " of ours";
  if (row.fit.stall_ratio > 0) {
    title += "; with " + Percent(row.fit.stall_ratio) + " of the time lost";
  }
  return title;
}

void AddFigure(const PaperCheckFigure& figure, TextTable& table) {
  const int decimals = DecimalsOf(figure);
  table.AddRow(
      {std::string(figure.name),
       Fixed(figure.paper.mean, decimals) + " ± " + Fixed(figure.paper.deviation, decimals),
       RangeText(figure.allowed, decimals), Fixed(figure.mean, decimals),
       RangeText(figure.ci95, decimals), figure.is_in ? "in" : "OUT"});
}

bool AllMatch(std::span<const PaperCheckRow> rows) {
  return std::all_of(rows.begin(), rows.end(),
                     [](const PaperCheckRow& row) { return row.matches(); });
}

std::string ListOf(std::span<const PaperCheckRow> rows, bool matching) {
  std::string list;
  for (const PaperCheckRow& row : rows) {
    if (row.matches() == matching) list += (list.empty() ? "" : ", ") + NameOf(row.cell);
  }
  return list;
}

// Why costs of the arms alone cannot give the cell's figures.
std::string ReasonOf(const PaperCell& cell) {
  const double seconds = SecondsPerUpdate(cell);
  std::string reason = NameOf(cell) + ": n* has one observation per " + Fixed(seconds, 1) +
                       " s of active time, where every tick would give one per 2 s. ";
  if (seconds > kLongestFrameS) {
    return reason +
           "No frame may last longer than 5 s without a bail-out, so this time passed "
           "without being observed.";
  }
  return reason +
         "Were the rest frames of up to 5 s, each a window that scores next to nothing, "
         "μ* would be " +
         Fixed(MeanRewardBound(cell), 2) + " at most, not " + Fixed(cell.posterior_mean.mean, 2) +
         ": this time passed without being observed.";
}

void PrintReasons(std::span<const PaperCheckRow> rows, std::ostream& out) {
  bool any = false;
  for (const PaperCheckRow& row : rows) {
    if (row.fit.stall_ratio == 0) continue;
    if (!any) {
      out << "\nNot from the arms' costs alone (the fit loses time in frames over the bail-out "
             "limit that are no arm's fault):\n";
    }
    any = true;
    out << "  " << ReasonOf(row.cell) << '\n';
  }
}

Json FigureJson(const PaperCheckFigure& figure) {
  return {{"paper_mean", figure.paper.mean},
          {"paper_sd", figure.paper.deviation},
          {"allowed_low", figure.allowed.low},
          {"allowed_high", figure.allowed.high},
          {"mean", figure.mean},
          {"ci95_low", figure.ci95.low},
          {"ci95_high", figure.ci95.high},
          {"in", figure.is_in}};
}

Json FitJson(const PaperCellFit& fit) {
  Json arms = Json::array();
  for (size_t arm = 0; arm < kPaperArmCount; ++arm) {
    arms.push_back({{"arm", kPaperArms[arm]},
                    {"frame_ms", fit.arms[arm].frame_ms},
                    {"detection_ms", fit.arms[arm].detection_ms},
                    {"noise_ratio", fit.arms[arm].noise_ratio}});
  }
  return {{"arms", std::move(arms)},
          {"stall_ratio", fit.stall_ratio},
          {"stall_period_s", fit.stall_period_s}};
}

Json RowJson(const PaperCheckRow& row) {
  Json json = {{"scene", row.cell.scene},
               {"objects", row.cell.object_count},
               {"dominant", row.cell.dominant},
               {"paper_dominant_runs", row.cell.dominant_run_count},
               {"dominance_ratio", row.dominance_ratio},
               {"paper_seconds_per_update", SecondsPerUpdate(row.cell)},
               {"matches", row.matches()}};
  for (const PaperCheckFigure& figure : row.figures) json[figure.name] = FigureJson(figure);
  json["fit"] = FitJson(row.fit);
  return json;
}

}  // namespace

void PrintPaperCheckTable(std::span<const PaperCheckRow> rows, const PaperCheckOptions& options,
                          std::ostream& out) {
  TextTable table({"figure", "paper", "mean ± 2 SD", "ours", "95 %", "verdict"});
  for (const PaperCheckRow& row : rows) {
    table.AddTitle(TitleOf(row));
    for (const PaperCheckFigure& figure : row.figures) AddFigure(figure, table);
  }
  table.Print(out);
  PrintReasons(rows, out);
  out << "\nPolicy paper, " << options.seed_count
      << " runs of 15 min per cell in virtual time. All four figures in: " << ListOf(rows, true)
      << ".\n";
  if (!AllMatch(rows)) out << "OUT: " << ListOf(rows, false) << ".\n";
}

void PrintPaperCheckJson(std::span<const PaperCheckRow> rows, const PaperCheckOptions& options,
                         std::ostream& out) {
  Json document = {{"command", "paper-check"},
                   {"seeds", options.seed_count},
                   {"matches", AllMatch(rows)},
                   {"rows", Json::array()}};
  for (const PaperCheckRow& row : rows) document["rows"].push_back(RowJson(row));
  PrintJson(document, out);
}

}  // namespace sweepstake::cli
