// Tests of the commands that connect to a daemon, with a real daemon.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <nlohmann/json.hpp>

#include "server/storage/sqlite_database.h"
#include "server/storage/sqlite_prior_store.h"
#include "sweepstake/embedded_decider.h"
#include "tests/engine_client/cli/program/program.h"
#include "tests/server/storage/evidence_samples.h"
#include "tests/support/child_process.h"
#include "tests/support/daemon_process.h"
#include "tests/support/file_text.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using ::sweepstake::test_support::DaemonProcess;
using ::sweepstake::test_support::TemporaryDirectory;
using ::testing::HasSubstr;

constexpr char kNobody[] = "127.0.0.1:1";

bool HasLearnt(const ProgramRun& run) {
  const json arms = json::parse(run.out)["arms"];
  return std::any_of(arms.begin(), arms.end(),
                     [](const json& arm) { return arm["live_windows"] > 0; });
}

// Runs a game that explores the arms every few milliseconds, so that the daemon stores evidence. On
// a slow machine one second may have too few frames to learn anything; then a longer game follows.
ProgramRun Learn(const DaemonProcess& daemon, int time_scale = 1000) {
  for (int seconds = 1;; seconds *= 2) {
    ProgramRun run = RunProgram(
        "run --scene suite-b --objects 100 --project p --scene-name s --machine-class m "
        "--time-scale " +
        std::to_string(time_scale) + " --json --duration " + std::to_string(seconds) +
        "s --daemon " + daemon.address());
    if (run.exit_code != 0 || HasLearnt(run)) return run;
  }
}

TEST(DaemonProgram, CommandsGiveExitCodeThreeIfNoDaemonAnswers) {
  for (const std::string command : {"watch", "priors list", "priors export --out never.json",
                                    "audit list", "audit export --out never.json"}) {
    const ProgramRun run = RunProgram(command + " --daemon " + kNobody);
    EXPECT_EQ(run.exit_code, 3) << command;
    EXPECT_THAT(run.err, HasSubstr("no daemon answered at 127.0.0.1:1")) << command;
    EXPECT_EQ(run.out, "") << command;
  }
  EXPECT_FALSE(std::ifstream("never.json").good());
}

TEST(DaemonProgram, BadUsageGivesExitCodeTwo) {
  ExpectBadUsage(
      RunEither,
      {
          {"watch", "--daemon"},
          {"watch --daemon nowhere", "nowhere"},
          {"priors",
           "the commands of priors are list, export, import, promote, revoke, show, "
           "doctor, diff, merge, arm"},
          {"audit", "the commands of audit are list, export"},
          {"audit export --daemon 127.0.0.1:1", "--out"},
          {"audit export --daemon 127.0.0.1:1 --out no-such-folder/a.csv", "no-such-folder"},
          {"replay --log no-such.csv", "no-such.csv cannot be read"},
          {"replay --log a.csv --costs a.costs", "--log FILE.csv"},
          {"priors import --daemon 127.0.0.1:1 --in no-such.json", "no-such.json"},
      });
}

TEST(DaemonProgram, AnInvalidFlagEndsTheDaemonWithExitCodeTwo) {
  for (const char* flag : {"--insecure=maybe", "--no-insecure=maybe",
                           "--insecure=", "--decision-explore=99999999999999999999"}) {
    const ProgramRun run = RunDaemonProgram(std::string(flag) + " --print-config");
    EXPECT_EQ(run.exit_code, 2) << flag;
    EXPECT_THAT(run.err, HasSubstr("sweepstaked: --")) << flag;
    EXPECT_EQ(run.out, "") << flag;
  }
  const ProgramRun run = RunDaemonProgram("--decision-explore=false --print-config");
  EXPECT_THAT(run.out, HasSubstr("explore = false"));
}

TEST(DaemonProgram, AnUnknownWordSuggestsTheNearestInOneShortLine) {
  const std::pair<const char*, const char*> cases[] = {
      {"token list --jsn", "unknown option '--jsn', the nearest is --json; --help lists all\n"},
      {"--lissten=x", "unknown option '--lissten', the nearest is --listen; --help lists all\n"},
      {"token lst", "unknown command of token 'lst', must be one of list, create, revoke\n"},
      {"token creat x --role watch", "unknown command of token 'creat', must be one of create, "},
      {"chek-config a",
       "unknown command of sweepstaked 'chek-config', must be one of check-config"},
      {"--insecure maybe", "unknown command of sweepstaked 'maybe', must be one of "},
      {"backup a b c", "backup: unexpected argument 'b'; --help lists the arguments\n"},
  };
  for (const auto& [arguments, said] : cases) {
    const ProgramRun run = RunDaemonProgram(arguments);
    EXPECT_EQ(run.exit_code, 2) << arguments;
    EXPECT_THAT(run.err, HasSubstr(said)) << arguments;
    EXPECT_LT(run.err.size(), 140u) << run.err;
  }
}

