// Tests the command line of `sweepstake-lab` as scripts use it: exit codes, one JSON document on
// stdout, and errors that list the valid values.
#include "tests/laboratory/laboratory.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>
#include <vector>

#include "sweepstake/broad_phase.h"
#include "tests/laboratory/tests/lab_command.h"
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

// Expects each command line to end with exit code 2, an empty stdout, and its message on stderr.
void ExpectBadUsage(const std::vector<BadUsage>& cases) {
  for (const auto& [arguments, said] : cases) {
    const CommandRun run = RunLabCommand(arguments);
    EXPECT_EQ(run.exit_code, kBadUsage) << arguments;
    EXPECT_EQ(run.out, "") << arguments;
    EXPECT_THAT(run.err, HasSubstr(said)) << arguments;
  }
}

TEST(LabCommands, HelpOfEveryCommandShowsExamplesOnStdout) {
  for (const std::string command :
       {"check", "bench", "load", "pairs", "record", "replay", "trace", "experiment", "report"}) {
    const CommandRun run = RunLabCommand(command + " --help");
    EXPECT_EQ(run.exit_code, kDone) << command;
    const size_t examples = run.out.find("Examples:\n");
    ASSERT_NE(examples, std::string::npos) << command;
    EXPECT_THAT(run.out.substr(examples), HasSubstr("\n  sweepstake-lab " + command + " "))
        << command;
    EXPECT_EQ(run.err, "") << command;
  }
}

TEST(LabCommands, TheProgramsHelpListsTheCommandsAndExitCodes) {
  const CommandRun run = RunLabCommand("--help");
  EXPECT_EQ(run.exit_code, kDone);
  EXPECT_THAT(run.out, AllOf(HasSubstr("check"), HasSubstr("trace"),
                             HasSubstr("3 could not reach something")));
  const CommandRun version = RunLabCommand("--version");
  EXPECT_EQ(version.exit_code, kDone);
  EXPECT_THAT(version.out, testing::MatchesRegex("[0-9]+\\.[0-9]+\\.[0-9]+\n"));
}

TEST(LabCommands, AnUnknownCommandGetsTheNearestOneFirst) {
  ExpectBadUsage({
      {"chekc", "unknown command of sweepstake-lab 'chekc', must be one of check"},
  });
}

TEST(LabCommands, AnUnknownOptionGetsTheNearestOneFirst) {
  ExpectBadUsage({
      {"load --stream 5", "unknown option of load '--stream', must be one of --streams"},
      {"load --batch-frames=5", "unknown option of load '--batch-frames', must be one of "},
  });
}

TEST(LabCommands, AnUnknownOptionOrAMissingOneIsNamed) {
  ExpectBadUsage({
      {"check --scene suite-b --colour", "--colour"},
      {"check", "--scene is required"},
      {"pairs --scene suite-b --arm SAP", "--frame is required"},
      {"pairs --scene suite-b --frame 1", "--arm is required"},
      {"record --scene suite-b --frames 1", "--out is required"},
      {"record --scene suite-b --out x.aabbs", "--frames is required"},
  });
}

TEST(LabCommands, ANumberOutOfRangeIsNamedWithItsOption) {
  ExpectBadUsage({
      {"check --scene suite-b --frames 1000001", "--frames"},
      {"check --scene suite-b --frames=-1", "--frames"},
      {"check --scene suite-b --seed=-1", "--seed: -1 is negative"},
      {"check --scene suite-b --objects many", "--objects"},
      {"check --scene suite-b --frames many", "--frames: many is not a whole number"},
      {"check --scene suite-b --frames 1.5", "--frames: 1.5 is not a whole number"},
      {"check --scene suite-b --frames 99999999999999999999", "not in range 0 to 1000000"},
      {"pairs --scene suite-b --arm SAP --frame=-3", "--frame"},
      {"record --scene suite-b --out x.aabbs --frames 2147483648", "--frames"},
  });
}

TEST(LabCommands, AnUnknownNameGetsTheValidOnes) {
  ExpectBadUsage({
      {"check --scene huricane", "must be one of hurricane"},
      {"check --scene suite-b --arms Octree", "AxisSweep"},
      {"check --scene suite-b --arms SAP,Octree", "AxisSweep"},
      {"pairs --scene suite-b --frame 0 --arm KDTre", "KDTree"},
      {"pairs --scene suite-x --frame 0 --arm SAP", "suite-"},
      {"record --scene nowhere --frames 1 --out x.aabbs", "hurricane"},
  });
}

// Files that no command can read, each with an expected part of the error.
class BrokenScenes : public testing::Test {
 protected:
  std::string Write(const std::string& name, const std::string& bytes) {
    const std::string path = (folder_.path() / name).string();
    std::ofstream(path, std::ios::binary) << bytes;
    return path;
  }
  std::string Read(const std::string& path) {
    std::ostringstream text;
    text << std::ifstream(path, std::ios::binary).rdbuf();
    return text.str();
  }
  std::string Path(const std::string& name) { return (folder_.path() / name).string(); }

 private:
  TemporaryDirectory folder_;
};

TEST_F(BrokenScenes, AreNamedByEveryCommandThatReadsAScene) {
  const std::string recorded = Path("whole.aabbs");
  ASSERT_EQ(
      RunLabCommand("record --scene suite-b --objects 5 --frames 2 --out " + recorded).exit_code,
      kDone);
  const std::string whole = Read(recorded);
  for (const std::string& path :
       {Path("absent.aabbs"), Write("empty.aabbs", ""), Write("text.aabbs", std::string(500, 'x')),
        Write("short.aabbs", whole.substr(0, whole.size() - 1)),
        Write("long.aabbs", whole + "x")}) {
    ExpectBadUsage({{"check --scene " + path, path},
                    {"pairs --frame 0 --arm SAP --scene " + path, path},
                    {"record --frames 1 --out " + Path("never.aabbs") + " --scene " + path, path}});
  }
  EXPECT_FALSE(std::ifstream(Path("never.aabbs")).good());
}

