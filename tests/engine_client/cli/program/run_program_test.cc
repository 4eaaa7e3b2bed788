// Tests `sweepstake run` as scripts use it: the numbers of a run must be consistent. Times are not
// compared, because the runs are short.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>
#include <sstream>

#include "tests/engine_client/cli/program/program.h"
#include "tests/support/file_text.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using test_support::FileText;
using testing::HasSubstr;

constexpr char kSmallGame[] = "run --scene suite-b --objects 100 --embedded ";
const std::string kSmallRun = std::string(kSmallGame) + "--duration 300ms ";

// Runs longer and longer games until one has switched arms, because a short game has too few frames
// on a busy machine. The paper's policy is used because it explores all arms, regardless of their
// costs.
ProgramRun RunUntilItSwitches(const std::string& options) {
  for (int duration_ms = 300;; duration_ms *= 2) {
    ProgramRun run = RunProgram(kSmallGame + std::string("--policy paper --time-scale 1000 ") +
                                "--duration " + std::to_string(duration_ms) + "ms " + options);
    const bool has_switched = run.out.find("(exploration)") != std::string::npos ||
                              run.out.find("\"reason\": \"exploration\"") != std::string::npos;
    if (has_switched || run.exit_code != 0 || duration_ms > 60'000) return run;
  }
}

size_t Lines(const std::string& text) {
  return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
}

TEST(RunProgram, EmbeddedPrintsOneDocumentWithConsistentNumbers) {
  const ProgramRun run = RunUntilItSwitches("--json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["decider"], "embedded");
  EXPECT_EQ(document["prior_sources"], 0);
  uint64_t frames = 0;
  for (const json& arm : document["arms"]) frames += arm["frames"].get<uint64_t>();
  EXPECT_EQ(frames, document["frames"].get<uint64_t>());
  EXPECT_GT(document["switches"].size(), 0U);
  size_t by_reason = 0;
  for (const json& count : document["switches_by_reason"]) by_reason += count.get<size_t>();
  EXPECT_EQ(by_reason, document["switches"].size());
  EXPECT_THAT(run.err, HasSubstr("no priors yet"));
}

TEST(RunProgram, RecordsTheFramesBeforeAFrameOverTheBudget) {
  const std::string folder = TemporaryPath("flights");
  std::filesystem::create_directories(folder);
  const ProgramRun run = RunProgram(std::string(kSmallGame) +
                                    "--duration 1500ms --json --flight-recorder 8 --frame-budget "
                                    "0.001 --flight-folder " +
                                    folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json recordings = json::parse(run.out)["recordings"];
  ASSERT_EQ(recordings.size(), 1U);
  const std::string file = recordings[0]["file"];
  EXPECT_EQ(recordings[0]["bytes"], std::filesystem::file_size(file));
  const ProgramRun replay = RunLab("replay --json --recording " + file);
  ASSERT_EQ(replay.exit_code, 0) << replay.err;
  const json document = json::parse(replay.out);
  EXPECT_EQ(document["scene"], "suite-b-100");
  EXPECT_EQ(document["worst_frame"]["frame_ms"], recordings[0]["worst_frame_ms"]);
  EXPECT_GE(document["box_frames"], 2U);
  EXPECT_EQ(document["arms"].size(), 7U);
  std::filesystem::remove_all(folder);
  EXPECT_EQ(RunProgram(kSmallRun + "--flight-recorder 8 --flight-folder " + folder).exit_code, 2);
}

TEST(RunProgram, ReportsTheWorkOfTheShadowLane) {
  const auto shadow_of = [](const std::string& options, int duration_ms) {
    const ProgramRun run = RunProgram(kSmallGame + std::string("--duration ") +
                                      std::to_string(duration_ms) + "ms --json " + options);
    EXPECT_EQ(run.exit_code, 0) << run.err;
    return json::parse(run.out)["shadow"];
  };
  const json off = json::parse(RunUntilItSwitches("--shadow off --json").out)["shadow"];
  EXPECT_EQ(off["state"], "off");
  EXPECT_EQ(off["visits"], 0);
  EXPECT_EQ(off["warm_switches"], 0);
  EXPECT_GT(off["cold_switches"].get<uint64_t>(), 0U);
  const json manual = shadow_of("--mode manual", 300);
  json on;
  // The lane uses idle cores only, so a busy machine leaves it little time.
  for (int duration_ms = 300; duration_ms <= 60'000; duration_ms *= 2) {
    on = shadow_of("--mode manual --shadow on", duration_ms);
    if (on["state"] == "off, no core to spare") return;
    if (on["visits"] >= 7) break;
  }
  EXPECT_EQ(manual["state"], "paused, because the mode is manual or the policy does not use it");
  EXPECT_EQ(manual["visits"], 0);
  EXPECT_EQ(on["state"], "running");
  EXPECT_GE(on["visits"].get<uint64_t>(), 7U);
  EXPECT_GT(on["copy_ns_per_frame"].get<double>(), 0);
  EXPECT_GT(on["frame_share"].get<double>(), 0);
  EXPECT_LT(on["frame_share"].get<double>(), 1);
  EXPECT_EQ(RunProgram(kSmallRun + "--shadow maybe").exit_code, 2);
}

// The first row of the log of decisions has the options of the decider.
TEST(RunProgram, UsesTheRulesThatItIsGiven) {
  const std::string folder = TemporaryPath("rules");
  const ProgramRun run = RunProgram(kSmallRun +
                                    "--policy paper --weights 0.25,0.25,0.5,0 --interval 50ms "
                                    "--cooldown 7s --settling 30ms --csv " +
                                    folder);
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const std::string log = FileText(folder + "/decisions.csv");
  EXPECT_THAT(log, HasSubstr(",paper,0.25,0.25,0.5,0,50000000,7000000000,30000000,"));
  std::filesystem::remove_all(folder);
}

TEST(RunProgram, PrintsSwitchesAndATableAsText) {
  const ProgramRun run = RunUntilItSwitches("");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  EXPECT_THAT(run.out, HasSubstr("no priors yet"));
  EXPECT_THAT(run.out, HasSubstr("(exploration)"));
  EXPECT_THAT(run.out, HasSubstr("KDTree 0.")) << "the posteriors when it switched";
  EXPECT_THAT(run.out, HasSubstr("Posteriors learnt in suite-b with 100 objects"));
  EXPECT_THAT(run.out, HasSubstr("Shadow lane: "));
}

TEST(RunProgram, ReportsThatThePriorsFileHasNoneForTheScene) {
  const std::string file = TemporaryPath("priors.json");
  std::ofstream(file) << R"({"format":"sweepstake-priors","version":1,"records":[]})";
  const ProgramRun run =
      RunProgram(kSmallRun + "--project p --machine-class m --json --priors " + file);
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_THAT(run.err, HasSubstr(file + " has no priors of these backends for project p, scene "
                                        "suite-b-100, machines m"));
  std::filesystem::remove(file);
}

// In the only scene of the file, Tracy is the cheaper of two arms.
TEST(PriorsArm, PrintsTheArmOfTheSceneOrOfTheProject) {
  json records = json::array();
  for (const auto& [arm, alpha] : {std::pair("SAP", 400), std::pair("Tracy", 600)}) {
    for (int version = 1; version <= 9; ++version) {
      records.push_back({{"project", "p"},
                         {"scene", "s"},
                         {"measured_by", "lane"},
                         {"arm", arm},
                         {"backend_version", version},
                         {"machine_class", "m"},
                         {"reward_version", 3},
                         {"source_id", "studio"},
                         {"source_sequence", 1},
                         {"alpha_increment", alpha},
                         {"beta_increment", 1000 - alpha},
                         {"window_count", 20}});
    }
  }
  const std::string file = TemporaryPath("priors.json");
  std::ofstream(file) << json{
      {"format", "sweepstake-priors"}, {"version", 1}, {"records", records}};
  const std::string command = "priors arm --in " + file + " --machine-class m --project ";
  const ProgramRun own = RunProgram(command + "p --scene s");
  EXPECT_EQ(own.out + own.err, "Tracy\n");
  EXPECT_EQ(json::parse(RunProgram(command + "p --scene s --json").out)["of"], "scene");
  const ProgramRun neighbour = RunProgram(command + "p --scene another --json");
  EXPECT_EQ(json::parse(neighbour.out)["arm"], "Tracy") << neighbour.err;
  EXPECT_EQ(json::parse(neighbour.out)["of"], "project");
  EXPECT_THAT(neighbour.err, HasSubstr("has no evidence that counts here for scene \"another\""));
  const ProgramRun unknown = RunProgram(command + "q --scene s");
  EXPECT_EQ(unknown.exit_code, 1);
  EXPECT_THAT(unknown.err,
              HasSubstr("the priors have no evidence of scene \"s\" of project \"q\""));
  std::filesystem::remove(file);
  EXPECT_EQ(RunProgram(command + "p --scene s").exit_code, 2) << "the file does not exist";
}

TEST(RunProgram, ManualModeStaysOnItsArm) {
  const ProgramRun run = RunProgram(kSmallRun + "--mode manual --arm SAP --time-scale 1000 --json");
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["active_arm"], "SAP");
  EXPECT_EQ(document["switches"].size(), 0U);
}

TEST(RunProgram, WritesFourCsvFiles) {
  const std::filesystem::path folder = TemporaryPath("csv");
  const ProgramRun run =
      RunProgram(kSmallRun + "--time-scale 1000 --json --csv " + folder.string());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(Lines(FileText(folder / "frames.csv")), 1 + document["frames"].get<size_t>());
  EXPECT_EQ(Lines(FileText(folder / "switches.csv")), 1 + document["switches"].size());
  EXPECT_EQ(Lines(FileText(folder / "posteriors.csv")), 1 + document["arms"].size());
  EXPECT_THAT(FileText(folder / "posteriors.csv"), HasSubstr("arm,backend_version,alpha"));
  EXPECT_EQ(std::distance(std::filesystem::directory_iterator(folder), {}), 4);
  const ProgramRun replay = RunLab("replay --json --log " + (folder / "decisions.csv").string());
  EXPECT_EQ(replay.exit_code, 0) << replay.out;
  EXPECT_GT(json::parse(replay.out)["decisions"], 0);
  std::filesystem::remove_all(folder);
}

TEST(RunProgram, ContinuesWithoutItsDaemonAndGivesExitCodeThree) {
  // Port 1 of the loopback has no listener.
  const ProgramRun run =
      RunProgram("run --scene suite-b --objects 100 --daemon 127.0.0.1:1 --duration 300ms --json");
  EXPECT_EQ(run.exit_code, 3);
  EXPECT_GT(json::parse(run.out)["frames"].get<uint64_t>(), 0U);
  EXPECT_THAT(run.err, HasSubstr("no session with 127.0.0.1:1"));
  const ProgramRun text =
      RunProgram("run --scene suite-b --objects 100 --daemon 127.0.0.1:1 --duration 300ms");
  EXPECT_THAT(text.out, HasSubstr("start one with sweepstaked --listen 127.0.0.1:1, or use"));
}

TEST(RunProgram, BadUsageGivesExitCodeTwoAndListsValidValues) {
  ExpectBadUsage(RunProgram,
                 {
                     {"run --scene suite-b", "--embedded"},
                     {"run --scene suite-b --embedded --daemon 127.0.0.1:1", "--embedded"},
                     {"run --scene suite-b --daemon nowhere", "nowhere"},
                     {"run --scene suite-b --daemon 127.0.0.1:1 --priors x.json", "--priors"},
                     {"run --scene suite-b --embedded --priors no-such.json", "no-such.json"},
                     {"run --scene suite-b --embedded --duration soon", "60s"},
                     {"run --scene suite-b --embedded --arm Octree", "KDTree"},
                     {"run --scene suite-b --embedded --seed -1", "--seed: -1 is negative"},
                     {"run --scene suite-b --embedded --mode auto", "manual"},
                     {"run --scene suite-b --embedded --policy coin", "paper"},
                     {"run --scene suite-b --embedded --time-scale 0", "--time-scale"},
                     {"run --scene suite-b --embedded --view", "--view needs a terminal"},
                     {"run --scene suite-b --embedded --view --json", "--json excludes --view"},
                     {"run --scene nowhere --embedded", "hurricane"},
                 });
}

}  // namespace
}  // namespace sweepstake::cli