TEST(DaemonProgram, AMisspeltOptionIsReportedBeforeAMissingOne) {
  const ProgramRun create = RunDaemonProgram("token create game --rol ingest");
  EXPECT_EQ(create.exit_code, 2);
  EXPECT_THAT(create.err, HasSubstr("unknown option '--rol', the nearest is --role"));
  const ProgramRun backup = RunDaemonProgram("backup --dta");
  EXPECT_EQ(backup.exit_code, 2);
  EXPECT_THAT(backup.err, HasSubstr("unknown option '--dta', the nearest is --data"));
  EXPECT_THAT(RunDaemonProgram("backup").err, HasSubstr("file is required"));
}

TEST(DaemonProgram, EveryInvalidLineOfAConfigurationIsReported) {
  const TemporaryDirectory folder;
  const std::string path = (folder.path() / "daemon.toml").string();
  std::ofstream(path) << "lissten = 'x'\nmax_scenes = 0\n";
  const ProgramRun checked = RunDaemonProgram("check-config " + path);
  EXPECT_EQ(checked.exit_code, 1);
  EXPECT_THAT(checked.err, HasSubstr("sweepstaked: " + path + ":1: unknown setting 'lissten'"));
  EXPECT_THAT(checked.err, HasSubstr("\nsweepstaked: " + path + ":2: max_scenes: Value 0 not in"));
}

TEST(DaemonProgram, ADirectoryIsRejectedAsConfiguration) {
  const TemporaryDirectory folder;
  const std::string path = folder.path().string();
  EXPECT_EQ(RunDaemonProgram("--print-config --config " + path).exit_code, 2);
  const ProgramRun checked = RunDaemonProgram("check-config " + path);
  EXPECT_EQ(checked.exit_code, 1);
  EXPECT_THAT(checked.err, HasSubstr("is a directory"));
}

TEST(DaemonProgram, TheDaemonAndTheCommandLineHaveTheSameVersion) {
  const ProgramRun run = RunDaemonProgram("--version");
  EXPECT_EQ(run.exit_code, 0);
  EXPECT_EQ(run.out, RunProgram("--version").out);
}

TEST(DaemonProgram, ABackupOfARunningDaemonCanStartAnotherDaemon) {
  const TemporaryDirectory folder;
  const TemporaryDirectory data_folder;
  const std::string data = data_folder.path().string();
  const std::string file = (folder.path() / "monday.db").string();
  const std::string other = (folder.path() / "other").string();
  const DaemonProcess daemon(data);
  ASSERT_EQ(Learn(daemon).exit_code, 0);
  const ProgramRun backup = RunDaemonProgram("backup " + file + " --data " + data);
  EXPECT_EQ(backup.exit_code, 0) << backup.err;
  EXPECT_THAT(backup.out, HasSubstr("monday.db: undamaged; "));
  EXPECT_EQ(RunDaemonProgram("backup " + file + " --data " + data).exit_code, 1);
  EXPECT_EQ(RunDaemonProgram("restore " + file + " --verify").out, backup.out);
  const ProgramRun piped = RunDaemonProgram("backup - --data " + data);
  EXPECT_EQ(piped.exit_code, 0) << piped.err;
  EXPECT_THAT(piped.err, HasSubstr("standard output: undamaged; "));
  const std::string copy = (folder.path() / "piped.db").string();
  std::ofstream(copy, std::ios::binary) << piped.out;
  EXPECT_EQ(RunDaemonProgram("restore " + copy + " --verify").exit_code, 0);
  // The reader ends after one block.
  const std::string cut = "set -o pipefail; " SWEEPSTAKED_PATH " backup - --data '" + data +
                          "' 2>'" + copy + ".err' | head -c 4096 >/dev/null";
  EXPECT_NE(std::system(("bash -c \"" + cut + "\"").c_str()), 0);
  EXPECT_THAT(test_support::FileText(copy + ".err"), HasSubstr("cannot write the whole backup"));
  const std::string closed = SWEEPSTAKED_PATH " backup - --data '" + data + "' >&- 2>/dev/null";
  EXPECT_NE(std::system(closed.c_str()), 0);
  EXPECT_EQ(RunDaemonProgram("restore " + file + " --data " + data).exit_code, 1);
  const ProgramRun restore = RunDaemonProgram("restore " + file + " --data " + other);
  EXPECT_EQ(restore.exit_code, 0) << restore.err;
  const DaemonProcess next(other);
  const auto list = [](const DaemonProcess& of) {
    return json::parse(RunProgram("priors list --json --daemon " + of.address()).out)["scenes"];
  };
  EXPECT_EQ(list(next), list(daemon));
}

