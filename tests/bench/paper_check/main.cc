// The program `paper_check`: is the policy `paper` the paper's? Its Table 4 beside what the real
// decision core gives.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "engine_client/cli/experiment/paper_tables.h"
#include "engine_client/cli/io/terminal.h"
#include "engine_client/cli/io/text_table.h"
#include "tests/bench/paper_check/paper_check.h"
#include "tests/bench/paper_check/paper_check_output.h"
#include "tests/bench/paper_check/paper_fit.h"

namespace sweepstake::cli {
namespace {

struct PaperCheckProgramOptions {
  PaperCheckOptions check{.seed_count = 100,
                          .thread_count = std::max(std::thread::hardware_concurrency(), 1U)};
  bool refit = false;
  bool json = false;
};

std::string PointText(const PaperFitPoint& point) {
  return "{" + Fixed(point.detection_ms, 4) + ", " + Fixed(point.gap_ms, 4) + ", " +
         Fixed(point.second_gap_ms, 4) + ", " + Fixed(point.rest_ms, 4) + ", " +
         Fixed(point.stall_ratio, 4) + ", " + Fixed(point.stall_period_s, 4) + "}";
}

// One cell after the other, each search on all threads.
std::vector<PaperCellFit> Refit(const PaperCheckOptions& options, Terminal& terminal) {
  std::vector<PaperCellFit> fits;
  for (const PaperCell& cell : PaperCells()) {
    const std::string name = std::string(cell.scene) + " " + std::to_string(cell.object_count);
    Progress progress(terminal, "refit " + name, 0);
    uint64_t tries = 0;
    const PaperFitPoint point =
        FindFit(cell, {.seed_count = kFitSeedCount, .thread_count = options.thread_count}, [&] {
          ++tries;
          progress.Show(tries, std::to_string(tries) + " points");
        });
    progress.Line(name + ": " + PointText(point));
    fits.push_back(ExpandFit(cell, point));
  }
  return fits;
}

int PaperCheck(const PaperCheckProgramOptions& options, Terminal& terminal) {
  const std::vector<PaperCellFit> fits =
      options.refit ? Refit(options.check, terminal) : PaperFits();
  std::vector<PaperCheckRow> rows;
  {
    const uint64_t game_count = fits.size() * options.check.seed_count;
    Progress progress(terminal, "paper_check", game_count);
    rows = CheckPaper(PaperCells(), fits, options.check, [&](uint64_t done) {
      if (progress.due()) {
        progress.Show(done, std::to_string(done) + " of " + std::to_string(game_count) + " runs");
      }
    });
  }
  if (options.json) {
    PrintPaperCheckJson(rows, options.check, terminal.out);
  } else {
    PrintPaperCheckTable(rows, options.check, terminal.out);
  }
  const bool all_match =
      std::all_of(rows.begin(), rows.end(), [](const PaperCheckRow& row) { return row.matches(); });
  return all_match ? kDone : kCheckFailed;
}

constexpr char kFooter[] =
    "Examples:\n"
    "  paper_check\n"
    "  paper_check --seeds 1000 --json\n"
    "  paper_check --refit\n"
    "The paper prints no costs of the arms. With costs fitted to each cell, the policy plays runs\n"
    "of exploration and 15 min in virtual time; its mean switches, active share, posterior mean\n"
    "and evidence of the dominant arm must all lie within the paper's mean ± 2 SD. Where the\n"
    "paper's SD is 0 (five equal whole numbers), within half a switch. Exit code 1 where one does\n"
    "not.\n";

int Run(int argc, char** argv) {
  CLI::App app("Compares the policy `paper` with the paper's Table 4", "paper_check");
  PaperCheckProgramOptions options;
  app.add_option("--seeds", options.check.seed_count, "Runs per cell")
      ->check(CLI::Range(uint32_t{1}, uint32_t{10'000}))
      ->capture_default_str();
  app.add_option("--threads", options.check.thread_count, "Threads; the result is the same")
      ->check(CLI::Range(uint32_t{1}, uint32_t{256}))
      ->capture_default_str();
  app.add_flag("--refit", options.refit,
               "Search for the arms' costs anew in place of the checked-in ones, and say them");
  app.add_flag("--json", options.json, "One JSON document on stdout");
  app.footer(kFooter);
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    return app.exit(error, std::cout, std::cerr) == 0 ? kDone : kBadUsage;
  }
  const bool is_tty = isatty(STDERR_FILENO) == 1;
  constexpr size_t kColumns = 80;
  Terminal terminal{.out = std::cout,
                    .err = std::cerr,
                    .out_is_tty = isatty(STDOUT_FILENO) == 1,
                    .err_is_tty = is_tty,
                    .err_columns = is_tty ? kColumns : 0};
  return PaperCheck(options, terminal);
}

}  // namespace
}  // namespace sweepstake::cli

int main(int argc, char** argv) { return sweepstake::cli::Run(argc, argv); }
