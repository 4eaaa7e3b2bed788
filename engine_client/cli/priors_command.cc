// `sweepstake priors list|export|import|promote|revoke` works on the evidence of a daemon. It lists
// evidence, exports it for games and other daemons, imports it into quarantine, promotes it from
// quarantine, and revokes it.
#include <algorithm>
#include <nlohmann/json.hpp>
#include <utility>
#include <vector>

#include "engine_client/cli/command.h"
#include "engine_client/cli/commands.h"
#include "engine_client/cli/daemon/daemon_calls.h"
#include "engine_client/cli/daemon/posterior_view.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/cli/io/whole_file.h"
#include "engine_client/cli/priors/priors_text.h"
#include "engine_client/decider/embedded/priors_file.h"
#include "engine_client/decider/pooling/priors_sums.h"
#include "engine_client/text/counts.h"

namespace sweepstake::cli {
namespace {

struct PriorsOptions {
  DaemonOptions daemon;
  std::string project;
  std::string scene;
  std::string file;
  v1::SourceFilter sources;
  bool sums = false;
  bool promote = false;
  bool yes = false;
  bool json = false;
};

std::string QuarantinedText(const decision::PriorsGroups& groups) {
  if (groups.empty()) return "";
  return "\nImports in quarantine, which count after `sweepstake priors promote`:\n" +
         ShowText(groups);
}

int RunPriorsList(const PriorsOptions& options, Terminal& terminal) {
  const auto scenes = ListPosteriors(options.daemon, options.project, options.scene);
  if (!scenes.ok()) return FailAnswer(terminal, scenes.status());
  const auto waiting =
      ExportPriors(options.daemon, options.project, options.scene, Exported::kQuarantined);
  if (!waiting.ok()) return FailAnswer(terminal, waiting.status());
  const decision::PriorsGroups quarantined = decision::GroupPriors(*waiting);
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
  return text::Counted(count, "record") +
         " in quarantine, not part of any sum; `sweepstake priors promote` makes quarantined "
         "records count";
}

// The content of an export file.
struct ExportText {
  std::string text = {};
  uint64_t count = 0;          // records or sums in `text`
  uint64_t waiting_count = 0;  // records left out because they are in quarantine
};

Result<ExportText> TextOfSums(const PriorsOptions& options) {
  BuildSums sums;
  ExportText file;
  const Status status = StreamPriors(options.daemon, options.project, options.scene, Exported::kAll,
                                     [&](PriorRecord record) {
                                       if (record.is_quarantined) ++file.waiting_count;
                                       sums.Add(std::move(record));
                                     });
  if (!status.ok()) return status;
  const std::vector<PriorRecord> summed = sums.Take();
  file.count = summed.size();
  file.text = FormatPriors(summed);
  return file;
}

Result<ExportText> TextOfRecords(const PriorsOptions& options) {
  const auto records = ExportPriors(options.daemon, options.project, options.scene);
  if (!records.ok()) return records.status();
  if (const Status count = CheckRecordCount(*records); !count.ok()) return count;
  return ExportText{FormatPriors(*records), records->size()};
}

int RunPriorsExport(const PriorsOptions& options, Terminal& terminal) {
  const auto file = options.sums ? TextOfSums(options) : TextOfRecords(options);
  if (!file.ok()) return FailAnswer(terminal, file.status());
  const std::string waiting = DescribeWaiting(file->waiting_count);
  const bool leaves_some =
      !options.project.empty() || !options.scene.empty() || file->waiting_count > 0;
  if (leaves_some && file->count == 0) {
    const std::string none =
        options.sums ? "no matching records outside the quarantine" : "no matching records";
    return FailAnswer(
        terminal,
        Status(StatusCode::kNotFound,
               "the daemon has " + none + ", and " + options.file +
                   " was not changed; `sweepstake priors list` shows which records exist" +
                   (waiting.empty() ? "" : "; " + waiting)));
  }
  if (const Status written = WriteWhole(options.file, file->text); !written.ok())
    return Fail(terminal, written);
  const Json document = {{"command", "priors export"},
                         {"file", options.file},
                         {"records", file->count},
                         {"sums", options.sums},
                         {"left_waiting", file->waiting_count}};
  PrintResult(terminal, options.json, document,
              options.file + ": " +
                  (options.sums ? text::Counted(file->count, "sum") + " of builds"
                                : text::Counted(file->count, "record")) +
                  "\n" + waiting + (waiting.empty() ? "" : "\n"));
  return kDone;
}

std::string AbsentText(uint64_t count) {
  if (count == 0) return "";
  return std::to_string(count) +
         " of these are not stored under their project and scene: their source was revoked, or is "
         "stored under another project or scene and counts only there\n";
}

std::string SumsText(uint64_t count) {
  if (count == 0) return "";
  return std::to_string(count) +
         " sums of builds were skipped: a daemon cannot detect how much of a sum it already "
         "contains\n";
}

std::string WaitsText(const PriorsOptions& options, const ImportCounts& result) {
  if (options.promote || result.applied_count == 0) return "";
  return "they are in quarantine, and count after `sweepstake priors promote`\n";
}

int RunImport(const PriorsOptions& options, Terminal& terminal) {
  auto records = ReadPriorsFile(options.file);
  if (!records.ok()) return Fail(terminal, records.status());
  const uint64_t sum_count = std::erase_if(*records, IsSum);
  if (records->empty() && sum_count > 0) {
    return Fail(
        terminal,
        Status(StatusCode::kInvalidArgument,
               options.file + " contains only sums of builds, and a daemon cannot detect how much "
                              "of a sum it already contains: export the evidence without --sums"));
  }
  const auto result = ImportPriors(options.daemon, *records, options.promote);
  if (!result.ok()) return FailAnswer(terminal, result.status());
  const Json document = {{"command", "priors import"},           {"file", options.file},
                         {"records", records->size()},           {"applied", result->applied_count},
                         {"unchanged", result->unchanged_count}, {"absent", result->absent_count},
                         {"promoted", options.promote},          {"sums", sum_count}};
  PrintResult(terminal, options.json, document,
              options.file + ": " + text::Counted(records->size(), "record") +
                  "; new or newer: " + std::to_string(result->applied_count) + ", already known: " +
                  std::to_string(result->unchanged_count) + "\n" + WaitsText(options, *result) +
                  AbsentText(result->absent_count) + SumsText(sum_count));
  return kDone;
}

// Returns text about the evidence that was revoked or promoted, or would be with --yes.
template <typename Result>
std::string CountsText(const Result& result) {
  return text::Counted(result.source_count(), "source") + " with " +
         text::Counted(result.record_count(), "record") + " of " +
         std::to_string(result.window_count()) + " windows and visits";
}

template <typename Result>
std::string DoneText(const PriorsOptions& options, const Result& result, const std::string& done) {
  if (!options.yes) return " would be " + done + "; add --yes to do it\n";
  return (result.source_count() == 1 ? " was " : " were ") + done + "\n";
}

// Lists the scenes whose leader would be another arm after the change.
std::string LeadersText(const v1::LeaderChanges& changes) {
  if (changes.scene_count() == 0) return "";
  std::string text =
      "another arm would be the leader of " + text::Counted(changes.scene_count(), "scene") + ":\n";
  const auto named = [](const std::string& arm) { return arm.empty() ? "none" : arm; };
  for (const v1::LeaderChange& change : changes.scenes()) {
    text += "  " + change.project() + " / " + change.scene();
    if (!change.machine_class().empty()) text += " on " + change.machine_class();
    text += ", reward version " + std::to_string(change.reward_version()) + ": " +
            named(change.next_arm()) + " instead of " + named(change.arm()) + "\n";
  }
  if (changes.scene_count() > static_cast<uint64_t>(changes.scenes_size()))
    text += "  and others\n";
  return text;
}

Json LeadersJson(const v1::LeaderChanges& changes) {
  Json scenes = Json::array();
  for (const v1::LeaderChange& change : changes.scenes()) {
    scenes.push_back({{"project", change.project()},
                      {"scene", change.scene()},
                      {"machine_class", change.machine_class()},
                      {"reward_version", change.reward_version()},
                      {"arm", change.arm()},
                      {"next_arm", change.next_arm()}});
  }
  return {{"count", changes.scene_count()}, {"scenes", scenes}};
}

// Returns an error if the range of times is empty.
Status CheckTimes(const v1::SourceFilter& sources) {
  if (sources.unix_until_s() == 0 || sources.unix_from_s() <= sources.unix_until_s()) return {};
  return {StatusCode::kInvalidArgument, "--until is before --since; give a later time"};
}

// Returns text that explains why a revocation removes nothing.
std::string NothingText(const PriorsOptions& options) {
  std::string text = "no session matches, or all that match are revoked already";
  v1::SourceFilter rest = options.sources;
  rest.clear_source_id();
  if (options.sources.source_id().empty() || rest.ByteSizeLong() > 0)
    return text + "; `sweepstake audit list` shows the sessions and who began them\n";
  return text + "; if its evidence arrives later, it " + (options.yes ? "will" : "would") +
         " not count\n";
}

int RunRevoke(const PriorsOptions& options, Terminal& terminal) {
  if (const Status times = CheckTimes(options.sources); !times.ok()) return Fail(terminal, times);
  const auto result = RevokePriors(options.daemon, options.sources, /*preview=*/!options.yes);
  if (!result.ok()) return FailAnswer(terminal, result.status());
  const Json document = {
      {"command", "priors revoke"},
      {"revoked", options.yes},
      {"sources", result->source_count()},
      {"records", result->record_count()},
      {"windows", result->window_count()},
      {"leader_changes", options.yes ? Json() : LeadersJson(result->leader_changes())}};
  // Evidence of old sessions that the daemon has summed has records but no sources, so both counts
  // are checked.
  const bool none = result->source_count() == 0 && result->record_count() == 0;
  PrintResult(terminal, options.json, document,
              none ? NothingText(options)
                   : CountsText(*result) + DoneText(options, *result, "revoked") +
                         LeadersText(result->leader_changes()));
  return kDone;
}

int RunPromote(const PriorsOptions& options, Terminal& terminal) {
  if (const Status times = CheckTimes(options.sources); !times.ok()) return Fail(terminal, times);
  const auto result = PromotePriors(options.daemon, options.sources, /*preview=*/!options.yes);
  if (!result.ok()) return FailAnswer(terminal, result.status());
  const Json document = {
      {"command", "priors promote"},
      {"promoted", options.yes},
      {"sources", result->source_count()},
      {"records", result->record_count()},
      {"windows", result->window_count()},
      {"scenes", result->scene_count()},
      {"leader_changes", options.yes ? Json() : LeadersJson(result->leader_changes())}};
  const std::string none =
      "no record in quarantine matches; `sweepstake priors list` shows the records in quarantine\n";
  PrintResult(terminal, options.json, document,
              result->source_count() == 0
                  ? none
                  : CountsText(*result) + " for " + text::Counted(result->scene_count(), "scene") +
                        DoneText(options, *result, "promoted") +
                        LeadersText(result->leader_changes()));
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
  v1::SourceFilter& sources = options.sources;
  command.add_option("--project", *sources.mutable_project(), "Only evidence of this project");
  command.add_option("--source", *sources.mutable_source_id(),
                     "Session id, as in `audit list` and in the source_id of an export");
  command.add_option("--build", *sources.mutable_build(), "Sessions of this build of the game");
  const auto add_number = [&](const std::string& name, void (v1::SourceFilter::*set)(int64_t),
                              const std::string& help) {
    return command
        .add_option_function<int64_t>(
            name, [&sources, set](const int64_t& value) { (sources.*set)(value); }, help)
        ->check(NotNegative());
  };
  add_number("--token-id", &v1::SourceFilter::set_token_id, "Sessions that began with this token");
  command.add_option("--player", *sources.mutable_player(),
                     "Sessions that began with a ticket of this player");
  command.add_option("--network", *sources.mutable_network(),
                     "Sessions from this address's network, such as 203.0.113.7 (its first 24 "
                     "bits) or 2001:db8::1 (its first 48 bits)");
  add_number("--since", &v1::SourceFilter::set_unix_from_s,
             "Sessions whose first evidence was stored at this time or later")
      ->type_name("UNIX_S");
  add_number("--until", &v1::SourceFilter::set_unix_until_s,
             "Sessions whose first evidence was stored at this time or earlier")
      ->type_name("UNIX_S");
  command.add_flag("--yes", options.yes,
                   "Make the change; without it, only show what would change");
}

void AddSourceCommands(const CommandContext& priors) {
  AddCommand<PriorsOptions>(
      priors, "promote", "Promote imported evidence: it leaves the quarantine and counts",
      "  sweepstake priors promote --daemon 127.0.0.1:7433\n"
      "  sweepstake priors promote --daemon 127.0.0.1:7433 --project arcade --build 1.3 --yes\n"
      "Without --yes it only shows what would count. Without a filter it promotes everything\n"
      "in quarantine, which `priors list` shows. `priors revoke` removes the evidence again,\n"
      "exactly.\n",
      DeclareSources, RunPromote);
  AddCommand<PriorsOptions>(
      priors, "revoke", "Remove all evidence of the selected sessions from a daemon",
      "  sweepstake priors revoke --daemon 127.0.0.1:7433 --project arcade --build 1.3\n"
      "  sweepstake priors revoke --daemon 127.0.0.1:7433 --token-id 7 --since 1760000000 --yes\n"
      "Without --yes it only shows what would be removed. A revocation is permanent: later\n"
      "evidence of these sessions does not count, and neither does an import of it.\n",
      DeclareSources, RunRevoke);
}

}  // namespace

void AddPriorsCommand(const CommandContext& context) {
  const CommandContext priors =
      AddGroup(context, "priors", "Manage a daemon's evidence and priors files",
               "  sweepstake priors list --daemon 127.0.0.1:7433\n"
               "  sweepstake priors export --daemon 127.0.0.1:7433 --out priors.json");
  AddCommand<PriorsOptions>(
      priors, "list", "Show every scene's posteriors",
      "  sweepstake priors list --daemon 127.0.0.1:7433 --project quickstart\n",
      [](CLI::App& command, PriorsOptions& options) {
        DeclareCommon(command, options);
        DeclareFilter(command, options);
      },
      RunPriorsList);
  AddCommand<PriorsOptions>(
      priors, "export", "Write the evidence as a priors file, for games and other daemons",
      "  sweepstake priors export --daemon 127.0.0.1:7433 --out evidence.json\n"
      "  sweepstake priors export --daemon 127.0.0.1:7433 --sums --out priors.json\n"
      "  sweepstake run --scene hurricane --objects 3000 --embedded --priors priors.json\n",
      [](CLI::App& command, PriorsOptions& options) {
        DeclareCommon(command, options);
        DeclareFilter(command, options);
        command.add_option("--out", options.file, "File to write")->required();
        command.add_flag(
            "--sums", options.sums,
            "Sums per build and machine class, without session ids: small enough to keep in a "
            "game's repository and to ship with the game; daemons do not import them");
      },
      RunPriorsExport);
  AddCommand<PriorsOptions>(
      priors, "import",
      "Add a priors file to a daemon's evidence; importing it again changes nothing",
      "  sweepstake priors import --daemon 127.0.0.1:7433 --in priors.json\n"
      "  sweepstake priors import --daemon 127.0.0.1:7433 --in priors.json --promote\n"
      "The evidence stays in quarantine, where sessions do not use it, until `priors promote`.\n"
      "With --promote it counts at once.\n",
      [](CLI::App& command, PriorsOptions& options) {
        DeclareCommon(command, options);
        command.add_option("--in", options.file, "File to read")->required();
        command.add_flag("--promote", options.promote, "Make it count at once");
      },
      RunImport);
  AddSourceCommands(priors);
  AddPriorsFileCommands(priors);
}

}  // namespace sweepstake::cli
