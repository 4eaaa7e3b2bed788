// Tests of `sweepstake priors show|doctor|diff|merge|arm`.
#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <cmath>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <string>
#include <thread>
#include <vector>

#include "engine_client/cli/io/whole_file.h"
#include "engine_client/decider/embedded/priors_file.h"
#include "engine_client/decider/policy/log_cost.h"
#include "engine_client/decider/pooling/priors_sums.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/machine_class.h"
#include "tests/engine_client/cli/command_run.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;
using testing::Not;

// Returns a record of 50 windows of a source.
PriorRecord RecordOf(const std::string& source, const std::string& arm, double cost_us) {
  const decision::Increment window =
      decision::LogCostIncrement(0, decision::RewardOf(std::log(cost_us)), 0.02 * 0.02);
  return {.key = {.project = "arcade",
                  .scene = "arena",
                  .measured_by = "",
                  .arm = arm,
                  .backend_version = (*MakeBroadPhase(arm))->version(),
                  .machine_class = MachineClass(),
                  .reward_version = decision::kLogCostRewardVersion},
          .source_id = source,
          .source_sequence = 1,
          .evidence = {.alpha = 50 * window.alpha, .beta = 50 * window.beta, .window_count = 50},
          .build = "1.1",
          .last_seen_unix_s = 0};
}

// Returns records in which Grid costs half as much as SAP.
std::vector<PriorRecord> Honest() {
  return {RecordOf("a", "Grid", 100), RecordOf("a", "SAP", 200)};
}

class PriorsFilesTest : public testing::Test {
 protected:
  std::string Write(const std::string& name, const std::vector<PriorRecord>& records) {
    const std::string path = (folder_.path() / name).string();
    EXPECT_TRUE(WriteWhole(path, FormatPriors(records)).ok());
    return path;
  }
  // Returns the only entry of the doctor's output for build 1.1.
  json Diagnose(const std::vector<PriorRecord>& records) {
    const CommandRun run =
        RunCommand("priors doctor --json --build 1.1 --in " + Write("sick.json", records));
    const json entries = json::parse(run.out)["entries"];
    EXPECT_EQ(entries.size(), 1u);
    EXPECT_EQ(run.exit_code, entries[0]["fitness"] == "foreign" ? 1 : 0);
    return entries[0];
  }

  test_support::TemporaryDirectory folder_;
};

// The sum of both regimes would show no difference between the arms.
// As of `zcat priors.json.gz | sweepstake priors show --in /dev/stdin`.
TEST_F(PriorsFilesTest, APipeIsRead) {
  const std::string pipe = (folder_.path() / "pipe").string();
  ASSERT_EQ(mkfifo(pipe.c_str(), 0600), 0);
  std::thread writer([&] { std::ofstream(pipe) << FormatPriors(Honest()); });
  const auto records = ReadPriorsFile(pipe);
  writer.join();
  ASSERT_TRUE(records.ok()) << records.status().message();
  EXPECT_EQ(records->size(), 2u);
  EXPECT_EQ(ReadPriorsFile(folder_.path()).status().code(), StatusCode::kNotFound);
}

TEST_F(PriorsFilesTest, ShowsEachRegime) {
  std::vector<PriorRecord> records = {RecordOf("a", "Grid", 100), RecordOf("a", "SAP", 200),
                                      RecordOf("a", "Grid", 200), RecordOf("a", "SAP", 100)};
  for (size_t i = 0; i < 4; ++i) records[i].key.regime = i < 2 ? "9/-7/0" : "9/0/-";
  const std::string file = Write("regimes.json", records);
  const json scenes = json::parse(RunCommand("priors show --json --in " + file).out)["scenes"];
  ASSERT_EQ(scenes.size(), 2u);
  for (size_t i = 0; i < 2; ++i) {
    EXPECT_EQ(scenes[i]["regime"], i == 0 ? "9/-7/0" : "9/0/-");
    EXPECT_EQ(scenes[i]["arms"][i]["cost_ratio"], 1.0);
    EXPECT_NEAR(scenes[i]["arms"][1 - i]["cost_ratio"].get<double>(), 2, 0.1);
  }
  const std::string text = RunCommand("priors show --in " + file).out;
  EXPECT_THAT(text, HasSubstr("in build 1.1, 545 to 1,096 objects"));
  EXPECT_THAT(text, AllOf(HasSubstr(" objects, speed 0.0009 to 0.0025, 0 to 30 % static"),
                          HasSubstr(" speed 1.0000 to 2.7183")));
}

