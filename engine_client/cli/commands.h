// The commands of the program `sweepstake`, and the parsing that chooses one of them.
#pragma once

#include <span>
#include <string>

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

// Runs the command that `words` ask for and returns the program's exit code. The first word is the
// program's name; there may be no word at all. Results go to `terminal.out`, everything else goes
// to `terminal.err`.
int RunCommandLine(std::span<char* const> words, Terminal& terminal);

// Each function adds one subcommand to `app`. While `app` parses, the chosen subcommand runs and
// stores its exit code. `terminal` and `exit_code` are borrowed until then.
void AddAuditCommand(CLI::App& app, Terminal& terminal, int& exit_code);
// `command_line` is what the user typed; the report of --report shows it.
void AddBenchCommand(CLI::App& app, Terminal& terminal, const std::string& command_line,
                     int& exit_code);
void AddCheckCommand(CLI::App& app, Terminal& terminal, int& exit_code);
// `command_line` is what the user typed; the experiment's manifest keeps it.
void AddExperimentCommand(CLI::App& app, Terminal& terminal, const std::string& command_line,
                          int& exit_code);
void AddLoadCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddPairsCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddPriorsCommand(CLI::App& app, Terminal& terminal, int& exit_code);
// Adds what works on files to the subcommand `priors`.
void AddPriorsFileCommands(CLI::App& priors, Terminal& terminal, int& exit_code);
// Adds what says and shows of which builds builds were made to the subcommand `priors`.
void AddPriorsBuildsCommands(CLI::App& priors, Terminal& terminal, int& exit_code);
void AddRecordCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddReplayCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddReportCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddRunCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddTraceCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddSessionsCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddWatchCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
