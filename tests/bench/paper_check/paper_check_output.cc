#include "tests/bench/paper_check/paper_check_output.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cmath>
#include <nlohmann/json.hpp>
#include <string>
#include <utility>
#include <vector>

#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;
using Cells = std::span<const PaperPrediction>;

int DecimalsOf(const PaperResidual& figure) { return figure.paper.mean <= 1 ? 3 : 1; }

std::string MeanText(const Spread& figure, int decimals) {
  return std::isnan(figure.mean) ? "none" : Fixed(figure.mean, decimals);
}

std::string FigureText(const Spread& figure, int decimals) {
  if (std::isnan(figure.mean)) return "none";
  return MeanText(figure, decimals) + " ± " + Fixed(figure.deviation, decimals);
}

// Formats dominance as in Table 3: "3 / 5".
std::string FigureText(const PaperResidual& residual, const Spread& figure) {
  if (residual.paper.deviation == 0 && residual.paper.mean <= 1)
    return Fixed(figure.mean * kPaperRunCount, 1) + " / " + std::to_string(kPaperRunCount);
  return FigureText(figure, DecimalsOf(residual));
}

std::string ErrorsText(const PaperResidual& figure) {
  return std::isinf(figure.standard_errors) ? "-" : Fixed(figure.standard_errors, 1);
}

std::string NameOf(const PaperCell& cell) {
  return std::string(cell.scene) + " " + std::to_string(cell.object_count);
}

std::string NameOf(const PaperRules& rules) {
  if (rules.min_sample_count == 0) return std::string(rules.policy);
  return "at least " + std::to_string(rules.min_sample_count);
}

std::string ScoreText(const PaperScore& score) {
  return std::to_string(score.close_count) + " of " + std::to_string(score.figure_count);
}

void PrintCells(const PaperReport& report, std::ostream& out) {
  const std::array<Cells, 3> columns = {report.paper, report.best_min_samples, report.random};
  std::vector<std::string> header = {"figure", "the paper's"};
  for (const Cells& column : columns) {
    header.push_back(NameOf(column[0].rules));
    header.emplace_back("errors");
  }
  TextTable table(header);
  for (size_t cell = 0; cell < report.paper.size(); ++cell) {
    table.AddTitle(NameOf(report.paper[cell].cell) + ", " +
                   std::string(report.paper[cell].cell.dominant));
    for (size_t i = 0; i < report.paper[cell].figures.size(); ++i) {
      const PaperResidual& figure = report.paper[cell].figures[i];
      std::vector<std::string> row = {
          std::string(figure.name) + (figure.is_fitted ? ", fitted" : ""),
          FigureText(figure, figure.paper)};
      for (const Cells& column : columns) {
        row.push_back(FigureText(figure, column[cell].figures[i].ours));
        row.push_back(ErrorsText(column[cell].figures[i]));
      }
      table.AddRow(std::move(row));
    }
  }
  table.Print(out);
}

// Prints which minimum number of samples per window explains the cells with less than one
// observation per tick.
void PrintMinSamples(const PaperReport& report, std::ostream& out) {
  std::vector<std::string> header = {"samples per window"};
  std::vector<size_t> cells;
  for (size_t cell = 0; cell < report.paper.size(); ++cell) {
    if (report.paper[cell].cell.scene != "rotating-gravity") continue;
    cells.push_back(cell);
    header.push_back(std::to_string(report.paper[cell].cell.object_count) + ": switches");
    header.emplace_back("n*");
  }
  header.insert(header.end(), {"all cells: close", "distance"});
  TextTable table(header);
  const auto add = [&](const Cells& column) {
    std::vector<std::string> row = {NameOf(column[0].rules)};
    for (const size_t cell : cells) {
      row.push_back(ErrorsText(column[cell].figures[kSwitches]));
      row.push_back(ErrorsText(column[cell].figures[kEvidence]));
    }
    const PaperScore score = ScoreOf(column);
    row.insert(row.end(), {ScoreText(score), Fixed(score.distance, 2)});
    table.AddRow(std::move(row));
  };
  add(report.paper);
  for (const Cells& column : report.with_min_samples) add(column);
  add(report.random);
  out << "\nrotating-gravity by the minimum number of samples per window, in standard errors:\n";
  table.Print(out);
}

