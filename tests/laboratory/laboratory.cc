#include "tests/laboratory/laboratory.h"

namespace sweepstake::cli {
namespace {

void AddCommands(CLI::App& app, Terminal& terminal, const std::string& command_line,
                 int& exit_code) {
  AddCheckCommand(app, terminal, exit_code);
  AddBenchCommand(app, terminal, command_line, exit_code);
  AddExperimentCommand(app, terminal, command_line, exit_code);
  AddLoadCommand(app, terminal, exit_code);
  AddPairsCommand(app, terminal, exit_code);
  AddRecordCommand(app, terminal, exit_code);
  AddReplayCommand(app, terminal, exit_code);
  AddReportCommand(app, terminal, exit_code);
  AddTraceCommand(app, terminal, exit_code);
}

}  // namespace

int RunLaboratory(std::span<char* const> words, Terminal& terminal) {
  return RunProgram({.name = "sweepstake-lab",
                     .description = "Sweepstake's laboratory: measures broad phases and policies",
                     .add_commands = AddCommands},
                    words, terminal);
}

}  // namespace sweepstake::cli
