// The program `sweepstake`: wires its commands; each has a file pair of its own here.
#include <sys/ioctl.h>
#include <unistd.h>

#include <exception>
#include <iostream>
#include <span>
#include <string>

#include "engine_client/cli/audit_command.h"
#include "engine_client/cli/bench_command.h"
#include "engine_client/cli/check_command.h"
#include "engine_client/cli/command_line.h"
#include "engine_client/cli/experiment_command.h"
#include "engine_client/cli/pairs_command.h"
#include "engine_client/cli/paper_check_command.h"
#include "engine_client/cli/priors_command.h"
#include "engine_client/cli/record_command.h"
#include "engine_client/cli/replay_command.h"
#include "engine_client/cli/run_command.h"
#include "engine_client/cli/trace_command.h"
#include "engine_client/cli/watch_command.h"

namespace sweepstake::cli {
namespace {

size_t ColumnsOfStderr() {
  winsize size{};
  const bool known = ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
  return known ? size.ws_col : 80;
}

// With the program's name; a program may be started with no word at all.
std::span<char* const> Program(int argc, char** argv) {
  return argc < 1 ? std::span<char* const>() : std::span(argv, static_cast<size_t>(argc));
}

// Without the program's name.
std::span<char* const> Words(int argc, char** argv) {
  return argc < 1 ? std::span<char* const>() : Program(argc, argv).subspan(1);
}

// The parser's own message for a missing or unknown command names none. `given` are the words after
// the one of `app`.
Status CheckCommandName(const CLI::App& app, std::span<char* const> given) {
  const auto commands = app.get_subcommands({});
  if (commands.empty() || (!given.empty() && given.front()[0] == '-')) return {};
  std::string names;
  for (const CLI::App* command : commands) {
    if (!given.empty() && command->get_name() == given.front()) {
      return CheckCommandName(*command, given.subspan(1));
    }
    names += (names.empty() ? "" : ", ") + command->get_name();
  }
  const std::string problem =
      given.empty() ? "give a command" : "there is no command '" + std::string(given.front()) + "'";
  return {StatusCode::kInvalidArgument,
          problem + "; the commands of " + app.get_name() + " are " + names};
}

int Run(int argc, char** argv) {
  const bool err_is_tty = isatty(STDERR_FILENO) == 1;
  Terminal terminal{std::cout, std::cerr, err_is_tty, err_is_tty ? ColumnsOfStderr() : 0};
  CLI::App app("Sweepstake: adaptive broad-phase collision detection", "sweepstake");
  app.set_version_flag("--version", SWEEPSTAKE_VERSION);
  app.require_subcommand(1);
  app.footer(
      "SCENE is brownian, rotating-gravity, hurricane, free-fall, random-gravity, suite-b, "
      "suite-g,\n"
      "suite-h, one of the scenes that `sweepstake bench --help` lists besides, or a FILE.aabbs.\n"
      "Exit codes: 0 done, 1 a check failed, 2 bad usage, 3 could not reach something.\n"
      "`sweepstake COMMAND --help` shows options and examples.");
  int exit_code = kDone;
  AddRunCommand(app, terminal, exit_code);
  AddCheckCommand(app, terminal, exit_code);
  AddAuditCommand(app, terminal, exit_code);
  AddBenchCommand(app, terminal, CommandLine(Program(argc, argv)), exit_code);
  AddExperimentCommand(app, terminal, CommandLine(Program(argc, argv)), exit_code);
  AddPaperCheckCommand(app, terminal, exit_code);
  AddPairsCommand(app, terminal, exit_code);
  AddRecordCommand(app, terminal, exit_code);
  AddReplayCommand(app, terminal, exit_code);
  AddTraceCommand(app, terminal, exit_code);
  AddWatchCommand(app, terminal, exit_code);
  AddPriorsCommand(app, terminal, exit_code);
  if (const Status status = CheckCommandName(app, Words(argc, argv)); !status.ok()) {
    return Fail(terminal, status);
  }
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    // Help and version end with 0.
    return app.exit(error, terminal.out, terminal.err) == 0 ? kDone : kBadUsage;
  }
  terminal.out.flush();
  if (!terminal.out) {
    return Fail(terminal, Status(StatusCode::kInvalidArgument, "could not write to stdout"));
  }
  return exit_code;
}

}  // namespace
}  // namespace sweepstake::cli

int main(int argc, char** argv) {
  try {
    return sweepstake::cli::Run(argc, argv);
  } catch (const std::exception& error) {
    std::cerr << "sweepstake: " << error.what() << '\n';
    return sweepstake::cli::kCheckFailed;
  }
}
