#include "tests/laboratory/laboratory.h"

#include <array>
#include <sstream>

#include "engine_client/cli/io/process.h"
#include "engine_client/cli/io/whole_file.h"
#include "tests/laboratory/experiment/experiment_output.h"
#include "tests/laboratory/experiment/experiment_run.h"
#include "tests/laboratory/io/report_file.h"

namespace sweepstake::cli {
namespace {

struct CommandOptions {
  ExperimentOptions experiment;
  std::string out;
  std::string resume;
  bool json = false;
};

// A new experiment, or the experiment that the folder already contains. `report` holds only the
// plan and the earlier sessions; Run adds the finished runs.
struct Opened {
  ExperimentFolder folder;
  ExperimentReport report;
};

Result<Opened> OpenExperiment(const CommandOptions& options) {
  if (options.out.empty() == options.resume.empty()) {
    return Status(StatusCode::kInvalidArgument,
                  "give either --out DIR for a new experiment, or --resume DIR to continue one");
  }
  Opened opened{ExperimentFolder(options.out.empty() ? options.resume : options.out), {}};
  ExperimentManifest manifest{options.experiment, {}};
  if (!options.resume.empty()) {
    auto read = opened.folder.ReadManifest();
    if (!read.ok()) return read.status();
    manifest = std::move(*read);
  }
  auto plan = MakePlan(manifest.options);
  if (!plan.ok()) return plan.status();
  opened.report.plan = std::move(*plan);
  opened.report.sessions = std::move(manifest.sessions);
  if (options.resume.empty()) {
    if (Status status = opened.folder.Create(); !status.ok()) return status;
  }
  return opened;
}

// Writes all outputs of the finished runs. If the program was built without the report's page, it
// writes no report.html; `sweepstake-lab report` of another build can write it later.
Status WriteResults(const ExperimentFolder& folder, const ExperimentReport& report,
                    Terminal& terminal) {
  const std::filesystem::path& path = folder.path();
  std::ostringstream text, json;
  PrintExperiment(report, path, text);
  PrintExperimentJson(report, path, json);
  Status status = WriteExperimentCsv(report, path);
  if (status.ok()) status = WriteWhole(path / "tables.txt", text.str());
  if (status.ok()) status = WriteWhole(path / "experiment.json", json.str());
  if (status.ok() && ReportPageStatus().ok()) {
    status = WriteReport(path / "report.html", std::array{json.str()}, terminal);
  }
  if (!status.ok()) return status;
  return folder.WriteManifest(report.plan, report.sessions, report.records.size());
}

// Makes the missing traces, plays the missing runs, and compares all runs with the traces.
Status Run(const ExperimentFolder& folder, ExperimentReport& report, Terminal& terminal) {
  // The manifest is written before the first run, so that an experiment that is killed can be
  // resumed.
  Status status = folder.WriteManifest(report.plan, report.sessions, 0);
  if (!status.ok()) return status;
  InstallStopSignal();
  status = TraceCells(report.plan, folder, Progress(terminal, "trace").OnShare());
  if (!status.ok()) return status;
  {
    Progress progress(terminal, "experiment");
    status = PlayGrid(report.plan, folder, OnShareWithTimeLeft(progress));
    if (!status.ok()) return status;
  }
  report.machine = DescribeMachine();
  report.records = folder.ReadRecords(report.plan);
  report.cells = SummarizeCells(report.plan, report.records);
  auto truths = Assess(report.plan, folder, report.cells, Progress(terminal, "replay").OnShare());
  if (!truths.ok()) return truths.status();
  report.truths = std::move(*truths);
  report.sessions.back().end_utc = DescribeMachine().date_utc;
  return WriteResults(folder, report, terminal);
}

int RunExperiment(const CommandOptions& options, const std::string& command_line,
                  Terminal& terminal) {
  auto opened = OpenExperiment(options);
  if (!opened.ok()) return Fail(terminal, opened.status());
  auto& [folder, report] = *opened;
  if (const Status page = ReportPageStatus(); !page.ok()) Say(terminal, page.message());
  report.sessions.push_back({command_line, DescribeMachine().date_utc, ""});
  if (Status status = Run(folder, report, terminal); !status.ok()) return Fail(terminal, status);
  if (options.json) {
    PrintExperimentJson(report, folder.path(), terminal.out);
  } else {
    PrintExperiment(report, folder.path(), terminal.out);
  }
  return report.complete() ? kDone : kCheckFailed;
}

void Declare(CLI::App& command, CommandOptions& options) {
  ExperimentOptions& experiment = options.experiment;
  command.add_option("--out", options.out, "Folder of all results; created if it is missing");
  command.add_option(
      "--resume", options.resume,
      "Folder of an interrupted experiment; its missing runs are played with its own "
      "options");
  command
      .add_option(
          "--grid", experiment.grid,
          "Default cells: paper (its grid and two larger object counts), or crossovers "
          "(resting, teleporting, storm, clustered and growing scenes up to 100,000 objects)")
      ->check(OneOf(kExperimentGrids));
  command.add_option(
      "--other-work", experiment.other_work,
      "Work of the game in each frame besides the search, such as 2ms (default: none)");
  command
      .add_option(
          "--time-scale", experiment.time_scale,
          "Divisor of the window and of all intervals of the decider except the bail-out limit")
      ->check(RealFrom(1.0, 1000.0));
  command.add_option("--runs", experiment.run_count, "Runs of each cell and policy (default: 5)")
      ->check(CLI::Range(uint32_t{1}, uint32_t{1000}));
  command
      .add_option("--scenes", experiment.scenes,
                  "Scenes or .aabbs files (default: those of the grid)")
      ->delimiter(',');
  command
      .add_option("--objects", experiment.object_counts,
                  "Object counts (default: those of the grid)")
      ->check(CLI::Range(1U, 1'000'000U))
      ->delimiter(',');
  command
      .add_option("--policies", experiment.policies,
                  "Policies, including ablations such as adaptive-without-gate (default: "
                  "paper,default)")
      ->delimiter(',');
  command.add_option(
      "--window", experiment.window,
      "Length of the observation after the exploration, before scaling (default: 15m)");
  command
      .add_option(
          "--trace-frames", experiment.trace_frame_count,
          "Frames of each scene on which every arm is timed (default: 360; 240 with --quick, "
          "800 with --grid crossovers)")
      ->check(CLI::Range(uint32_t{64}, uint32_t{100'000}));
  command
      .add_option("--replay-seeds", experiment.replay_seed_count,
                  "Games of each policy on each trace (default: 30; 10 with --quick)")
      ->check(CLI::Range(uint32_t{2}, uint32_t{10'000}));
  command.add_option("--seed", experiment.seed, "Seed from which all other seeds are derived")
      ->check(NotNegative());
  AddDecisionOptions(command, experiment.decision);
  command.add_flag("--quick", experiment.quick,
                   "Run only cells with 1000 and 3000 objects, once each, as a quick test");
  AddJsonFlag(command, options.json);
}

}  // namespace

void AddExperimentCommand(const CommandContext& context) {
  AddCommand<CommandOptions>(
      context, "experiment",
      "Play the paper's grid live and write its tables, raw data and a report",
      "  sweepstake-lab experiment --time-scale 60 --out results\n"
      "  sweepstake-lab experiment --time-scale 60 --quick --out quick\n"
      "  sweepstake-lab experiment --scenes hurricane --objects 3000,10000 --policies paper --out "
      "h\n"
      "  sweepstake-lab experiment --grid crossovers --other-work 2ms --time-scale 30 --out c\n"
      "  sweepstake-lab experiment --resume results\n"
      "Default: 3 scenes × (1000, 2000, 3000, 10000, 50000 objects) × 2 policies × 5 runs with "
      "fixed\n"
      "seeds. A run lasts for the exploration and 15 minutes, both divided by the time scale.\n"
      "Ctrl-C writes partial results and ends with exit code 1; --resume continues after the\n"
      "finished runs.\n"
      "Keep the machine free of other work, which distorts the figures.",
      Declare,
      [command_line = context.command_line](const CommandOptions& options, Terminal& terminal) {
        return RunExperiment(options, command_line, terminal);
      });
}

}  // namespace sweepstake::cli
