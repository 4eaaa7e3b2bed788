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
  void (*add_commands)(const CommandContext& context);
};

// Runs the command of `program` that `words` name and returns the program's exit code. The first
// word is the program's name; there may be no word at all. Results go to `terminal.out`, everything
// else goes to `terminal.err`.
int RunProgram(const Program& program, std::span<char* const> words, Terminal& terminal);

// Runs a command line of `sweepstake`. A command of the laboratory is an error that names
// sweepstake-lab.
int RunCommandLine(std::span<char* const> words, Terminal& terminal);

// Each function adds one subcommand. While the app parses, the chosen subcommand runs and stores
// its exit code.
void AddAuditCommand(const CommandContext& context);
void AddPriorsCommand(const CommandContext& context);
// Adds what works on files to the subcommand `priors`.
void AddPriorsFileCommands(const CommandContext& priors);
void AddRunCommand(const CommandContext& context);
void AddSessionsCommand(const CommandContext& context);
void AddWatchCommand(const CommandContext& context);

}  // namespace sweepstake::cli
