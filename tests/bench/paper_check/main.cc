// The program `paper_check` compares Tables 3 and 4 of the paper with predictions, which the real
// decision core makes with the policy `paper`.

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <iostream>
#include <string>
#include <thread>
#include <vector>

#include "engine_client/cli/io/terminal.h"
#include "tests/bench/paper_check/paper_check.h"
#include "tests/bench/paper_check/paper_check_output.h"

namespace sweepstake::cli {
namespace {

int PaperCheck(const PaperCheckOptions& options, bool json, Terminal& terminal) {
  const std::vector<PaperRules> rules = PaperRulesToCheck();
  std::vector<PaperPrediction> predictions;
  {
    const uint64_t count = rules.size() * PaperCells().size();
    Progress progress(terminal, "paper_check", count);
    predictions = CheckPaper(rules, PaperCells(), options, [&](uint64_t done) {
      progress.Show(done, std::to_string(done) + " of " + std::to_string(count) + " predictions");
    });
  }
  const PaperReport report = ReportOf(predictions);
  if (json) {
    PrintPaperCheckJson(report, options, terminal.out);
  } else {
    PrintPaperCheckTable(report, options, terminal.out);
  }
  const bool beats_random = ScoreOf(report.paper).distance < ScoreOf(report.random).distance;
  return beats_random ? kDone : kCheckFailed;
}

constexpr char kFooter[] =
    "Examples:\n"
    "  paper_check\n"
    "  paper_check --seeds 1000 --json\n"
    "The paper gives no costs of the arms. For each cell, the costs of the dominant arm and of "
    "all\n"
    "others are fitted to its μ* and active share. Runs of exploration and 15 min in virtual time\n"
    "then predict switches, n* and dominance. They are compared with Tables 3 and 4 in standard\n"
    "errors of five runs. The same is done for the policy random, and for the policy paper with\n"
    "minimum numbers of samples per window. Exit code 1: random predicts better.\n";

int Run(int argc, char** argv) {
  CLI::App app("Predicts the paper's Tables 3 and 4 with the policy `paper`", "paper_check");
  PaperCheckOptions options{.thread_count = std::max(std::thread::hardware_concurrency(), 1U)};
  bool json = false;
  app.add_option("--seeds", options.seed_count, "Runs per cell")
      ->check(CLI::Range(uint32_t{1}, uint32_t{10'000}))
      ->capture_default_str();
  app.add_option("--threads", options.thread_count, "Threads; the result is the same")
      ->check(CLI::Range(uint32_t{1}, uint32_t{256}))
      ->capture_default_str();
  app.add_flag("--json", json, "One JSON document on stdout");
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
  return PaperCheck(options, json, terminal);
}

}  // namespace
}  // namespace sweepstake::cli

int main(int argc, char** argv) { return sweepstake::cli::Run(argc, argv); }