void PrintMisses(const PaperReport& report, std::ostream& out) {
  out << "\nFigures of policy paper that differ by more than 2 standard errors:\n";
  for (size_t cell = 0; cell < report.paper.size(); ++cell) {
    const PaperPrediction& prediction = report.paper[cell];
    for (size_t i = 0; i < prediction.figures.size(); ++i) {
      const PaperResidual& figure = prediction.figures[i];
      if (figure.is_close()) continue;
      const PaperResidual& other = report.best_min_samples[cell].figures[i];
      out << "  " << NameOf(prediction.cell) << ' ' << figure.name << ": "
          << MeanText(figure.ours, DecimalsOf(figure)) << ", the paper's "
          << MeanText(figure.paper, DecimalsOf(figure)) << " (" << ErrorsText(figure) << "); "
          << NameOf(report.best_min_samples[cell].rules)
          << " samples: " << MeanText(other.ours, DecimalsOf(figure)) << " (" << ErrorsText(other)
          << ")";
      if (i == kEvidence) {
        out << "; the paper's has one observation per "
            << Fixed(SecondsPerObservation(prediction.cell), 1) << " s";
      }
      out << '\n';
    }
  }
}

Json RowJson(const PaperPrediction& prediction) {
  Json json = {{"policy", prediction.rules.policy},
               {"min_samples", prediction.rules.min_sample_count},
               {"scene", prediction.cell.scene},
               {"objects", prediction.cell.object_count},
               {"dominant", prediction.cell.dominant},
               {"detection_ms", prediction.costs.detection_ms},
               {"gap_ms", prediction.costs.gap_ms},
               {"paper_seconds_per_observation", SecondsPerObservation(prediction.cell)}};
  for (const PaperResidual& figure : prediction.figures) {
    json[figure.name] = {
        {"fitted", figure.is_fitted},         {"paper_mean", figure.paper.mean},
        {"paper_sd", figure.paper.deviation}, {"mean", figure.ours.mean},
        {"sd", figure.ours.deviation},        {"standard_errors", figure.standard_errors}};
  }
  return json;
}

}  // namespace

PaperReport ReportOf(std::span<const PaperPrediction> predictions) {
  const size_t cell_count = predictions.size() / PaperRulesToCheck().size();
  assert(cell_count > 0);
  std::vector<Cells> parts;
  for (size_t first = 0; first < predictions.size(); first += cell_count)
    parts.push_back(predictions.subspan(first, cell_count));
  PaperReport report{.paper = parts[0],
                     .random = parts[1],
                     .with_min_samples = {parts.begin() + 2, parts.end()},
                     .best_min_samples = {}};
  report.best_min_samples = *std::min_element(
      report.with_min_samples.begin(), report.with_min_samples.end(),
      [](const Cells& a, const Cells& b) { return ScoreOf(a).distance < ScoreOf(b).distance; });
  return report;
}

void PrintPaperCheckTable(const PaperReport& report, const PaperCheckOptions& options,
                          std::ostream& out) {
  PrintCells(report, out);
  PrintMinSamples(report, out);
  PrintMisses(report, out);
  const PaperScore paper = ScoreOf(report.paper);
  const PaperScore random = ScoreOf(report.random);
  out << "\nPredicted within 2 standard errors of five runs: paper " << ScoreText(paper)
      << ", random " << ScoreText(random) << "; distance " << Fixed(paper.distance, 2) << " and "
      << Fixed(random.distance, 2) << ". " << options.seed_count
      << " runs of 15 min per cell in virtual time.\n";
}

void PrintPaperCheckJson(const PaperReport& report, const PaperCheckOptions& options,
                         std::ostream& out) {
  Json document = {{"command", "paper-check"},
                   {"seeds", options.seed_count},
                   {"best_min_samples", report.best_min_samples[0].rules.min_sample_count},
                   {"scores", Json::array()},
                   {"rows", Json::array()}};
  std::vector<Cells> columns = {report.paper, report.random};
  columns.insert(columns.end(), report.with_min_samples.begin(), report.with_min_samples.end());
  for (const Cells& column : columns) {
    const PaperScore score = ScoreOf(column);
    document["scores"].push_back({{"policy", column[0].rules.policy},
                                  {"min_samples", column[0].rules.min_sample_count},
                                  {"close", score.close_count},
                                  {"figures", score.figure_count},
                                  {"distance", score.distance}});
    for (const PaperPrediction& prediction : column)
      document["rows"].push_back(RowJson(prediction));
  }
  PrintJson(document, out);
}

}  // namespace sweepstake::cli