TEST(DaemonProgram, ABackupThatOmitsDamagedRowsIsKeptAndReported) {
  const TemporaryDirectory folder;
  const TemporaryDirectory data;
  const std::string file = (folder.path() / "monday.db").string();
  const auto path = data.path() / "priors.db";
  ASSERT_TRUE((*storage::OpenSqlitePriorStore(path))
                  ->Commit(std::vector{storage::Update("a", 1, {storage::Key("Grid")}),
                                       storage::Update("b", 1, {storage::Key("Grid")})})
                  .ok());
  ASSERT_TRUE(
      storage::SqliteDatabase::Open(path.string(), storage::SqliteDatabase::OpenMode::kExisting)
          ->Execute("UPDATE evidence SET alpha = 1000 WHERE source_id = 1")
          .ok());
  const ProgramRun backup = RunDaemonProgram("backup " + file + " --data " + data.path().string());
  EXPECT_EQ(backup.exit_code, 1);
  EXPECT_THAT(backup.out, HasSubstr("monday.db: undamaged; 1 record of 1 source"));
  EXPECT_THAT(backup.err, HasSubstr("1 damaged rows of the database are not in " + file));
  EXPECT_EQ(RunDaemonProgram("restore " + file + " --verify").exit_code, 0);
}

TEST(DaemonProgram, RestoreReportsADamagedBackup) {
  const TemporaryDirectory folder;
  const std::string file = (folder.path() / "monday.db").string();
  std::ofstream(file) << std::string(5000, 'x');
  const ProgramRun run = RunDaemonProgram("restore " + file + " --verify");
  EXPECT_EQ(run.exit_code, 1);
  EXPECT_THAT(run.err, HasSubstr("is not a Sweepstake database"));
  EXPECT_EQ(RunDaemonProgram("restore").exit_code, 2);
}

TEST(DaemonProgram, ARunThatTheDaemonRefusesEndsAtOnceWithItsMessage) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  const ProgramRun run =
      RunProgram("run --scene suite-b --objects 100 --policy coin --duration 10m --daemon " +
                 daemon.address());
  EXPECT_EQ(run.exit_code, 2);
  EXPECT_THAT(run.err, HasSubstr("refuses the session: unknown policy 'coin', must be one of "));
  EXPECT_EQ(run.out, "");
}

TEST(DaemonProgram, ARunSetsTheRulesOfItsSession) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  const std::string run = "run --scene suite-b --objects 100 --policy paper --json --duration ";
  const ProgramRun played = RunProgram(
      run +
      "1s --weights 0.25,0.25,0.5,0 --interval 500ms --cooldown 7s --settling 30ms --daemon " +
      daemon.address());
  ASSERT_EQ(played.exit_code, 0) << played.err;
  const json rules = json::parse(played.out)["daemon"];
  EXPECT_EQ(rules["weights"], (std::vector<double>{0.25, 0.25, 0.5, 0}));
  EXPECT_EQ(rules["interval_s"], 0.5);
  EXPECT_EQ(rules["cooldown_s"], 7);
  EXPECT_EQ(rules["settling_s"], 0.03);
  const ProgramRun refused = RunProgram(run + "10m --interval 100ms --daemon " + daemon.address());
  EXPECT_EQ(refused.exit_code, 2);
  EXPECT_THAT(refused.err, HasSubstr("decision_interval_ns is 100000000; a daemon decides at most "
                                     "four times a second, so use 250000000 or more"));
}

