// `sweepstake audit list|export`: lists a daemon's logs of decisions, and exports them as CSV.
// `sweepstake-lab replay --log` derives the decisions of an export again.
#include <nlohmann/json.hpp>

#include "engine_client/cli/command.h"
#include "engine_client/cli/commands.h"
#include "engine_client/cli/daemon/daemon_calls.h"
#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

struct AuditOptions {
  DaemonOptions daemon;
  AuditSelection selection;
  std::string file;
  bool json = false;
};

// Returns the number of the segment's first row as text. A number above 1 means that the rows
// before it were removed. Older daemons send 0, for which the text is empty.
std::string FirstRowText(const v1::AuditSegment& segment) {
  return segment.first_row() == 0 ? "" : std::to_string(segment.first_row());
}

// Returns who began the session: a player, a network or a token.
std::string OriginText(const v1::AuditSegment& segment) {
  if (!segment.party().empty()) return segment.party();
  return segment.token_id() == 0 ? "" : "token " + std::to_string(segment.token_id());
}

std::string SegmentsText(const std::vector<v1::AuditSegment>& segments) {
  if (segments.empty()) return "The daemon has no matching decision log\n";
  TextTable table({"session", "segment", "began (UTC)", "project", "scene", "from", "rows",
                   "first row", "lost rows"});
  for (const v1::AuditSegment& row : segments) {
    table.AddRow({row.session_id(), std::to_string(row.segment()), UtcText(row.unix_start_ms()),
                  row.project(), row.scene(), OriginText(row), std::to_string(row.row_count()),
                  FirstRowText(row), std::to_string(row.lost_row_count())});
  }
  return table.Text();
}

Json SegmentsJson(const std::vector<v1::AuditSegment>& segments) {
  Json list = Json::array();
  for (const v1::AuditSegment& row : segments) {
    list.push_back({{"session_id", row.session_id()},
                    {"segment", row.segment()},
                    {"project", row.project()},
                    {"scene", row.scene()},
                    {"unix_start_ms", row.unix_start_ms()},
                    {"token_id", row.token_id()},
                    {"party", row.party()},
                    {"rows", row.row_count()},
                    {"first_row", row.first_row()},
                    {"lost_rows", row.lost_row_count()}});
  }
  return list;
}

int RunAuditList(const AuditOptions& options, Terminal& terminal) {
  const auto segments = ListAudit(options.daemon, options.selection);
  if (!segments.ok()) return FailAnswer(terminal, segments.status());
  PrintResult(terminal, options.json,
              {{"command", "audit list"}, {"segments", SegmentsJson(*segments)}},
              SegmentsText(*segments));
  return kDone;
}

int RunAuditExport(const AuditOptions& options, Terminal& terminal) {
  const auto row_count = ExportAudit(options.daemon, options.selection, options.file);
  if (!row_count.ok()) return FailAnswer(terminal, row_count.status());
  PrintResult(terminal, options.json,
              {{"command", "audit export"}, {"file", options.file}, {"rows", *row_count}},
              options.file + ": " + std::to_string(*row_count) + " rows\n");
  return kDone;
}

void Declare(CLI::App& command, AuditOptions& options) {
  AddDaemonOptions(command, options.daemon);
  command.add_option("--session", options.selection.session_id, "Only this session");
  command.add_option("--project", options.selection.project, "Only this project");
  command.add_option("--scene", options.selection.scene, "Only this scene");
  AddJsonFlag(command, options.json);
}

}  // namespace

void AddAuditCommand(const CommandContext& context) {
  const CommandContext audit =
      AddGroup(context, "audit", "List and export a daemon's log of decisions",
               "  sweepstake audit list --daemon 127.0.0.1:7433\n"
               "  sweepstake audit export --daemon 127.0.0.1:7433 --out decisions.csv\n"
               "  sweepstake-lab replay --log decisions.csv");
  AddCommand<AuditOptions>(
      audit, "list", "List the sessions with logged decisions",
      "  sweepstake audit list --daemon 127.0.0.1:7433 --scene hurricane-3000\n", Declare,
      RunAuditList);
  AddCommand<AuditOptions>(
      audit, "export", "Write the decisions as CSV, also for `sweepstake-lab replay`",
      "  sweepstake audit export --daemon 127.0.0.1:7433 --out decisions.csv\n"
      "  sweepstake audit export --daemon 127.0.0.1:7433 --session ID --out one.csv\n"
      "  sweepstake-lab replay --log decisions.csv\n",
      [](CLI::App& command, AuditOptions& options) {
        Declare(command, options);
        command.add_option("--out", options.file, "File to write")->required();
      },
      RunAuditExport);
}

}  // namespace sweepstake::cli
