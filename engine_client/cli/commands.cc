#include "engine_client/cli/commands.h"

#include <algorithm>
#include <array>

#include "engine_client/cli/command.h"
#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/text/names.h"
#include "sweepstake/simd.h"

namespace sweepstake::cli {
namespace {

// Checks the name of a command before the parser does, because the parser's own message does not
// list the commands. `words` are the words after the name of `app`.
Status CheckCommandName(const CLI::App& app, std::span<char* const> words) {
  const auto commands = app.get_subcommands({});
  if (commands.empty() || (!words.empty() && words.front()[0] == '-')) return {};
  std::string list;
  std::vector<std::string> names;
  for (const CLI::App* command : commands) {
    if (!words.empty() && command->get_name() == words.front()) {
      return CheckCommandName(*command, words.subspan(1));
    }
    names.push_back(command->get_name());
    list += (list.empty() ? "" : ", ") + names.back();
  }
  if (words.empty()) {
    return {StatusCode::kInvalidArgument,
            "give a command; the commands of " + app.get_name() + " are " + list};
  }
  const std::vector<std::string_view> valid(names.begin(), names.end());
  return {StatusCode::kInvalidArgument,
          text::UnknownName("command of " + app.get_name(), words.front(), valid)};
}

// Checks the names of options before the parser does. The parser would report a missing option
// first, and it does not list the valid options. `words` are the words after the name of `app`.
Status CheckOptionNames(const CLI::App& app, std::span<char* const> words) {
  if (!words.empty()) {
    for (const CLI::App* command : app.get_subcommands({})) {
      if (command->get_name() == words.front()) return CheckOptionNames(*command, words.subspan(1));
    }
  }
  std::vector<std::string> names;
  for (const CLI::Option* option : app.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  const std::vector<std::string_view> valid(names.begin(), names.end());
  for (const std::string_view word : words) {
    if (word == "--") break;
    const std::string_view name = word.substr(0, word.find('='));
    if (!name.starts_with("--") || std::find(valid.begin(), valid.end(), name) != valid.end())
      continue;
    return {StatusCode::kInvalidArgument,
            text::UnknownName("option of " + app.get_name(), name, valid)};
  }
  return {};
}

// The commands of the program sweepstake-lab, in case somebody types one of them here by mistake.
constexpr std::array<std::string_view, 9> kLaboratoryCommands = {
    "bench", "check", "experiment", "load", "pairs", "record", "replay", "report", "trace"};

void AddCommands(const CommandContext& context) {
  AddRunCommand(context);
  AddAuditCommand(context);
  AddWatchCommand(context);
  AddPriorsCommand(context);
  AddSessionsCommand(context);
  AddAlertsCommand(context);
}

}  // namespace

int RunCommandLine(std::span<char* const> words, Terminal& terminal) {
  if (words.size() > 1 && std::find(kLaboratoryCommands.begin(), kLaboratoryCommands.end(),
                                    std::string_view(words[1])) != kLaboratoryCommands.end()) {
    const std::string name = words[1];
    return Fail(terminal, Status(StatusCode::kInvalidArgument,
                                 "this command is in sweepstake-lab: run `sweepstake-lab " + name +
                                     "`; `cmake --workflow --preset release` builds it"));
  }
  return RunProgram({.name = "sweepstake",
                     .description = "Sweepstake: adaptive broad-phase collision detection",
                     .add_commands = AddCommands},
                    words, terminal);
}

int RunProgram(const Program& program, std::span<char* const> words, Terminal& terminal) {
  terminal.program = program.name;
  CLI::App app(program.description, program.name);
  app.set_version_flag("--version", SWEEPSTAKE_VERSION);
  app.require_subcommand(1);
  app.footer(SceneHelp() +
             "Exit codes: 0 done, 1 a check failed, 2 bad usage, 3 could not reach something.\n"
             "`" +
             program.name + " COMMAND --help` shows options and examples.");
  int exit_code = kDone;
  const std::string command_line = CommandLine(words);
  program.add_commands({app, terminal, exit_code, command_line});
  const auto arguments = words.empty() ? words : words.subspan(1);
  Status status = CheckCommandName(app, arguments);
  if (status.ok()) status = CheckOptionNames(app, arguments);
  if (status.ok()) status = UseSimdTargetOfEnvironment();
  if (!status.ok()) return Fail(terminal, status);
  try {
    app.parse(static_cast<int>(words.size()), words.data());
  } catch (const CLI::ParseError& error) {
    // The parser also reports --help and --version as errors; their exit code is 0.
    return app.exit(error, terminal.out, terminal.err) == 0 ? kDone : kBadUsage;
  }
  terminal.out.flush();
  if (!terminal.out) {
    return Fail(
        terminal,
        Status(
            StatusCode::kInvalidArgument,
            "cannot write to stdout; check that its disk is not full and its reader still runs"));
  }
  return exit_code;
}

}  // namespace sweepstake::cli
