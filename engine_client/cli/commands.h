// The commands of the program `sweepstake`, and the parsing that chooses one of them. The
// laboratory's program has other commands but uses the same parsing.
#pragma once

#include <span>
#include <string>

#include "engine_client/cli/io/terminal.h"

namespace sweepstake::cli {

struct CommandContext;  // command.h

// A command-line program with subcommands.
struct Program {
  std::string name;
  std::string description;
  void (*add_commands)(const CommandContext& context);
};

// Runs the command that `words` name and returns the program's exit code. The first word is the
// program's name; `words` may be empty. Results go to `terminal.out`, everything else to
// `terminal.err`.
int RunProgram(const Program& program, std::span<char* const> words, Terminal& terminal);

// Runs a command line of `sweepstake`. If the command belongs to the laboratory, the error names
// sweepstake-lab.
int RunCommandLine(std::span<char* const> words, Terminal& terminal);

// Each function adds one subcommand. The parser runs the chosen subcommand and stores its exit code
// in context.exit_code.
void AddAlertsCommand(const CommandContext& context);
void AddAuditCommand(const CommandContext& context);
void AddPriorsCommand(const CommandContext& context);
// Adds the subcommands that work on priors files to the group `priors`.
void AddPriorsFileCommands(const CommandContext& priors);
void AddRunCommand(const CommandContext& context);
void AddSessionsCommand(const CommandContext& context);
void AddWatchCommand(const CommandContext& context);

}  // namespace sweepstake::cli
