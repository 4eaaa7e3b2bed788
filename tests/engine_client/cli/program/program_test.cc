// Tests the command line of `sweepstake` as scripts use it: messages and exit codes.
#include "tests/engine_client/cli/program/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;

TEST(Program, HelpOfEveryCommandGivesExitCodeZeroAndShowsExamples) {
  for (const std::string command : {"run", "watch", "audit list", "priors list", "sessions list"}) {
    const ProgramRun run = RunProgram(command + " --help");
    EXPECT_EQ(run.exit_code, 0) << command;
    EXPECT_THAT(run.out, HasSubstr("Examples:\n  sweepstake " + command)) << command;
    EXPECT_EQ(run.err, "");
  }
  EXPECT_EQ(RunProgram("--help").exit_code, 0);
  EXPECT_EQ(RunProgram("--version").exit_code, 0);
}

TEST(Program, BadUsageGivesExitCodeTwoAndListsValidValues) {
  ExpectBadUsage(RunProgram,
                 {
                     {"", "the commands of sweepstake are run, audit, "},
                     {"frobnicate", "unknown command of sweepstake 'frobnicate', must be one of "},
                     {"bench --scene suite-b", "this command is in sweepstake-lab"},
                     {"run --colour", "--colour"},
                 });
}

}  // namespace
}  // namespace sweepstake::cli