TEST_F(BrokenScenes, ThatCannotBeWrittenAreNamed) {
  const std::string folder = Path("no-such-folder");
  ExpectBadUsage({
      {"record --scene suite-b --objects 5 --frames 1 --out " + folder + "/x.aabbs", folder},
  });
}

TEST(CheckCommand, PassesAndPrintsATableForPeople) {
  const CommandRun run =
      RunLabCommand("check --scene suite-b --objects 60 --frames 3 --arms SAP,Grid");
  EXPECT_EQ(run.exit_code, kDone);
  EXPECT_THAT(run.out, StartsWith("scene"));
  EXPECT_THAT(run.out, AllOf(HasSubstr("SAP"), HasSubstr("Grid"), HasSubstr("passed")));
  EXPECT_THAT(run.out, Not(HasSubstr("FAILED")));
}

TEST(CheckCommand, PrintsARowPerSceneCountAndArmAsJson) {
  const CommandRun run = RunLabCommand(
      "check --scene suite-b,suite-g --objects 20,30 --frames 2 --arms SAP,Grid --json");
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["command"], "check");
  EXPECT_EQ(document["passed"], true);
  ASSERT_EQ(document["rows"].size(), 8U);
  EXPECT_EQ(document["rows"][0]["scene"], "suite-b");
  EXPECT_EQ(document["rows"][0]["objects"], 20);
  EXPECT_EQ(document["rows"][0]["arm"], "SAP");
  EXPECT_EQ(document["rows"][0]["frames"], 3);
  EXPECT_EQ(document["rows"][2]["objects"], 30);
  EXPECT_EQ(document["rows"][4]["scene"], "suite-g");
  EXPECT_FALSE(document["rows"][0].contains("first_difference"));
}

TEST(CheckCommand, RefusesAFrameWithTooManyPairsAndSaysWhatToDo) {
  const CommandRun run = RunLabCommand("check --scene all-coincident --objects 6500 --frames 0");
  EXPECT_EQ(run.exit_code, kBadUsage);
  EXPECT_THAT(run.err, StartsWith("sweepstake-lab: "));
  EXPECT_THAT(run.err,
              AllOf(HasSubstr("frame 0 has too many pairs"), HasSubstr("use fewer --objects")));
}

TEST(PairsCommand, PrintsTheSamePairsAsTextAndAsJson) {
  const std::string command = "pairs --scene suite-g --objects 300 --frame 4 --arm DBVT";
  const CommandRun text = RunLabCommand(command);
  const CommandRun document = RunLabCommand(command + " --json");
  ASSERT_EQ(text.exit_code, kDone) << text.err;
  const json parsed = json::parse(document.out);
  EXPECT_EQ(parsed["frame"], 4);
  EXPECT_EQ(parsed["arm"], "DBVT");
  std::string lines;
  for (const json& pair : parsed["pairs"]) {
    lines += pair[0].dump() + " " + pair[1].dump() + "\n";
  }
  EXPECT_GT(parsed["pairs"].size(), 0U);
  EXPECT_EQ(text.out, lines);
}

TEST(PairsCommand, FindsTheSamePairsWithEveryArm) {
  const std::string command = "pairs --scene clusters --objects 150 --frame 6 --arm ";
  const std::string right = RunLabCommand(command + "BruteForce").out;
  EXPECT_NE(right, "");
  for (const std::string_view arm : BroadPhaseNames()) {
    EXPECT_EQ(RunLabCommand(command + std::string(arm)).out, right) << arm;
  }
}

TEST(RecordCommand, WritesTheFramesThatPairsThenReads) {
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "r.aabbs").string();
  const CommandRun run =
      RunLabCommand("record --scene suite-b --objects 300 --frames 3 --seed 5 --out " + file);
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_EQ(run.out, file + ": 4 frames of up to 300 boxes, " + std::to_string(304 + 4 * 300 * 32) +
                         " bytes\n");
  const std::string frame = " --frame 2 --arm SAP --objects 300 --seed 5";
  EXPECT_EQ(RunLabCommand("pairs --scene " + file + frame).out,
            RunLabCommand("pairs --scene suite-b" + frame).out);
}

TEST(RecordCommand, CountsTheFullestFrameOfAGrowingScene) {
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "g.aabbs").string();
  const CommandRun run =
      RunLabCommand("record --scene spawning --objects 640 --frames 30 --json --out " + file);
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  const json document = json::parse(run.out);
  EXPECT_GE(document["objects"], 640);
  EXPECT_EQ(document["frames"], 30);
  EXPECT_EQ(document["bytes"], std::filesystem::file_size(file));
}

TEST(LabCommands, AnOutputThatCannotBeWrittenEndsWithTwo) {
  std::ostream broken(nullptr);
  std::ostringstream err;
  Terminal terminal{.out = broken, .err = err};
  std::string words[] = {"sweepstake-lab", "pairs", "--scene", "two", "--objects", "2",
                         "--frame",        "0",     "--arm",   "SAP"};
  std::vector<char*> pointers;
  for (std::string& word : words) pointers.push_back(word.data());
  EXPECT_EQ(RunLaboratory(pointers, terminal), kBadUsage);
  EXPECT_THAT(err.str(), HasSubstr("cannot write to stdout"));
}

}  // namespace
}  // namespace sweepstake::cli
