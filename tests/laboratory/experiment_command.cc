#include "tests/laboratory/laboratory.h"

#include <array>
#include <sstream>

#include "engine_client/cli/io/stop_signal.h"
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
  std::string report;
  bool json = false;
};

// A new experiment, or the one that the folder already contains.
struct Opened {
  ExperimentFolder folder;
  ExperimentPlan plan;
  std::vector<ExperimentSession> sessions;
};

Result<Opened> OpenExperiment(const CommandOptions& options) {
  if (options.out.empty() == options.resume.empty()) {
    return Status(StatusCode::kInvalidArgument,
                  "give either --out DIR for a new experiment, or --resume DIR to continue one");
  }
  const ExperimentFolder folder(options.out.empty() ? options.resume : options.out);
  ExperimentManifest manifest{options.experiment, {}};
  if (!options.resume.empty()) {
    auto read = folder.ReadManifest();
    if (!read.ok()) return read.status();
    manifest = std::move(*read);
  }
  auto plan = MakePlan(manifest.options);
  if (!plan.ok()) return plan.status();
  if (options.resume.empty()) {
    if (Status status = folder.Create(); !status.ok()) return status;
  }
  return Opened{folder, std::move(*plan), std::move(manifest.sessions)};
}

std::filesystem::path ReportPath(const CommandOptions& options, const ExperimentFolder& folder) {
  if (!options.report.empty()) return options.report;
  return folder.path() / "report.html";
}

Status WriteText(const std::string& text, const std::filesystem::path& path) {
  auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  (*file)->Write(text);
  return (*file)->Commit();
}

// Writes all outputs of the finished runs; without a report if `page` is null.
Status WriteResults(const ExperimentFolder& folder, const ExperimentReport& report,
                    ReportFile* page, Terminal& terminal) {
  const std::filesystem::path& path = folder.path();
  std::ostringstream text, json;
  PrintExperiment(report, path, text);
  PrintExperimentJson(report, path, json);
  Status status = WriteExperimentCsv(report, path);
  if (status.ok()) status = WriteText(text.str(), path / "tables.txt");
  if (status.ok()) status = WriteText(json.str(), path / "experiment.json");
  if (status.ok() && page != nullptr) status = page->Commit(std::array{json.str()}, terminal);
  if (!status.ok()) return status;
  return folder.WriteManifest(ManifestJson(report.plan, report.sessions, report.records.size()));
}

Result<ExperimentReport> MakeReport(Opened opened, Terminal& terminal) {
  ExperimentReport report;
  report.machine = DescribeMachine();
  report.records = opened.folder.ReadRecords(opened.plan);
  report.cells = SummarizeCells(opened.plan, report.records);
  auto truths =
      Assess(opened.plan, opened.folder, report.cells, Progress(terminal, "replay").OnShare());
  if (!truths.ok()) return truths.status();
  report.truths = std::move(*truths);
  report.plan = std::move(opened.plan);
  report.sessions = std::move(opened.sessions);
  report.sessions.back().end_utc = DescribeMachine().date_utc;
  return report;
}

int Finish(const CommandOptions& options, Opened opened, ReportFile* page, Terminal& terminal) {
  const ExperimentFolder folder = opened.folder;
  const auto report = MakeReport(std::move(opened), terminal);
  if (!report.ok()) return Fail(terminal, report.status());
  const Status status = WriteResults(folder, *report, page, terminal);
  if (!status.ok()) return Fail(terminal, status);
  if (options.json) {
    PrintExperimentJson(*report, folder.path(), terminal.out);
  } else {
    PrintExperiment(*report, folder.path(), terminal.out);
  }
  return report->complete() ? kDone : kCheckFailed;
}

int RunExperiment(const CommandOptions& options, const std::string& command_line,
                  Terminal& terminal) {
  auto opened = OpenExperiment(options);
  if (!opened.ok()) return Fail(terminal, opened.status());
  const auto page = ReportFile::Create(ReportPath(options, opened->folder).string());
  if (!page.ok()) {
    const int exit_code = Fail(terminal, page.status());
    // Without --report, a missing report page is not an error: `sweepstake-lab report` can make the
    // report later.
    if (!options.report.empty()) return exit_code;
  }
  opened->sessions.push_back({command_line, DescribeMachine().date_utc, ""});
  // The manifest is written before the first run, so that an experiment that is killed can be
  // resumed.
  Status status = opened->folder.WriteManifest(ManifestJson(opened->plan, opened->sessions, 0));
  if (!status.ok()) return Fail(terminal, status);
  InstallStopSignal();
  status = TraceCells(opened->plan, opened->folder, Progress(terminal, "trace").OnShare());
  if (status.ok()) {
    status = PlayGrid(opened->plan, opened->folder, Progress(terminal, "experiment").OnShare());
  }
  if (!status.ok()) return Fail(terminal, status);
  return Finish(options, std::move(*opened), page.ok() ? page->get() : nullptr, terminal);
}