TEST(DaemonProgram, ARunLearnsAndTheNextRunStartsFromItsPriors) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  const ProgramRun first = Learn(daemon);
  ASSERT_EQ(first.exit_code, 0) << first.err;
  EXPECT_EQ(json::parse(first.out)["prior_sources"], 0);
  EXPECT_THAT(first.err, HasSubstr("no priors yet"));
  const ProgramRun second = Learn(daemon);
  ASSERT_EQ(second.exit_code, 0) << second.err;
  EXPECT_EQ(json::parse(second.out)["prior_sources"], 1);
  EXPECT_THAT(second.err, HasSubstr("starts from priors of 1 earlier session"));
}

TEST(DaemonProgram, ARunThatAllowsOrdersFollowsAnOperator) {
  const TemporaryDirectory data;
  const DaemonProcess daemon(data.path());
  const test_support::ChildProcess game(
      {SWEEPSTAKE_PROGRAM, "run", "--scene", "suite-b", "--objects", "50", "--allow-orders",
       "--duration", "10m", "--json", "--daemon", daemon.address()},
      data.path() / "game.log");
  const std::string at = " --daemon " + daemon.address();
  json sessions;
  while (sessions.empty()) {  // ends with the test's timeout
    sessions = json::parse(RunProgram("sessions list --json" + at).out)["sessions"];
  }
  const std::string id = sessions[0]["session_id"];
  const ProgramRun pin = RunProgram("sessions pin " + id + " Grid" + at);
  EXPECT_EQ(pin.exit_code, 0) << pin.err;
  EXPECT_EQ(pin.out, id + " follows the order: manual, Grid is active\n");
  EXPECT_EQ(RunProgram("sessions release " + id + at).exit_code, 0);
  const ProgramRun wrong = RunProgram("sessions pin " + id + "0 Grid" + at);
  EXPECT_EQ(wrong.exit_code, 1) << "the command line is valid: " << wrong.err;
}

TEST(DaemonProgram, WatchShowsThePosteriorsAsJsonAndAsText) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  ASSERT_EQ(Learn(daemon).exit_code, 0);
  const ProgramRun run = RunProgram("watch --scene s --json --daemon " + daemon.address());
  ASSERT_EQ(run.exit_code, 0) << run.err;
  const json scenes = json::parse(run.out)["scenes"];
  ASSERT_EQ(scenes.size(), 1U);
  EXPECT_EQ(scenes[0]["project"], "p");
  EXPECT_GT(scenes[0]["arms"].size(), 0U);
  const ProgramRun text = RunProgram("watch --once --daemon " + daemon.address());
  EXPECT_EQ(text.exit_code, 0);
  EXPECT_THAT(text.out, HasSubstr("p / s on m"));
}

TEST(DaemonProgram, PriorsMoveFromOneDaemonToAnotherAndIntoAGame) {
  const TemporaryDirectory data;
  const TemporaryDirectory other_data;
  DaemonProcess daemon(data.path());
  DaemonProcess other(other_data.path());
  ASSERT_EQ(Learn(daemon).exit_code, 0);
  const std::string file = (data.path() / "priors.json").string();

  const ProgramRun exported =
      RunProgram("priors export --json --out " + file + " --daemon " + daemon.address());
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  const json records = json::parse(exported.out)["records"];
  EXPECT_GT(records, 0);

  const std::string import = "priors import --json --in " + file + " --daemon " + other.address();
  const ProgramRun imported = RunProgram(import);
  ASSERT_EQ(imported.exit_code, 0) << imported.err;
  EXPECT_EQ(json::parse(imported.out)["applied"], records);
  EXPECT_EQ(json::parse(RunProgram(import).out)["unchanged"], records);
  EXPECT_EQ(json::parse(RunProgram(import + " --promote").out)["applied"], records);

  const ProgramRun listed = RunProgram("priors list --json --daemon " + other.address());
  EXPECT_EQ(json::parse(listed.out)["scenes"].size(), 1U);

  const ProgramRun game = RunProgram(
      "run --scene suite-b --objects 100 --project p --scene-name s --machine-class m --embedded "
      "--duration 200ms --json --priors " +
      file);
  ASSERT_EQ(game.exit_code, 0) << game.err;
  EXPECT_EQ(json::parse(game.out)["prior_sources"], 1);
}

