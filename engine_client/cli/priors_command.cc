// `sweepstake priors list|export|import`: a daemon's evidence to look at, to ship with a game, and
// to carry to another daemon.
#include <nlohmann/json.hpp>

#include "engine_client/cli/commands.h"
#include "engine_client/cli/daemon/posterior_view.h"
#include "engine_client/cli/daemon/posteriors_transfer.h"
#include "engine_client/cli/daemon/priors_transfer.h"
#include "engine_client/cli/io/json_output.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

struct PriorsOptions {
  DaemonOptions daemon;
  std::string project;
  std::string scene;
  std::string file;
  bool json = false;
};

int RunList(const PriorsOptions& options, Terminal& terminal) {
  const auto scenes = ListPosteriors(options.daemon, options.project, options.scene);
  if (!scenes.ok()) return Fail(terminal, scenes.status());
  const Json document = {{"command", "priors list"}, {"scenes", PosteriorsJson(*scenes)}};
  PrintResult(terminal, options.json, document, PosteriorsText(*scenes));
  return kDone;
}

int RunExport(const PriorsOptions& options, Terminal& terminal) {
  const auto records = ExportPriors(options.daemon, options.project, options.scene);
  if (!records.ok()) return Fail(terminal, records.status());
  const Status written = WritePriorsFile(*records, options.file);
  if (!written.ok()) {
    return Fail(terminal, Status(StatusCode::kInvalidArgument, written.message()));
  }
  PrintResult(terminal, options.json,
              {{"command", "priors export"}, {"file", options.file}, {"records", records->size()}},
              options.file + ": " + std::to_string(records->size()) + " records\n");
  return kDone;
}

int RunImport(const PriorsOptions& options, Terminal& terminal) {
  const auto records = ReadPriorsFile(options.file);
  if (!records.ok()) return Fail(terminal, records.status());
  const auto result = ImportPriors(options.daemon, *records);
  if (!result.ok()) return Fail(terminal, result.status());
  const Json document = {{"command", "priors import"},
                         {"file", options.file},
                         {"records", records->size()},
                         {"applied", result->applied_count},
                         {"unchanged", result->unchanged_count}};
  PrintResult(terminal, options.json, document,
              options.file + ": " + std::to_string(result->applied_count) + " of " +
                  std::to_string(records->size()) + " records were new or newer, " +
                  std::to_string(result->unchanged_count) + " were known already\n");
  return kDone;
}

void DeclareCommon(CLI::App& command, PriorsOptions& options) {
  AddDaemonOptions(command, options.daemon);
  AddJsonFlag(command, options.json);
}

void DeclareFilter(CLI::App& command, PriorsOptions& options) {
  command.add_option("--project", options.project, "Only this project");
  command.add_option("--scene", options.scene, "Only this scene");
}

}  // namespace

void AddPriorsCommand(CLI::App& app, Terminal& terminal, int& exit_code) {
  CLI::App* priors = app.add_subcommand("priors", "List, export and import a daemon's evidence");
  priors->require_subcommand(1);
  priors->footer(
      "Examples:\n"
      "  sweepstake priors list --daemon 127.0.0.1:7433\n"
      "  sweepstake priors export --daemon 127.0.0.1:7433 --out priors.json");
  AddCommand<PriorsOptions>(
      *priors, "list", "Show every scene's posteriors",
      "  sweepstake priors list --daemon 127.0.0.1:7433 --project quickstart\n", exit_code,
      [](CLI::App& command, PriorsOptions& options) {
        DeclareCommon(command, options);
        DeclareFilter(command, options);
      },
      [&terminal](const PriorsOptions& options) { return RunList(options, terminal); });
  AddCommand<PriorsOptions>(
      *priors, "export", "Write the evidence as a priors file, for games and other daemons",
      "  sweepstake priors export --daemon 127.0.0.1:7433 --out priors.json\n"
      "  sweepstake run --scene hurricane --objects 3000 --embedded --priors priors.json\n",
      exit_code,
      [](CLI::App& command, PriorsOptions& options) {
        DeclareCommon(command, options);
        DeclareFilter(command, options);
        command.add_option("--out", options.file, "File to write")->required();
      },
      [&terminal](const PriorsOptions& options) { return RunExport(options, terminal); });
  AddCommand<PriorsOptions>(
      *priors, "import", "Add a priors file to a daemon's evidence; twice changes nothing",
      "  sweepstake priors import --daemon 127.0.0.1:7433 --in priors.json\n", exit_code,
      [](CLI::App& command, PriorsOptions& options) {
        DeclareCommon(command, options);
        command.add_option("--in", options.file, "File to read")->required();
      },
      [&terminal](const PriorsOptions& options) { return RunImport(options, terminal); });
}

}  // namespace sweepstake::cli