void Declare(CLI::App& command, CommandOptions& options) {
  ExperimentOptions& experiment = options.experiment;
  command.add_option("--out", options.out, "Folder of all results; created if it is missing");
  command.add_option("--resume", options.resume,
                     "Folder of an interrupted experiment: continues with the missing runs and its "
                     "own options");
  command
      .add_option("--time-scale", experiment.time_scale,
                  "Divides the window and all intervals of the decider except the bail-out limit")
      ->check(RealFrom(1.0, 1000.0))
      ->capture_default_str();
  command.add_option("--runs", experiment.run_count, "Runs of each cell and policy (default: 5)")
      ->check(CLI::Range(uint32_t{1}, uint32_t{1000}));
  command
      .add_option("--scenes", experiment.scenes,
                  "Scenes or .aabbs files (default: brownian,rotating-gravity,hurricane)")
      ->delimiter(',');
  command
      .add_option("--objects", experiment.object_counts, "Object counts (default: 1000,2000,3000)")
      ->check(CLI::Range(1U, 1'000'000U))
      ->delimiter(',');
  command
      .add_option("--sizes-beyond", experiment.large_object_counts,
                  "More object counts, beyond the paper's (default: 10000,50000; none if "
                  "--objects is given)")
      ->delimiter(',');
  command
      .add_option("--policies", experiment.policies,
                  "Policies, also adaptive-without-... (default: paper,default)")
      ->delimiter(',');
  command.add_option(
      "--window", experiment.window,
      "Length of the observation after the exploration, before scaling (default: 15m)");
  command
      .add_option("--trace-frames", experiment.trace_frame_count,
                  "Frames of each scene on which every arm is timed (default: 600)")
      ->check(CLI::Range(uint32_t{64}, uint32_t{100'000}));
  command
      .add_option("--replay-seeds", experiment.replay_seed_count,
                  "Games of each policy on each trace (default: 30)")
      ->check(CLI::Range(uint32_t{2}, uint32_t{10'000}));
  command.add_option("--seed", experiment.seed, "Seed from which all other seeds are derived")
      ->check(NotNegative())
      ->capture_default_str();
  command.add_flag("--quick", experiment.quick,
                   "Run only six cells (1000 and 3000 objects) once each, as a quick test");
  command.add_flag("--frames", experiment.frames, "Write the metrics of every frame, some GB");
  command.add_option("--report", options.report,
                     "Charts and tables as one HTML file (default: report.html in the folder)");
  command.add_flag("--json", options.json, "One JSON document on stdout");
}

}  // namespace

void AddExperimentCommand(CLI::App& app, Terminal& terminal, const std::string& command_line,
                          int& exit_code) {
  AddCommand<CommandOptions>(
      app, "experiment", "Play the paper's grid live and write its tables, raw data and a report",
      "  sweepstake-lab experiment --time-scale 60 --out results\n"
      "  sweepstake-lab experiment --time-scale 60 --quick --out quick\n"
      "  sweepstake-lab experiment --scenes hurricane --objects 3000,10000 --policies paper --out "
      "h\n"
      "  sweepstake-lab experiment --resume results\n"
      "Default: 3 scenes × (1000, 2000, 3000, 10000, 50000 objects) × 2 policies × 5 runs with "
      "fixed\n"
      "seeds. A run is the exploration and 15 minutes, divided by the time scale. Ctrl-C writes\n"
      "partial results and ends with exit code 1; --resume continues after the finished runs.\n"
      "Keep the machine free of other work, which distorts the figures.",
      exit_code, Declare, [&terminal, command_line](const CommandOptions& options) {
        return RunExperiment(options, command_line, terminal);
      });
}

}  // namespace sweepstake::cli