// Simulates one minute of a game with the embedded decider, and returns the path of the exported
// priors.
std::string PlayOffline(const std::filesystem::path& file) {
  EmbeddedOptions options;
  options.project = "p";
  options.scene = "s";
  options.source_id = "player";
  if (std::filesystem::exists(file)) options.priors_file = file.string();
  const std::vector<std::string> arms = {"Grid", "SAP"};
  auto decider = std::move(*EmbeddedDecider::Create(options, arms, std::vector<uint32_t>{1, 1}, 0));
  FrameSample frame{};
  frame.frame_time_ns = 16'000'000;
  frame.detection_time_ns = 8'000'000;
  for (uint64_t now_ns = 0; now_ns < 60'000'000'000; now_ns += frame.frame_time_ns) {
    decider->Observe({&frame, 1}, now_ns);
    decider->Poll(now_ns);
    ++frame.frame_index;
  }
  std::ofstream(file) << decider->ExportPriors();
  return file.string();
}

TEST(DaemonProgram, OfflineEvidenceCountsOnceHoweverOftenItIsImported) {
  const TemporaryDirectory data;
  const TemporaryDirectory saves;
  const DaemonProcess daemon(data.path());
  const std::string at = " --json --daemon " + daemon.address();
  for (int run = 1; run <= 2; ++run) {
    const std::string import =
        "priors import --promote --in " + PlayOffline(saves.path() / "save.json") + at;
    const ProgramRun imported = RunProgram(import);
    ASSERT_EQ(imported.exit_code, 0) << imported.err;
    EXPECT_EQ(json::parse(imported.out)["applied"], 1);
    EXPECT_EQ(json::parse(RunProgram(import).out)["unchanged"], 1) << "the second import";
    const json scenes = json::parse(RunProgram("priors list" + at).out)["scenes"];
    ASSERT_EQ(scenes.size(), 1U);
    EXPECT_EQ(scenes[0]["sources"], 1) << "one player whose record grows";
    const json& arm = scenes[0]["arms"][0];
    EXPECT_GT(arm["windows"], 50 * run);
    EXPECT_LT(arm["windows"], 70 * run);
  }
}

TEST(DaemonProgram, EveryDecisionIsExportedAndReplayed) {
  const TemporaryDirectory data;
  DaemonProcess daemon(data.path());
  // This time scale gives 50 decisions per second. At 500 per second, a slow disk would cause gaps
  // in the log.
  const ProgramRun game = Learn(daemon, /*time_scale=*/100);
  ASSERT_EQ(game.exit_code, 0) << game.err;
  const ProgramRun listed = RunProgram("audit list --json --daemon " + daemon.address());
  ASSERT_EQ(listed.exit_code, 0) << listed.err;
  const json segments = json::parse(listed.out)["segments"];
  // An earlier game that learnt nothing may have its own segment.
  ASSERT_FALSE(segments.empty());
  const json& last = segments.back();
  EXPECT_EQ(last["session_id"], json::parse(game.out)["session_id"]);
  EXPECT_EQ(last["project"], "p");
  EXPECT_THAT(RunProgram("audit list --scene s --daemon " + daemon.address()).out,
              HasSubstr(last["session_id"].get<std::string>()));
  uint64_t row_count = 0;
  for (const json& segment : segments) row_count += segment["rows"].get<uint64_t>();

  const std::string file = (data.path() / "decisions.csv").string();
  const ProgramRun exported =
      RunProgram("audit export --project p --out " + file + " --daemon " + daemon.address());
  ASSERT_EQ(exported.exit_code, 0) << exported.err;
  EXPECT_EQ(exported.out, file + ": " + std::to_string(row_count) + " rows\n");
  EXPECT_EQ(exported.err, "");
  const ProgramRun nothing =
      RunProgram("audit export --project q --out " + file + "-none --daemon " + daemon.address());
  EXPECT_EQ(nothing.exit_code, 1);
  EXPECT_THAT(nothing.err, HasSubstr("the daemon has no matching decisions"));
  const ProgramRun replayed = RunLab("replay --log " + file);
  EXPECT_EQ(replayed.exit_code, 0);
  EXPECT_THAT(replayed.out, HasSubstr("in " + std::to_string(segments.size()) + " segment"));
  EXPECT_THAT(replayed.out, HasSubstr("re-derived, all equal"));

  std::ofstream(file, std::ios::app) << "one more line\n";
  const ProgramRun edited = RunLab("replay --log " + file);
  EXPECT_EQ(edited.exit_code, 1);
  EXPECT_THAT(edited.out, HasSubstr("is it cut off?"));
  const ProgramRun as_json = RunLab("replay --json --log " + file);
  EXPECT_EQ(as_json.exit_code, 1);
  EXPECT_EQ(json::parse(as_json.out)["equal"], false);
}

}  // namespace
}  // namespace sweepstake::cli
