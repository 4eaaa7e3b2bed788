// Tests the command line as scripts use it: exit codes, one JSON document on stdout, and errors
// that list the valid values.
#include "engine_client/cli/commands.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "sweepstake/broad_phase.h"
#include "tests/engine_client/cli/command_run.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using test_support::TemporaryDirectory;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;
using testing::StartsWith;

// A command line that must fail, and a part of its error message.
struct BadUsage {
  std::string arguments;
  std::string said;
};

// Expects that each command line exits with 2, writes nothing to stdout, and prints its message.
void ExpectBadUsage(const std::vector<BadUsage>& cases) {
  for (const auto& [arguments, said] : cases) {
    const CommandRun run = RunCommand(arguments);
    EXPECT_EQ(run.exit_code, kBadUsage) << arguments;
    EXPECT_EQ(run.out, "") << arguments;
    EXPECT_THAT(run.err, HasSubstr(said)) << arguments;
  }
}

TEST(Commands, HelpOfEveryCommandShowsExamplesOnStdout) {
  for (const std::string command :
       {"run",           "watch",         "audit",          "audit list",
        "audit export",  "priors",        "priors list",    "priors export",
        "priors import", "priors revoke", "priors promote", "priors show",
        "priors doctor", "priors diff",   "priors merge",   "priors arm",
        "sessions",      "sessions list", "sessions watch", "sessions kick",
        "alerts"}) {
    const CommandRun run = RunCommand(command + " --help");
    EXPECT_EQ(run.exit_code, kDone) << command;
    const size_t examples = run.out.find("Examples:\n");
    ASSERT_NE(examples, std::string::npos) << command;
    EXPECT_THAT(run.out.substr(examples), HasSubstr("\n  sweepstake " + command + " ")) << command;
    EXPECT_EQ(run.err, "") << command;
  }
}

