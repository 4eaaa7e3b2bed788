// The commands of the program `sweepstake`, and the parsing that chooses one of them. The
// laboratory's program has its own commands and the same parsing.
#pragma once

#include <span>
#include <string>

#include "engine_client/cli/command.h"

namespace sweepstake::cli {

// A program that consists of commands.
struct Program {
  std::string name;
  std::string description;
  // Adds the commands to `app`. `command_line` is what the user typed; reports keep it.
  void (*add_commands)(CLI::App& app, Terminal& terminal, const std::string& command_line,
                       int& exit_code);
};

// Runs the command of `program` that `words` name and returns the program's exit code. The first
// word is the program's name; there may be no word at all. Results go to `terminal.out`, everything
// else goes to `terminal.err`.
int RunProgram(const Program& program, std::span<char* const> words, Terminal& terminal);

// Runs a command line of `sweepstake`. A command of the laboratory is an error that names
// sweepstake-lab.
int RunCommandLine(std::span<char* const> words, Terminal& terminal);

// Each function adds one subcommand to `app`. While `app` parses, the chosen subcommand runs and
// stores its exit code. `terminal` and `exit_code` are borrowed until then.
void AddAuditCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddPriorsCommand(CLI::App& app, Terminal& terminal, int& exit_code);
// Adds what works on files to the subcommand `priors`.
void AddPriorsFileCommands(CLI::App& priors, Terminal& terminal, int& exit_code);
void AddRunCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddSessionsCommand(CLI::App& app, Terminal& terminal, int& exit_code);
void AddWatchCommand(CLI::App& app, Terminal& terminal, int& exit_code);

}  // namespace sweepstake::cli