TEST_F(PriorsFilesTest, SumsCountLikeTheirSessionsAndCannotBeImported) {
  std::vector<PriorRecord> sessions = Honest();
  for (const PriorRecord& record : Honest()) sessions.emplace_back(record).source_id = "b";
  const std::string file = Write("sums.json", SumByBuild(sessions));
  const json scenes = json::parse(RunCommand("priors show --json --in " + file).out)["scenes"];
  const std::string of_sessions = Write("sessions.json", sessions);
  const json others =
      json::parse(RunCommand("priors show --json --in " + of_sessions).out)["scenes"];
  ASSERT_EQ(scenes[0]["arms"].size(), 2u);
  for (size_t arm = 0; arm < 2; ++arm) {
    EXPECT_EQ(scenes[0]["arms"][arm]["arm"], others[0]["arms"][arm]["arm"]);
    EXPECT_NEAR(scenes[0]["arms"][arm]["cost_ratio"].get<double>(),
                others[0]["arms"][arm]["cost_ratio"].get<double>(), 0.002);
  }
  const CommandRun refused = RunCommand("priors import --daemon localhost:1 --in " + file);
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("export the evidence without --sums"));
}

TEST_F(PriorsFilesTest, ShowPrintsCostsRelativeToTheCheapestArm) {
  std::vector<PriorRecord> records = Honest();
  records.push_back(RecordOf("b", "Grid", 100));
  records.back().key.measured_by = "lane";
  const std::string file = Write("p.json", records);
  const json scene = json::parse(RunCommand("priors show --json --in " + file).out)["scenes"][0];
  EXPECT_EQ(scene["project"], "arcade");
  EXPECT_EQ(scene["build"], "1.1");
  EXPECT_EQ(scene["sources"], 2);
  EXPECT_EQ(scene["arms"][0]["arm"], "Grid");
  EXPECT_EQ(scene["arms"][0]["windows"], 50);
  EXPECT_EQ(scene["arms"][0]["visits"], 50);
  EXPECT_NEAR(scene["arms"][1]["cost_ratio"], 2, 0.1);
  EXPECT_THAT(RunCommand("priors show --in " + file).out,
              AllOf(HasSubstr("arcade/arena on " + MachineClass() + " in build 1.1, 2 sources"),
                    HasSubstr("Grid")));
  EXPECT_EQ(RunCommand("priors show --in " + Write("none.json", {})).out,
            (folder_.path() / "none.json").string() + " has no records\n");
}