TEST(Commands, TheProgramsHelpListsTheCommandsAndExitCodes) {
  const CommandRun run = RunCommand("--help");
  EXPECT_EQ(run.exit_code, kDone);
  EXPECT_THAT(run.out, AllOf(HasSubstr("priors"), HasSubstr("watch"),
                             HasSubstr("3 could not reach something")));
  const CommandRun version = RunCommand("--version");
  EXPECT_EQ(version.exit_code, kDone);
  EXPECT_THAT(version.out, testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(Commands, ALaboratoryCommandNamesSweepstakeLabAndHowToBuildIt) {
  for (const std::string command :
       {"bench", "check", "experiment", "load", "pairs", "record", "replay", "report", "trace"}) {
    ExpectBadUsage(
        {{command, "this command is in sweepstake-lab: run `sweepstake-lab " + command + "`"},
         {command + " --help", "`cmake --workflow --preset release` builds it"}});
  }
}

TEST(Commands, AnUnknownCommandListsTheNearestOneFirst) {
  ExpectBadUsage({
      {"prior list", "unknown command of sweepstake 'prior', must be one of priors"},
      {"priors exports", "unknown command of priors 'exports', must be one of export"},
      {"audit lost", "unknown command of audit 'lost', must be one of list"},
  });
}

TEST(Commands, AnUnknownOptionListsTheNearestOneFirst) {
  ExpectBadUsage({
      {"watch --onec", "unknown option of watch '--onec', must be one of --once"},
      {"priors list --jsn --daemon 127.0.0.1:1", "must be one of --json"},
      {"--versoin", "unknown option of sweepstake '--versoin', must be one of --version"},
  });
}

TEST(Commands, AMissingCommandListsAllCommands) {
  ExpectBadUsage({
      {"priors", "the commands of priors are list, export, import"},
      {"audit", "the commands of audit are list, export"},
      {"sessions", "the commands of sessions are list, watch, kick"},
  });
  std::ostringstream out;
  std::ostringstream err;
  Terminal terminal{.out = out, .err = err};
  EXPECT_EQ(RunCommandLine({}, terminal), kBadUsage);
  EXPECT_THAT(err.str(), HasSubstr("give a command; the commands of sweepstake are run, audit"));
}

TEST(Commands, AnUnknownOptionOrAMissingOneIsNamed) {
  ExpectBadUsage({
      {"watch", "--daemon is required"},
      {"watch --daemon localhost:1 --follow", "--json"},
      {"priors list", "--daemon is required"},
      {"priors import --daemon localhost:1", "--in is required"},
      {"priors export --daemon localhost:1", "--out is required"},
      {"audit export --daemon localhost:1", "--out is required"},
      {"sessions kick --daemon localhost:1", "SESSION is required"},
  });
}

TEST(Commands, ANumberOutOfRangeIsNamedWithItsOption) {
  ExpectBadUsage({
      {"run --scene suite-b --embedded --time-scale nan", "--time-scale: nan is not a number"},
      {"run --scene suite-b --embedded --time-scale 1001", "--time-scale"},
      {"run --scene suite-b --embedded --time-scale x", "--time-scale: x is not a number"},
      {"run --scene suite-b --embedded --time-scale 0.5", "--time-scale"},
  });
}

TEST(Commands, ARunNamesAnInvalidRuleOfItsDecider) {
  for (const std::string decider : {"--embedded", "--daemon 127.0.0.1:1"}) {
    const std::string run = "run --scene suite-b --objects 10 --duration 50ms " + decider;
    ExpectBadUsage({
        {run + " --policy paper --weights 0.5,0.5,0.5,0.5", "the reward weights sum to 2.0"},
        {"run --scene suite-b --embedded --weights 1,0,0,0", "--weights needs --policy paper"},
        {run + " --weights 1,0,0", "--weights: give four numbers"},
        {run + " --policy paper --weights 2,-1,0,0", "use numbers from 0 to 1"},
        {run + " --interval soon", "--interval"},
        {run + " --cooldown -1s", "--cooldown"},
    });
  }
}

TEST(Commands, AnUnknownNameListsTheValidNames) {
  ExpectBadUsage({
      {"run --scene nowhere --embedded", "hurricane"},
      {"run --scene suite-b --embedded --arm Octree", "KDTree"},
      {"run --scene suite-b --embedded --policy coin", "paper"},
      {"run --scene suite-b --embedded --mode auto", "manual"},
      {"run --scene suite-b --embedded --shadow maybe", "auto"},
  });
}

TEST(Commands, ARunNeedsExactlyOneDecider) {
  ExpectBadUsage({
      {"run --scene suite-b", "give either --daemon HOST:PORT or --embedded"},
      {"run --scene suite-b --embedded --daemon localhost:1",
       "give either --daemon HOST:PORT or --embedded"},
      {"run --scene suite-b --daemon localhost:1 --priors x.json", "--priors needs --embedded"},
      {"run --scene suite-b --embedded --duration soon", "give a number and ms, s, m or h"},
      {"run --scene suite-b --embedded --allow-orders", "--allow-orders needs --daemon"},
      {"run --scene suite-b --embedded --allow-box-view", "--allow-box-view needs --daemon"},
      {"run --scene suite-b --daemon nowhere", "nowhere"},
  });
}

TEST(Commands, TheDaemonAddressIsCheckedBeforeTheCall) {
  for (const std::string command :
       {"watch", "watch --json", "priors list", "priors export --out never.json", "audit list",
        "audit export --out never.csv", "sessions list", "sessions watch", "sessions kick ID",
        "alerts"}) {
    ExpectBadUsage({{command + " --daemon nowhere", "nowhere"},
                    {command + " --daemon localhost:99999", "99999"}});
  }
}

TEST(Commands, AnUnreachableDaemonGivesExitCodeThreeAndAHintToStartIt) {
  for (const std::string command :
       {"watch", "watch --json", "priors list --json", "priors export --out never.json",
        "audit list", "audit export --out never.csv", "sessions list", "sessions watch --json",
        "sessions kick ID", "alerts --json"}) {
    const CommandRun run = RunCommand(command + " --daemon 127.0.0.1:1");
    EXPECT_EQ(run.exit_code, kUnreachable) << command;
    EXPECT_EQ(run.out, "") << command;
    EXPECT_THAT(run.err, AllOf(HasSubstr("no daemon answered at 127.0.0.1:1"),
                               HasSubstr("start one with sweepstaked")))
        << command;
  }
  EXPECT_FALSE(std::ifstream("never.json").good());
  EXPECT_FALSE(std::ifstream("never.csv").good());
}

// Files that no command can read, each with its problem.
class BrokenFiles : public testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& bytes) {
    const std::string path = (folder_.path() / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  std::string Path(const std::string& name) { return (folder_.path() / name).string(); }

 private:
  TemporaryDirectory folder_;
};

TEST_F(BrokenFiles, AreNamedInErrorsWhenUsedAsScenes) {
  for (const std::string& path : {Path("absent.aabbs"), Write("empty.aabbs", ""),
                                  Write("text.aabbs", std::string(500, 'x'))}) {
    ExpectBadUsage({{"run --embedded --duration 1s --scene " + path, path}});
  }
}

TEST_F(BrokenFiles, AreNamedInErrorsWhenUsedAsPriors) {
  const std::string run = "run --scene suite-b --objects 10 --embedded --duration 1s --priors ";
  const std::string import = "priors import --daemon localhost:1 --in ";
  for (const std::string& path :
       {Path("absent.json"), Write("empty.json", ""), Write("cut.json", "{\"format\": \"sweep"),
        Write("other.json", "{\"format\": \"other\"}")}) {
    ExpectBadUsage({{run + path, path},
                    {import + path, path},
                    {"priors show --in " + path, path},
                    {"priors doctor --in " + path, path},
                    {"priors diff " + path + " " + path, path},
                    {"priors merge --out never.json " + path + " " + path, path}});
  }
}

TEST_F(BrokenFiles, AreNamedInErrorsWhenTheyCannotBeWritten) {
  const std::string folder = Path("no-such-folder");
  ExpectBadUsage({
      {"audit export --daemon localhost:1 --out " + folder + "/x.csv", folder},
      {"run --scene suite-b --embedded --duration 1s --csv " + Write("file", "") + "/x", "file"},
  });
}

TEST(RunOfAScene, IsNamedAfterItsLargestNumberOfObjects) {
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "none.json").string();
  std::ofstream(file) << R"({"format": "sweepstake-priors", "version": 1, "records": []})";
  const CommandRun run = RunCommand(
      "run --scene waves --objects 300 --embedded --mode manual --duration 50ms --priors " + file);
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, HasSubstr("scene waves-300,"));
  EXPECT_THAT(run.out, HasSubstr("waves with 300 objects"));
}

TEST(RunOfAScene, PrintsOneDocumentAndWritesItsFiles) {
  const TemporaryDirectory folder;
  const CommandRun run = RunCommand(
      "run --scene suite-b --objects 50 --embedded --mode manual --arm Grid --duration 50ms "
      "--shadow off --json --csv " +
      folder.path().string());
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["command"], "run");
  EXPECT_EQ(document["active_arm"], "Grid");
  EXPECT_EQ(document["decider"], "embedded");
  EXPECT_EQ(document["shadow"]["state"], "off");
  for (const char* name : {"frames.csv", "switches.csv", "posteriors.csv", "decisions.csv"}) {
    EXPECT_TRUE(std::filesystem::exists(folder.path() / name)) << name;
  }
}

}  // namespace
}  // namespace sweepstake::cli
