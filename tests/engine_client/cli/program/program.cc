#include "tests/engine_client/cli/program/program.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace sweepstake::cli {
namespace {

std::string TakeFile(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  std::stringstream text;
  text << file.rdbuf();
  std::filesystem::remove(path);
  return text.str();
}

ProgramRun Run(const std::string& program, const std::string& arguments) {
  const std::string out = TemporaryPath("stdout");
  const std::string err = TemporaryPath("stderr");
  const std::string line = program + " " + arguments + " >'" + out + "' 2>'" + err + "'";
  const int status = std::system(line.c_str());
  ProgramRun run;
  if (WIFEXITED(status)) run.exit_code = WEXITSTATUS(status);
  run.out = TakeFile(out);
  run.err = TakeFile(err);
  return run;
}

}  // namespace

ProgramRun RunProgram(const std::string& arguments) { return Run(SWEEPSTAKE_PROGRAM, arguments); }

ProgramRun RunLab(const std::string& arguments) { return Run(SWEEPSTAKE_LAB_PROGRAM, arguments); }

ProgramRun RunEither(const std::string& arguments) {
  const bool is_lab = arguments.starts_with("load ") || arguments.starts_with("replay ");
  return is_lab ? RunLab(arguments) : RunProgram(arguments);
}

ProgramRun RunDaemonProgram(const std::string& arguments) {
  return Run(SWEEPSTAKED_PATH, arguments);
}

std::vector<std::string> ConnectingCommands(const std::string& folder) {
  const std::string priors = folder + "/priors.json";
  return {"run --scene suite-b --objects 100 --duration 2s",
          "watch --once",
          "load --streams 2 --duration 200ms",
          "sessions list",
          "priors list",
          "priors export --out " + priors,
          "priors import --in " + priors,
          "audit list",
          "audit export --out " + folder + "/log.csv"};
}

void ExpectBadUsage(ProgramRun (*run)(const std::string& arguments),
                    const std::vector<BadUsage>& cases) {
  for (const auto& [arguments, error] : cases) {
    const ProgramRun refused = run(arguments);
    EXPECT_EQ(refused.exit_code, 2) << arguments;
    EXPECT_THAT(refused.err, testing::HasSubstr(error)) << arguments;
    EXPECT_EQ(refused.out, "") << arguments;
  }
}

std::string TemporaryPath(const std::string& name) {
  return testing::TempDir() + "sweepstake_cli_" + std::to_string(getpid()) + "_" + name;
}

}  // namespace sweepstake::cli
