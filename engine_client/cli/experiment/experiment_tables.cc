#include "engine_client/cli/experiment/experiment_tables.h"

#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/io/csv_file.h"
#include "engine_client/cli/io/numbers.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

std::string Frequency(uint32_t count, size_t of) {
  return std::to_string(count) + " / " + std::to_string(of);
}

const PaperCell* PaperOf(const CellSummary& cell) {
  return FindPaperCell(cell.cell.scene, cell.cell.object_count);
}

void PrintTable3(std::span<const CellSummary> cells, std::ostream& out) {
  TextTable table({"Scenario", "Objects", "Dominance frequency", "Interpretation", "Paper"});
  for (const CellSummary& cell : cells) {
    const PaperCell* paper = PaperOf(cell);
    table.AddRow({PaperSceneName(cell.cell.scene), html::Grouped(cell.cell.object_count),
                  cell.DominanceText(), cell.Interpretation(),
                  paper == nullptr ? "–" : std::string(paper->dominance)});
  }
  table.Print(out);
}

void PrintTable4(std::span<const CellSummary> cells, std::ostream& out) {
  TextTable table({"Scenario", "Obj.", "Dominant", "Freq.", "Switches", "Active (%)", "μ* / n*"});
  for (const CellSummary& cell : cells) {
    const auto& [dominant, count] = cell.dominance.front();
    table.AddRow({PaperSceneName(cell.cell.scene), html::Grouped(cell.cell.object_count), dominant,
                  Frequency(count, cell.runs.size()), SpreadText(cell.switches, 1),
                  SpreadText(cell.active_percent, 1),
                  SpreadText(cell.posterior_mean, 3) + " / " + SpreadText(cell.evidence, 1)});
    const PaperCell* paper = PaperOf(cell);
    if (paper == nullptr) continue;
    table.AddRow({"  paper", "", std::string(paper->dominant),
                  Frequency(paper->dominant_run_count, kPaperRunCount),
                  PaperText(paper->switches, 1), PaperText(paper->active_percent, 1),
                  PaperText(paper->posterior_mean, 3) + " / " + PaperText(paper->evidence, 1)});
  }
  table.Print(out);
}

Status WriteTable3(std::span<const CellSummary> cells, const std::filesystem::path& path) {
  auto csv =
      CsvFile::Create(path, {"policy", "scene", "objects", "runs", "dominance", "interpretation",
                             "verdict", "paper_dominance", "paper_interpretation"});
  if (!csv.ok()) return csv.status();
  for (const CellSummary& cell : cells) {
    const PaperCell* paper = PaperOf(cell);
    (*csv)->Row({cell.policy, cell.cell.scene, std::to_string(cell.cell.object_count),
                 std::to_string(cell.runs.size()), cell.DominanceText(), cell.Interpretation(),
                 VerdictName(cell.verdict), paper == nullptr ? "" : paper->dominance,
                 paper == nullptr ? "" : paper->interpretation});
  }
  return (*csv)->Commit();
}

// A measure's four cells: ours and the paper's, mean and deviation.
std::string Number(double value) { return Fixed(value, 6); }

Status WriteTable4(std::span<const CellSummary> cells, const std::filesystem::path& path) {
  auto csv = CsvFile::Create(path, {"policy",
                                    "scene",
                                    "objects",
                                    "runs",
                                    "dominant",
                                    "dominant_runs",
                                    "switches_mean",
                                    "switches_sd",
                                    "active_percent_mean",
                                    "active_percent_sd",
                                    "mu_mean",
                                    "mu_sd",
                                    "n_mean",
                                    "n_sd",
                                    "paper_dominant",
                                    "paper_dominant_runs",
                                    "paper_switches_mean",
                                    "paper_switches_sd",
                                    "paper_active_percent_mean",
                                    "paper_active_percent_sd",
                                    "paper_mu_mean",
                                    "paper_mu_sd",
                                    "paper_n_mean",
                                    "paper_n_sd"});
  if (!csv.ok()) return csv.status();
  for (const CellSummary& cell : cells) {
    const PaperCell* paper = PaperOf(cell);
    const auto printed = [&](double PaperFigure::*part, PaperFigure PaperCell::*figure) {
      return paper == nullptr ? std::string() : Fixed(paper->*figure.*part, 3);
    };
    const auto mean = [&](PaperFigure PaperCell::*figure) {
      return printed(&PaperFigure::mean, figure);
    };
    const auto deviation = [&](PaperFigure PaperCell::*figure) {
      return printed(&PaperFigure::deviation, figure);
    };
    (*csv)->Row({cell.policy,
                 cell.cell.scene,
                 std::to_string(cell.cell.object_count),
                 std::to_string(cell.runs.size()),
                 cell.dominance.front().first,
                 std::to_string(cell.dominance.front().second),
                 Number(cell.switches.mean),
                 Number(cell.switches.deviation),
                 Number(cell.active_percent.mean),
                 Number(cell.active_percent.deviation),
                 Number(cell.posterior_mean.mean),
                 Number(cell.posterior_mean.deviation),
                 Number(cell.evidence.mean),
                 Number(cell.evidence.deviation),
                 paper == nullptr ? "" : paper->dominant,
                 paper == nullptr ? "" : std::to_string(paper->dominant_run_count),
                 mean(&PaperCell::switches),
                 deviation(&PaperCell::switches),
                 mean(&PaperCell::active_percent),
                 deviation(&PaperCell::active_percent),
                 mean(&PaperCell::posterior_mean),
                 deviation(&PaperCell::posterior_mean),
                 mean(&PaperCell::evidence),
                 deviation(&PaperCell::evidence)});
  }
  return (*csv)->Commit();
}

// The rows of each policy, which follow one another.
std::vector<std::span<const CellSummary>> ByPolicy(std::span<const CellSummary> cells) {
  std::vector<std::span<const CellSummary>> groups;
  for (size_t first = 0; first < cells.size();) {
    size_t end = first + 1;
    while (end < cells.size() && cells[end].policy == cells[first].policy) ++end;
    groups.push_back(cells.subspan(first, end - first));
    first = end;
  }
  return groups;
}

}  // namespace

std::string PaperSceneName(const std::string& scene) {
  if (scene == "brownian") return "Brownian";
  if (scene == "rotating-gravity") return "Rotating Grav";
  if (scene == "hurricane") return "Hurricane";
  return scene;
}

std::string SpreadText(const Spread& spread, int decimals) {
  const std::string mean = Fixed(spread.mean, decimals);
  return spread.count > 1 ? mean + "±" + Fixed(spread.deviation, decimals) : mean;
}

std::string PaperText(const PaperFigure& figure, int decimals) {
  return Fixed(figure.mean, decimals) + "±" + Fixed(figure.deviation, decimals);
}

void PrintTables(std::span<const CellSummary> cells, std::ostream& out) {
  for (const auto group : ByPolicy(cells)) {
    const std::string& policy = group.front().policy;
    out << "\nTable 3 with policy " << policy << ". Dominant algorithms across the runs.\n\n";
    PrintTable3(group, out);
    out << "\nTable 4 with policy " << policy
        << ". Switches over all runs; active time, μ* and n* over the dominant runs; mean ± sample "
           "standard deviation.\n\n";
    PrintTable4(group, out);
  }
}

Status WriteTables(std::span<const CellSummary> cells, const std::filesystem::path& folder) {
  if (Status status = WriteTable3(cells, folder / "table3.csv"); !status.ok()) return status;
  return WriteTable4(cells, folder / "table4.csv");
}

}  // namespace sweepstake::cli
