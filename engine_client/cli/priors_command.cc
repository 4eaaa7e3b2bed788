// `sweepstake priors list|export|import|promote|revoke`: a daemon's evidence to look at, to ship
// with a game, to carry to another daemon, where it waits to be promoted, and to take out again.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "engine_client/cli/commands.h"
#include "engine_client/cli/daemon/posterior_view.h"
#include "engine_client/cli/daemon/posteriors_transfer.h"
#include "engine_client/cli/daemon/priors_transfer.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/priors/priors_diff.h"
#include "engine_client/decider/embedded/priors_sums.h"

namespace sweepstake::cli {
namespace {

using Json = nlohmann::ordered_json;

struct PriorsOptions {
  DaemonOptions daemon;
  std::string project;
  std::string scene;
  std::string file;
  SourceChoice sources;
  bool sums = false;
  bool promote = false;
  bool yes = false;
  bool json = false;
};

std::string QuarantinedText(const PriorsGroups& groups) {
  if (groups.empty()) return "";
  return "\nImports that wait, and count once they are promoted (`sweepstake priors promote`):\n" +
         ShowText(groups);
}

int RunList(const PriorsOptions& options, Terminal& terminal) {
  const auto scenes = ListPosteriors(options.daemon, options.project, options.scene);
  if (!scenes.ok()) return FailAnswer(terminal, scenes.status());
  const auto waiting =
      ExportPriors(options.daemon, options.project, options.scene, Exported::kQuarantined);
  if (!waiting.ok()) return FailAnswer(terminal, waiting.status());
  const PriorsGroups quarantined = GroupPriors(*waiting);
  const Json document = {{"command", "priors list"},
                         {"daemon", options.daemon.address},
                         {"scenes", PosteriorsJson(*scenes)},
                         {"quarantined", ShowJson(quarantined)}};
  PrintResult(terminal, options.json, document,
              PosteriorsText(*scenes) + QuarantinedText(quarantined));
  return kDone;
}

std::string DescribeWaiting(uint64_t count) {
  if (count == 0) return "";
  return std::to_string(count) +
         " records wait in quarantine, of which there are no sums (`sweepstake priors promote`)";
}

// A file that is to be written.
struct ExportText {
  std::string text = {};
  uint64_t count = 0;          // of the records or sums in it
  uint64_t waiting_count = 0;  // of records that wait in quarantine and are left out
};

Result<ExportText> TextOfSums(const PriorsOptions& options) {
  SumsWriter sums;
  ExportText file;
  const Status status = StreamPriors(options.daemon, options.project, options.scene, Exported::kAll,
                                     [&](PriorRecord record) {
                                       if (record.is_quarantined) ++file.waiting_count;
                                       sums.Add(std::move(record));
                                     });
  if (!status.ok()) return status;
  file.text = sums.Finish(file.count);
  return file;
}

Result<ExportText> TextOfRecords(const PriorsOptions& options) {
  const auto records = ExportPriors(options.daemon, options.project, options.scene);
  if (!records.ok()) return records.status();
  return ExportText{FormatPriors(*records), records->size()};
}

int RunExport(const PriorsOptions& options, Terminal& terminal) {
  const auto file = options.sums ? TextOfSums(options) : TextOfRecords(options);
  if (!file.ok()) return FailAnswer(terminal, file.status());
  const std::string waiting = DescribeWaiting(file->waiting_count);
  const bool leaves_some =
      !options.project.empty() || !options.scene.empty() || file->waiting_count > 0;
  if (leaves_some && file->count == 0) {
    const std::string none = options.sums ? "no such records that count" : "no such records";
    return FailAnswer(terminal,
                      Status(StatusCode::kNotFound,
                             "the daemon has " + none + ", and " + options.file +
                                 " is left as it was; `sweepstake priors list` shows which it has" +
                                 (waiting.empty() ? "" : "; " + waiting)));
  }
  const Status written = WritePriorsText(file->text, options.file);
  if (!written.ok()) {
    return Fail(terminal, Status(StatusCode::kInvalidArgument, written.message()));
  }
  const Json document = {{"command", "priors export"},
                         {"file", options.file},
                         {"records", file->count},
                         {"sums", options.sums},
                         {"left_waiting", file->waiting_count}};
  PrintResult(terminal, options.json, document,
              options.file + ": " + std::to_string(file->count) +
                  (options.sums ? " sums of builds\n" : " records\n") + waiting +
                  (waiting.empty() ? "" : "\n"));
  return kDone;
}

std::string AbsentText(uint64_t count) {
  if (count == 0) return "";
  return std::to_string(count) +
         " of these are not there under their project and scene: the daemon knows their sources "
         "under others, and a source is never counted twice, or has revoked them\n";
}

std::string SumsText(uint64_t count) {
  if (count == 0) return "";
  return std::to_string(count) +
         " sums of builds were left out: a daemon cannot know what it has of them already\n";
}

std::string WaitsText(const PriorsOptions& options, const ImportResult& result) {
  if (options.promote || result.applied_count == 0) return "";
  return "they wait in quarantine, and count once `sweepstake priors promote` lets them\n";
}

int RunImport(const PriorsOptions& options, Terminal& terminal) {
  auto records = ReadPriorsFile(options.file);
  if (!records.ok()) return Fail(terminal, records.status());
  const uint64_t sum_count = std::erase_if(*records, IsSum);
  if (records->empty() && sum_count > 0) {
    return Fail(terminal,
                Status(StatusCode::kInvalidArgument,
                       options.file + " has nothing but sums of builds, of which a daemon cannot "
                                      "know what it has already: export it without --sums"));
  }
  const auto result = ImportPriors(options.daemon, *records, options.promote);
  if (!result.ok()) return FailAnswer(terminal, result.status());
  const Json document = {{"command", "priors import"},           {"file", options.file},
                         {"records", records->size()},           {"applied", result->applied_count},
                         {"unchanged", result->unchanged_count}, {"absent", result->absent_count},
                         {"promoted", options.promote},          {"sums", sum_count}};
  PrintResult(terminal, options.json, document,
              options.file + ": " + std::to_string(result->applied_count) + " of " +
                  std::to_string(records->size()) + " records were new or newer, " +
                  std::to_string(result->unchanged_count) + " were known already\n" +
                  WaitsText(options, *result) + AbsentText(result->absent_count) +
                  SumsText(sum_count));
  return kDone;
}

// Of what was, or would be, revoked or promoted.
template <typename Result>
std::string CountsText(const Result& result) {
  return std::to_string(result.source_count) + " sources with " +
         std::to_string(result.record_count) + " records of " +
         std::to_string(result.window_count) + " windows and visits";
}

std::string DoneText(const PriorsOptions& options, const std::string& done) {
  return options.yes ? " were " + done + "\n" : " would be " + done + "; say --yes to do it\n";
}

// In which scenes another arm would lead.
std::string LeadersText(const LeaderChanges& changes) {
  if (changes.scene_count == 0) return "";
  std::string text =
      "another arm would be the leader of " + std::to_string(changes.scene_count) + " scenes:\n";
  const auto named = [](const std::string& arm) { return arm.empty() ? "none" : arm; };
  for (const LeaderChange& change : changes.scenes) {
    text += "  " + change.project + " / " + change.scene;
    if (!change.machine_class.empty()) text += " on " + change.machine_class;
    text += ", reward version " + std::to_string(change.reward_version) + ": " +
            named(change.next_arm) + " in place of " + named(change.arm) + "\n";
  }
  if (changes.scene_count > changes.scenes.size()) text += "  and others\n";
  return text;
}

Json LeadersJson(const LeaderChanges& changes) {
  Json scenes = Json::array();
  for (const LeaderChange& change : changes.scenes) {
    scenes.push_back({{"project", change.project},
                      {"scene", change.scene},
                      {"machine_class", change.machine_class},
                      {"reward_version", change.reward_version},
                      {"arm", change.arm},
                      {"next_arm", change.next_arm}});
  }
  return {{"count", changes.scene_count}, {"scenes", scenes}};
}

// A range of times that holds none is a mistake.
Status CheckTimes(const SourceChoice& sources) {
  if (sources.unix_until_s == 0 || sources.unix_from_s <= sources.unix_until_s) return {};
  return {StatusCode::kInvalidArgument, "--until is before --since"};
}

// All of a project, or of a daemon, is not revoked by leaving something out.
Status CheckNamesAny(const SourceChoice& sources) {
  const bool any = !sources.source_id.empty() || !sources.build.empty() || sources.token_id != 0 ||
                   sources.unix_from_s != 0 || sources.unix_until_s != 0;
  if (any) return CheckTimes(sources);
  return {StatusCode::kInvalidArgument,
          "name the sessions to revoke by --source, --build, --token-id, --since or --until"};
}

// Of a revocation that takes nothing out.
std::string NothingText(const PriorsOptions& options) {
  std::string text = "no session that is not revoked already matches";
  const std::string& source = options.sources.source_id;
  if (source.empty() || options.sources != SourceChoice{.source_id = source})
    return text + "; `sweepstake audit list` and exports say which there are\n";
  return text + "; should it come, it " + (options.yes ? "counts" : "would count") + " no more\n";
}

int RunRevoke(const PriorsOptions& options, Terminal& terminal) {
  if (const Status named = CheckNamesAny(options.sources); !named.ok())
    return Fail(terminal, named);
  const auto result = RevokePriors(options.daemon, options.sources, /*preview=*/!options.yes);
  if (!result.ok()) return FailAnswer(terminal, result.status());
  const Json document = {
      {"command", "priors revoke"},
      {"revoked", options.yes},
      {"sources", result->source_count},
      {"records", result->record_count},
      {"windows", result->window_count},
      {"leader_changes", options.yes ? Json() : LeadersJson(result->leader_changes)}};
  // What old sessions taught together is that of no source.
  const bool none = result->source_count == 0 && result->record_count == 0;
  PrintResult(terminal, options.json, document,
              none ? NothingText(options)
                   : CountsText(*result) + DoneText(options, "revoked") +
                         LeadersText(result->leader_changes));
  return kDone;
}

int RunPromote(const PriorsOptions& options, Terminal& terminal) {
  if (const Status times = CheckTimes(options.sources); !times.ok()) return Fail(terminal, times);
  const auto result = PromotePriors(options.daemon, options.sources, /*preview=*/!options.yes);
  if (!result.ok()) return FailAnswer(terminal, result.status());
  const Json document = {
      {"command", "priors promote"},
      {"promoted", options.yes},
      {"sources", result->source_count},
      {"records", result->record_count},
      {"windows", result->window_count},
      {"scenes", result->scene_count},
      {"leader_changes", options.yes ? Json() : LeadersJson(result->leader_changes)}};
  const std::string none = "nothing that waits matches; `sweepstake priors list` shows what does\n";
  PrintResult(terminal, options.json, document,
              result->source_count == 0
                  ? none
                  : CountsText(*result) + " for " + std::to_string(result->scene_count) +
                        " scenes" + DoneText(options, "promoted") +
                        LeadersText(result->leader_changes));
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

void DeclareSources(CLI::App& command, PriorsOptions& options) {
  DeclareCommon(command, options);
  SourceChoice& sources = options.sources;
  command.add_option("--project", sources.project, "Only evidence of this project");
  command.add_option("--source", sources.source_id,
                     "This session, as `audit list` and the source_id of an export have it");
  command.add_option("--build", sources.build, "Sessions of this build of the game");
  command.add_option("--token-id", sources.token_id, "Sessions that began with this token")
      ->check(NotNegative());
  command.add_option("--since", sources.unix_from_s, "Sessions that began then or later")
      ->check(NotNegative())
      ->type_name("UNIX_S");
  command.add_option("--until", sources.unix_until_s, "Sessions that began then or before")
      ->check(NotNegative())
      ->type_name("UNIX_S");
  command.add_flag("--yes", options.yes, "Do it");
}

void AddSourceCommands(CLI::App& priors, Terminal& terminal, int& exit_code) {
  AddCommand<PriorsOptions>(
      priors, "promote", "Let imports that wait in a daemon's quarantine count",
      "  sweepstake priors promote --daemon 127.0.0.1:7433\n"
      "  sweepstake priors promote --daemon 127.0.0.1:7433 --project arcade --build 1.3 --yes\n"
      "Without --yes it says what would count, and changes nothing. Without a filter it means all\n"
      "that waits, which `priors list` shows. `priors revoke` takes it out again, exactly.\n",
      exit_code, DeclareSources,
      [&terminal](const PriorsOptions& options) { return RunPromote(options, terminal); });
  AddCommand<PriorsOptions>(
      priors, "revoke", "Take the evidence of sessions out of a daemon, exactly",
      "  sweepstake priors revoke --daemon 127.0.0.1:7433 --project arcade --build 1.3\n"
      "  sweepstake priors revoke --daemon 127.0.0.1:7433 --token-id 7 --since 1760000000 --yes\n"
      "Without --yes it says what would go, and changes nothing. What is revoked stays away: the\n"
      "sessions' later evidence counts no more, and imports of it neither.\n",
      exit_code, DeclareSources,
      [&terminal](const PriorsOptions& options) { return RunRevoke(options, terminal); });
}

}  // namespace

void AddPriorsCommand(CLI::App& app, Terminal& terminal, int& exit_code) {
  CLI::App* priors = app.add_subcommand("priors", "A daemon's evidence, and files of it");
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
      "  sweepstake priors export --daemon 127.0.0.1:7433 --out evidence.json\n"
      "  sweepstake priors export --daemon 127.0.0.1:7433 --sums --out priors.json\n"
      "  sweepstake run --scene hurricane --objects 3000 --embedded --priors priors.json\n",
      exit_code,
      [](CLI::App& command, PriorsOptions& options) {
        DeclareCommon(command, options);
        DeclareFilter(command, options);
        command.add_option("--out", options.file, "File to write")->required();
        command.add_flag(
            "--sums", options.sums,
            "Sums per build and machine class, which name no session: small enough for "
            "a game's repository, and to ship with the game; no daemon imports them");
      },
      [&terminal](const PriorsOptions& options) { return RunExport(options, terminal); });
  AddCommand<PriorsOptions>(
      *priors, "import", "Add a priors file to a daemon's evidence; twice changes nothing",
      "  sweepstake priors import --daemon 127.0.0.1:7433 --in priors.json\n"
      "  sweepstake priors import --daemon 127.0.0.1:7433 --in priors.json --promote\n"
      "It waits in quarantine, where no session begins with it, until `priors promote` lets it\n"
      "count; with --promote it counts at once.\n",
      exit_code,
      [](CLI::App& command, PriorsOptions& options) {
        DeclareCommon(command, options);
        command.add_option("--in", options.file, "File to read")->required();
        command.add_flag("--promote", options.promote, "Let it count at once");
      },
      [&terminal](const PriorsOptions& options) { return RunImport(options, terminal); });
  AddSourceCommands(*priors, terminal, exit_code);
  AddPriorsFileCommands(*priors, terminal, exit_code);
}

}  // namespace sweepstake::cli