TEST_F(PriorsFilesTest, TheDoctorShowsWhatCountsAndWhyTheRestDoesNot) {
  const std::vector<PriorRecord> healthy = Honest();
  EXPECT_EQ(Diagnose(healthy)["fitness"], "valid");
  EXPECT_EQ(Diagnose(healthy)["weight"], 1);
  const auto changed = [&](auto change) {
    std::vector<PriorRecord> records = healthy;
    for (PriorRecord& record : records) change(record);
    return Diagnose(records);
  };
  const json build = changed([](PriorRecord& record) { record.build = "1.0"; });
  EXPECT_EQ(build["fitness"], "near");
  EXPECT_EQ(build["reasons"][0], "measured by build 1.0");
  const json machine = changed([](PriorRecord& record) { record.key.machine_class = "console"; });
  EXPECT_EQ(machine["fitness"], "near");
  EXPECT_THAT(machine["reasons"][0], HasSubstr("measured on console"));
  EXPECT_LT(machine["weight"], build["weight"]);
  const json reward = changed([](PriorRecord& record) { record.key.reward_version = 1; });
  EXPECT_EQ(reward["fitness"], "foreign");
  EXPECT_EQ(reward["weight"], 0);
  EXPECT_THAT(reward["reasons"][0],
              HasSubstr("learnt by the policy paper, which the default policy cannot use"));
  EXPECT_EQ(changed([](PriorRecord& record) { record.key.arm = "Octree"; })["fitness"], "foreign");
  const json old = changed([](PriorRecord& record) { record.last_seen_unix_s = 1'000'000'000; });
  EXPECT_EQ(old["fitness"], "valid");
  EXPECT_THAT(old["reasons"][0], HasSubstr("days old, which does not reduce its weight"));
  std::vector<PriorRecord> newer = Honest();
  for (PriorRecord& record : newer) record.key.backend_version = 99;
  newer.insert(newer.begin(), healthy.begin(), healthy.end());
  EXPECT_EQ(Diagnose(newer)["fitness"], "valid")
      << "evidence of this program's version counts in full";
  const CommandRun empty = RunCommand("priors doctor --in " + Write("none.json", {}));
  EXPECT_EQ(empty.exit_code, 1);
  EXPECT_THAT(empty.out, HasSubstr("none.json has no records\n"));
}

TEST_F(PriorsFilesTest, QuarantinedRecordsAreMarkedAndDoNotCount) {
  std::vector<PriorRecord> records = Honest();
  for (PriorRecord& record : records) record.is_quarantined = true;
  const json entry = Diagnose(records);
  EXPECT_EQ(entry["fitness"], "foreign");
  EXPECT_EQ(entry["quarantined"], true);
  EXPECT_THAT(entry["reasons"][0].get<std::string>(), HasSubstr("it is in quarantine"));
  const std::string waiting = Write("waiting.json", records);
  EXPECT_THAT(RunCommand("priors show --in " + waiting).out,
              HasSubstr("in build 1.1 (in quarantine), 1 source\n"));
  EXPECT_THAT(RunCommand("priors diff " + Write("counts.json", Honest()) + " " + waiting).out,
              HasSubstr("The files agree on every scene"))
      << "diff shows the effect of a promotion";
}

// The file has one arm in another version, and one arm that this program does not have.
TEST_F(PriorsFilesTest, AChangedArmDoesNotReduceTheWeightOfTheOthers) {
  std::vector<PriorRecord> records = Honest();
  records[0].key.backend_version += 1;
  records.push_back(RecordOf("a", "Grid", 300));
  records.back().key.arm = "Octree";
  const json entry = Diagnose(records);
  EXPECT_EQ(entry["fitness"], "near");
  EXPECT_EQ(entry["weight"], 1) << "the weight of SAP, whose version is the same";
  EXPECT_EQ(entry["reasons"].size(), 2u);
  EXPECT_THAT(entry["reasons"][0].get<std::string>(), HasSubstr("), and counts 4 %"));
  for (PriorRecord& record : records) record.is_quarantined = true;
  EXPECT_THAT(Diagnose(records)["reasons"].dump(), Not(HasSubstr("and counts 4")));
}

TEST_F(PriorsFilesTest, DiffNamesTheScenesInWhichTwoFilesDiffer) {
  std::vector<PriorRecord> later = Honest();
  later[1] = RecordOf("a", "SAP", 50);
  for (PriorRecord& record : Honest()) {
    record.key.scene = "harbour";
    later.push_back(record);
  }
  std::vector<PriorRecord> before = Honest();
  before.insert(before.end(), later.begin() + 2, later.end());
  const std::string files = Write("before.json", before) + " " + Write("later.json", later);
  const json scenes = json::parse(RunCommand("priors diff --json " + files).out)["scenes"];
  ASSERT_EQ(scenes.size(), 1u);
  EXPECT_EQ(scenes[0]["scene"], "arena");
  EXPECT_EQ(scenes[0]["leader_changed"], true);
  EXPECT_NEAR(scenes[0]["arms"][1]["before"], 2, 0.1);
  EXPECT_EQ(scenes[0]["arms"][1]["after"], 1);
  EXPECT_THAT(RunCommand("priors diff " + files).out,
              AllOf(HasSubstr("the cheapest arm differs"), Not(HasSubstr("harbour"))));
  const std::string same = Write("same.json", before);
  EXPECT_EQ(RunCommand("priors diff " + same + " " + same).out,
            "The files agree on every scene to within 5 %.\n");
}

TEST_F(PriorsFilesTest, DiffMarksScenesThatOneFileDoesNotHave) {
  const std::string files = Write("some.json", Honest()) + " " + Write("none.json", {});
  EXPECT_THAT(
      RunCommand("priors diff " + files).out,
      AllOf(HasSubstr("only one of the files has evidence of it"), Not(HasSubstr("cheapest"))));
  const json scenes = json::parse(RunCommand("priors diff --json " + files).out)["scenes"];
  EXPECT_EQ(scenes[0]["leader_changed"], false);
  const CommandRun typo = RunCommand("priors diff " + files + " --build 9");
  EXPECT_EQ(typo.exit_code, 1);
  EXPECT_THAT(typo.err, HasSubstr("some.json has no evidence of build 9; builds: 1.1"));
  EXPECT_THAT(RunCommand("priors diff " + files + " --other-build 1.1").err,
              HasSubstr("none.json has no evidence of build 1.1"));
}

TEST_F(PriorsFilesTest, DiffComparesTwoBuildsOfOneFile) {
  std::vector<PriorRecord> records = Honest();
  records.push_back(RecordOf("b", "Grid", 100));
  records.push_back(RecordOf("b", "SAP", 150));
  records[2].build = records[3].build = "1.2";
  const std::string file = Write("builds.json", records);
  const std::string diff = "priors diff --json " + file + " " + file + " --build 1.1";
  const json scenes = json::parse(RunCommand(diff + " --other-build 1.2").out)["scenes"];
  ASSERT_EQ(scenes.size(), 1u);
  EXPECT_EQ(scenes[0]["leader_changed"], false);
  EXPECT_NEAR(scenes[0]["arms"][1]["after"], 1.5, 0.1);
  EXPECT_TRUE(json::parse(RunCommand(diff + " --other-build 1.1").out)["scenes"].empty());
}

TEST_F(PriorsFilesTest, MergeKeepsTheLaterRecordOfEachSource) {
  std::vector<PriorRecord> theirs = {RecordOf("a", "Grid", 100), RecordOf("b", "SAP", 200)};
  theirs[0].source_sequence = 2;
  theirs[0].evidence.window_count = 70;
  const std::string out = (folder_.path() / "all.json").string();
  const CommandRun run = RunCommand("priors merge " + Write("ours.json", Honest()) + " " +
                                    Write("theirs.json", theirs) + " --out " + out);
  EXPECT_EQ(run.out, out + ": 3 records\n");
  const auto merged = ReadPriorsFile(out);
  ASSERT_TRUE(merged.ok());
  EXPECT_EQ((*merged)[0].evidence.window_count, 70u);
  const CommandRun nowhere =
      RunCommand("priors merge " + out + " " + out + " --out /nonexistent/p");
  EXPECT_EQ(nowhere.exit_code, 2);
  EXPECT_THAT(nowhere.err, HasSubstr("/nonexistent/p"));
}

// A sum may contain the evidence of sessions in the other file.
TEST_F(PriorsFilesTest, MergeCountsNothingTwice) {
  const std::string sums = Write("sums.json", SumByBuild(Honest()));
  const std::string sessions = Write("sessions.json", Honest());
  const std::string out = (folder_.path() / "all.json").string();
  const auto merge = [&](const std::string& files) {
    return RunCommand("priors merge " + files + " --out " + out);
  };
  for (const std::string& files : {sums + " " + sessions, sessions + " " + sums}) {
    const CommandRun refused = merge(files);
    EXPECT_EQ(refused.exit_code, 2);
    EXPECT_THAT(refused.err, AllOf(HasSubstr("arcade/arena"), HasSubstr("would count twice")));
    EXPECT_FALSE(std::filesystem::exists(out));
  }
  std::vector<PriorRecord> played = SumByBuild(Honest());
  played.push_back(RecordOf("own", "SAP", 200));
  const std::string save = Write("played.json", played);
  EXPECT_EQ(merge(sums + " " + save).out, out + ": 3 records\n")
      << "the save started from these sums";
  std::vector<PriorRecord> later = Honest();
  later.push_back(RecordOf("own", "SAP", 200));
  const std::string later_sums = Write("later.json", SumByBuild(later));
  EXPECT_EQ(merge(later_sums + " " + save).exit_code, 2)
      << "the sums may contain the save's session";
  EXPECT_EQ(merge(save + " " + later_sums).exit_code, 2);
}

TEST_F(PriorsFilesTest, ArmIsTheCheapestOfTheScene) {
  const std::string arm = "priors arm --project arcade --in " + Write("p.json", Honest());
  EXPECT_EQ(RunCommand(arm + " --scene arena").out, "Grid\n");
  EXPECT_EQ(RunCommand(arm + " --scene desert").out, "Grid\n") << "from the project's other scenes";
}

}  // namespace
}  // namespace sweepstake::cli
