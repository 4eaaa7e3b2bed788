// `sweepstake sessions list|watch|kick|pin|release`: shows a daemon's sessions, ends them, and sets
// their mode and arm.
#include <array>
#include <nlohmann/json.hpp>

#include "engine_client/cli/command.h"
#include "engine_client/cli/commands.h"
#include "engine_client/cli/daemon/daemon_calls.h"
#include "engine_client/cli/io/duration.h"
#include "engine_client/cli/io/json_output.h"
#include "engine_client/cli/io/process.h"
#include "engine_client/cli/io/text_table.h"
#include "engine_client/decider/types.h"

namespace sweepstake::cli {
namespace {

struct SessionsOptions {
  DaemonOptions daemon;
  std::string project;
  std::string scene;
  std::string session_id;
  bool may_return = false;
  std::string arm;
  bool json = false;
};

// The texts of v1::SessionState and v1::SessionEnd, indexed by value.
constexpr std::array<std::string_view, 4> kStateNames = {"unknown", "connected", "lost", "ending"};
constexpr std::array<std::string_view, 4> kEndNames = {"unknown", "goodbye", "kicked", "forgotten"};

std::string StateText(v1::SessionState state) { return decision::NameOf(kStateNames, state); }

std::string EndText(v1::SessionEnd end) { return decision::NameOf(kEndNames, end); }

std::string ModeText(v1::Mode mode) { return mode == v1::MODE_AI ? "ai" : "manual"; }

Json SessionJson(const v1::SessionInfo& session) {
  const bool heard = session.unix_last_message_ms() > 0;
  return {{"session_id", session.session_id()},
          {"project", session.project()},
          {"scene", session.scene()},
          {"build", session.build()},
          {"machine_class", session.machine_class()},
          {"client_address", session.client_address()},
          {"state", StateText(session.state())},
          {"active_arm", session.active_arm()},
          {"initial_arm", session.initial_arm()},
          {"mode", ModeText(session.mode())},
          {"unix_start_ms", session.unix_start_ms()},
          {"unix_last_message_ms", heard ? Json(session.unix_last_message_ms()) : Json()},
          {"dropped_frames", session.dropped_frame_count()},
          {"takes_orders", session.takes_orders()},
          {"shows_boxes", session.shows_boxes()}};
}

std::string SessionsText(const SessionsOptions& options,
                         const std::vector<v1::SessionInfo>& sessions) {
  if (sessions.empty()) {
    const bool selects = !options.project.empty() || !options.scene.empty();
    return selects ? "The daemon has no matching sessions\n" : "The daemon has no sessions\n";
  }
  TextTable table({"session", "project", "scene", "build", "client", "state", "arm", "mode",
                   "began (UTC)", "last message (UTC)", "dropped frames"});
  for (const v1::SessionInfo& session : sessions) {
    const int64_t last_ms = session.unix_last_message_ms();
    table.AddRow({session.session_id(), session.project(), session.scene(), session.build(),
                  session.client_address(), StateText(session.state()), session.active_arm(),
                  ModeText(session.mode()), UtcText(session.unix_start_ms()),
                  last_ms > 0 ? UtcText(last_ms) : "",
                  std::to_string(session.dropped_frame_count())});
  }
  return table.Text();
}

// Returns the JSON of an event: the event's id, its time, and the change of a session.
Json ChangeJson(const v1::EventStamp& stamp, const std::string& what, Json change) {
  // The event's id is BOOT:SEQUENCE. It is a string, because a JSON number cannot represent all 64
  // bits of a boot's number.
  return {{"event", std::to_string(stamp.boot()) + ":" + std::to_string(stamp.sequence())},
          {"unix_ms", stamp.unix_ms()},
          {what, std::move(change)}};
}

std::string SessionText(const v1::SessionInfo& session) {
  return session.session_id() + " of " + session.project() + "/" + session.scene() + ": " +
         StateText(session.state()) + ", " + session.active_arm() + ", " + ModeText(session.mode());
}

void PrintChanges(const v1::WatchSessionsResponse& event, bool json, Terminal& terminal) {
  const std::string time = UtcText(event.stamp().unix_ms()) + " ";
  for (const v1::SessionInfo& session : event.sessions()) {
    PrintResult(terminal, json, ChangeJson(event.stamp(), "session", SessionJson(session)),
                time + SessionText(session) + "\n", /*indent=*/-1);
  }
  for (const v1::SessionEnded& each : event.ended()) {
    PrintResult(terminal, json,
                ChangeJson(event.stamp(), "ended",
                           {{"session_id", each.session_id()}, {"end", EndText(each.end())}}),
                time + each.session_id() + " ended: " + EndText(each.end()) + "\n",
                /*indent=*/-1);
  }
  terminal.out.flush();
}

int RunSessionsList(const SessionsOptions& options, Terminal& terminal) {
  const auto sessions = ListSessions(options.daemon, options.project, options.scene);
  if (!sessions.ok()) return FailAnswer(terminal, sessions.status());
  Json list = Json::array();
  for (const v1::SessionInfo& session : *sessions) list.push_back(SessionJson(session));
  PrintResult(terminal, options.json,
              {{"command", "sessions list"},
               {"daemon", options.daemon.address},
               {"sessions", std::move(list)}},
              SessionsText(options, *sessions));
  return kDone;
}

int RunWatch(const SessionsOptions& options, Terminal& terminal) {
  const auto sessions = ListSessions(options.daemon, options.project, options.scene);
  if (!sessions.ok()) return FailAnswer(terminal, sessions.status());
  if (sessions->empty() && !options.json) PrintText(terminal, SessionsText(options, *sessions));
  InstallStopSignal();
  const Status status = WatchSessions(
      options.daemon, options.project, options.scene, StopRequested,
      [&](const v1::WatchSessionsResponse& event) { PrintChanges(event, options.json, terminal); },
      [&](const Status& connection) { SayConnection(terminal, connection); });
  return status.ok() ? kDone : FailAnswer(terminal, status);
}

int RunKick(const SessionsOptions& options, Terminal& terminal) {
  const Status status = KickSession(options.daemon, options.session_id, options.may_return);
  if (!status.ok()) return FailAnswer(terminal, status);
  PrintResult(terminal, options.json,
              {{"command", "sessions kick"},
               {"session_id", options.session_id},
               {"may_return", options.may_return}},
              options.session_id +
                  (options.may_return ? " is disconnected and may return\n" : " is being ended\n"));
  return kDone;
}

int RunOrder(const SessionsOptions& options, v1::Mode mode, Terminal& terminal) {
  const auto held = OrderSession(options.daemon, options.session_id, mode, options.arm);
  if (!held.ok()) return FailAnswer(terminal, held.status());
  PrintResult(terminal, options.json,
              {{"session_id", options.session_id},
               {"mode", ModeText(held->mode())},
               {"active_arm", held->active_arm()}},
              options.session_id + " follows the order: " + ModeText(held->mode()) + ", " +
                  held->active_arm() + " is active\n");
  return kDone;
}

void DeclareSelection(CLI::App& command, SessionsOptions& options) {
  AddDaemonOptions(command, options.daemon);
  command.add_option("--project", options.project, "Only this project");
  command.add_option("--scene", options.scene, "Only this scene");
}

void DeclareSession(CLI::App& command, SessionsOptions& options) {
  AddDaemonOptions(command, options.daemon);
  command.add_option("SESSION", options.session_id, "The session's id, as `list` shows it")
      ->required();
  AddJsonFlag(command, options.json);
}

void DeclareKick(CLI::App& command, SessionsOptions& options) {
  DeclareSession(command, options);
  command.add_flag("--may-return", options.may_return,
                   "End only the connection: the client reconnects and continues the session");
}

void AddOrderCommands(const CommandContext& sessions) {
  AddCommand<SessionsOptions>(
      sessions, "pin", "Make a game use one arm and stop learning, until `release` or a bail-out",
      "  sweepstake sessions pin --daemon 127.0.0.1:7433 ID KDTree\n"
      "  sweepstake sessions pin --daemon 127.0.0.1:7433 ID\n",
      [](CLI::App& command, SessionsOptions& options) {
        DeclareSession(command, options);
        command.add_option("ARM", options.arm, "Name of the arm (default: the active arm)");
      },
      [](const SessionsOptions& options, Terminal& terminal) {
        return RunOrder(options, v1::MODE_MANUAL, terminal);
      });
  AddCommand<SessionsOptions>(
      sessions, "release", "Return a game to mode ai, in which the decider chooses the arm",
      "  sweepstake sessions release --daemon 127.0.0.1:7433 ID\n", DeclareSession,
      [](const SessionsOptions& options, Terminal& terminal) {
        return RunOrder(options, v1::MODE_AI, terminal);
      });
}

}  // namespace

void AddSessionsCommand(const CommandContext& context) {
  const CommandContext sessions =
      AddGroup(context, "sessions", "List, watch, end and steer a daemon's sessions",
               "  sweepstake sessions list --daemon 127.0.0.1:7433\n"
               "  sweepstake sessions watch --daemon 127.0.0.1:7433 --json\n"
               "  sweepstake sessions kick --daemon 127.0.0.1:7433 ID\n"
               "  sweepstake sessions pin --daemon 127.0.0.1:7433 ID KDTree");
  AddCommand<SessionsOptions>(
      sessions, "list", "List the daemon's sessions, including lost ones that may resume",
      "  sweepstake sessions list --daemon 127.0.0.1:7433\n"
      "  sweepstake sessions list --daemon 127.0.0.1:7433 --scene hurricane-3000 --json\n",
      [](CLI::App& command, SessionsOptions& options) {
        DeclareSelection(command, options);
        AddJsonFlag(command, options.json);
      },
      RunSessionsList);
  AddCommand<SessionsOptions>(
      sessions, "watch",
      "Show the sessions and their changes until Ctrl-C; reconnects if the daemon is lost",
      "  sweepstake sessions watch --daemon 127.0.0.1:7433\n"
      "  sweepstake sessions watch --daemon 127.0.0.1:7433 --json\n",
      [](CLI::App& command, SessionsOptions& options) {
        DeclareSelection(command, options);
        command.add_flag("--json", options.json, "One JSON document per line for each event");
      },
      RunWatch);
  AddCommand<SessionsOptions>(
      sessions, "kick", "End a session; its evidence is kept",
      "  sweepstake sessions kick --daemon 127.0.0.1:7433 ID\n"
      "  sweepstake sessions kick --daemon 127.0.0.1:7433 ID --may-return\n",
      DeclareKick, RunKick);
  AddOrderCommands(sessions);
}

}  // namespace sweepstake::cli
