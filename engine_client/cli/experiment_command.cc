#include "engine_client/cli/commands.h"

#include <nlohmann/json.hpp>
#include <sstream>

#include "engine_client/cli/bench/bench_machine.h"
#include "engine_client/cli/experiment/experiment_assessment.h"
#include "engine_client/cli/experiment/experiment_csv.h"
#include "engine_client/cli/experiment/experiment_folder.h"
#include "engine_client/cli/experiment/experiment_grid.h"
#include "engine_client/cli/experiment/experiment_html.h"
#include "engine_client/cli/experiment/experiment_report.h"
#include "engine_client/cli/experiment/experiment_tables.h"
#include "engine_client/cli/experiment/experiment_truth_output.h"
#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/stop_signal.h"
#include "engine_client/cli/io/whole_file.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

struct CommandOptions {
  ExperimentOptions experiment;
  std::string out;
  std::string resume;
  bool json = false;
};

// What is under way: a new experiment, or the one in the folder.
struct Opened {
  ExperimentFolder folder;
  ExperimentPlan plan;
  std::vector<ExperimentSitting> sittings;
};

Result<Opened> OpenExperiment(const CommandOptions& options) {
  if (options.out.empty() == options.resume.empty()) {
    return Status(StatusCode::kInvalidArgument,
                  "give either --out DIR for a new experiment, or --resume DIR to go on with one");
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
  return Opened{folder, std::move(*plan), std::move(manifest.sittings)};
}

Status WriteText(const std::string& text, const std::filesystem::path& path) {
  auto file = WholeFile::Create(path);
  if (!file.ok()) return file.status();
  (*file)->Write(text);
  return (*file)->Commit();
}

// A flat row per cell and policy.
Json CellJson(const ExperimentReport& report, const CellSummary& cell) {
  Json row = {{"policy", cell.policy},
              {"scene", cell.cell.scene},
              {"objects", cell.cell.object_count},
              {"runs", cell.runs.size()},
              {"dominance", cell.DominanceText()},
              {"dominant", cell.dominance.front().first},
              {"verdict", VerdictName(cell.verdict)},
              {"switches", cell.switches.mean},
              {"switches_sd", cell.switches.deviation},
              {"active_percent", cell.active_percent.mean},
              {"active_percent_sd", cell.active_percent.deviation},
              {"mu", cell.posterior_mean.mean},
              {"mu_sd", cell.posterior_mean.deviation},
              {"n", cell.evidence.mean},
              {"n_sd", cell.evidence.deviation}};
  const CellTruth* truth = report.TruthOf(cell.cell);
  if (truth == nullptr) return row;
  row["truly_fastest"] = truth->ranking.front().arm;
  for (const ReplayedPlayer& player : truth->players) {
    if (player.name == OwnPolicyName(cell.policy)) row["replay_regret"] = player.regret;
  }
  for (const Agreement& each : truth->agreements) {
    if (each.policy != cell.policy) continue;
    row["live_regret"] = each.regret;
    row["live_regret_agrees"] = each.regret_agrees();
    row["active_share_agrees"] = each.share_agrees();
  }
  return row;
}

Json SummaryJson(const ExperimentFolder& folder, const ExperimentReport& report) {
  Json document = {{"command", "experiment"},
                   {"folder", folder.path().string()},
                   {"complete", report.complete()},
                   {"finished_runs", report.records.size()},
                   {"planned_runs", report.plan.runs.size()},
                   {"time_scale", report.plan.options.time_scale},
                   {"rows", Json::array()}};
  for (const CellSummary& cell : report.cells) document["rows"].push_back(CellJson(report, cell));
  return document;
}

// All that is made of the runs that are there.
Status WriteResults(const ExperimentFolder& folder, const ExperimentReport& report,
                    const std::string& text, const std::string& json) {
  const std::filesystem::path& path = folder.path();
  Status status = WriteTables(report.cells, path);
  if (status.ok()) status = WriteText(text, path / "tables.txt");
  if (status.ok()) status = WriteRawCsv(report.records, path);
  if (status.ok()) status = WriteTruthCsv(report, path);
  if (status.ok()) status = WriteText(ExperimentHtml(report, json), path / "report.html");
  if (!status.ok()) return status;
  return folder.WriteManifest(ManifestJson(report.plan, report.sittings, report.records.size()));
}

std::string Text(const ExperimentFolder& folder, const ExperimentReport& report) {
  std::ostringstream text;
  if (!report.complete()) {
    text << "PARTIAL: " << report.records.size() << " of " << report.plan.runs.size()
         << " runs; --resume " << folder.path().string() << " goes on with it\n";
  }
  PrintTables(report.cells, text);
  PrintTruth(report, text);
  return text.str();
}

int Finish(const CommandOptions& options, Opened opened, Terminal& terminal) {
  ExperimentReport report;
  report.machine = DescribeMachine({});
  report.records = opened.folder.ReadRecords(opened.plan);
  report.cells = SummarizeCells(opened.plan, report.records);
  report.plan = std::move(opened.plan);
  report.sittings = std::move(opened.sittings);
  Status status = Assess(opened.folder, terminal, report);
  report.sittings.back().end_utc = DescribeMachine({}).date_utc;
  const std::string text = Text(opened.folder, report);
  std::ostringstream json;
  PrintJson(SummaryJson(opened.folder, report), json);
  if (status.ok()) status = WriteResults(opened.folder, report, text, json.str());
  if (!status.ok()) return Fail(terminal, status);
  terminal.out << (options.json ? json.str() : text);
  terminal.err << "The report is " << (opened.folder.path() / "report.html").string()
               << "; all else lies beside it\n";
  return report.complete() ? kDone : kCheckFailed;
}

int RunExperiment(const CommandOptions& options, const std::string& command_line,
                  Terminal& terminal) {
  auto opened = OpenExperiment(options);
  if (!opened.ok()) return Fail(terminal, opened.status());
  opened->sittings.push_back({command_line, DescribeMachine({}).date_utc, ""});
  // Written before the first run, so that an experiment that is killed can be gone on with.
  Status status = opened->folder.WriteManifest(ManifestJson(opened->plan, opened->sittings, 0));
  if (!status.ok()) return Fail(terminal, status);
  InstallStopSignal();
  status = TraceCells(opened->plan, opened->folder, terminal);
  if (status.ok()) status = PlayGrid(opened->plan, opened->folder, terminal);
  if (!status.ok()) return Fail(terminal, status);
  return Finish(options, std::move(*opened), terminal);
}

void Declare(CLI::App& command, CommandOptions& options) {
  ExperimentOptions& experiment = options.experiment;
  command.add_option("--out", options.out, "Folder for everything; made where it is not there");
  command.add_option("--resume", options.resume,
                     "Folder of an experiment that was ended: goes on with what is missing, as it "
                     "was asked for");
  command
      .add_option("--time-scale", experiment.time_scale,
                  "Divides the window and every interval of the decider but the bail-out limit")
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
                  "More object counts, beyond the paper's (default: 10000,50000; none where "
                  "--objects is given)")
      ->delimiter(',');
  command.add_option("--policies", experiment.policies, "Policies (default: paper,default)")
      ->delimiter(',');
  command.add_option("--window", experiment.window,
                     "Observed after the exploration, before the scale (default: 15m)");
  command
      .add_option("--trace-frames", experiment.trace_frame_count,
                  "Frames of each scene on which every arm is timed (default: 600)")
      ->check(CLI::Range(uint32_t{64}, uint32_t{100'000}));
  command
      .add_option("--replay-seeds", experiment.replay_seed_count,
                  "Games of each policy on each trace (default: 30)")
      ->check(CLI::Range(uint32_t{2}, uint32_t{10'000}));
  command.add_option("--seed", experiment.seed, "All seeds come from this one")
      ->check(NotNegative())
      ->capture_default_str();
  command.add_flag("--quick", experiment.quick,
                   "Six cells (1000 and 3000 objects) and one run of each, to see that it works");
  command.add_flag("--frames", experiment.frames, "Keep every frame's metrics, some GB");
  command.add_flag("--json", options.json, "One JSON document on stdout");
}

}  // namespace

void AddExperimentCommand(CLI::App& app, Terminal& terminal, const std::string& command_line,
                          int& exit_code) {
  AddCommand<CommandOptions>(
      app, "experiment", "Play the paper's grid live and write its tables, raw data and a report",
      "  sweepstake experiment --time-scale 60 --out results\n"
      "  sweepstake experiment --time-scale 60 --quick --out quick\n"
      "  sweepstake experiment --scenes hurricane --objects 3000,10000 --policies paper --out h\n"
      "  sweepstake experiment --resume results\n"
      "3 scenes × (1000, 2000, 3000, 10000, 50000 objects) × 2 policies × 5 runs of exploration "
      "and "
      "15 minutes,\n"
      "divided by the time scale, with seeds that are fixed. Ctrl-C ends with what is there, "
      "marked "
      "as partial, and\n"
      "exit code 1; each finished run is on disk, and --resume goes on. Leave the machine alone "
      "meanwhile: what\n"
      "disturbs it disturbs the figures.",
      exit_code, Declare, [&terminal, command_line](const CommandOptions& options) {
        return RunExperiment(options, command_line, terminal);
      });
}

}  // namespace sweepstake::cli
