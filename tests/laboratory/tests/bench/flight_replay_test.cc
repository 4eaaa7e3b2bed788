// Tests `sweepstake-lab replay --recording`, which prints the notes of a flight recorder's file and
// times every arm on its boxes.
#include "tests/laboratory/bench/flight_replay.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <nlohmann/json.hpp>
#include <set>

#include "engine_client/cli/io/terminal.h"
#include "sweepstake/broad_phase.h"
#include "sweepstake/scene.h"
#include "tests/laboratory/tests/lab_command.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::cli {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

// Five frames, of which three have boxes. The longest frame has none; the frame after it has boxes.
json PlainNotes() {
  return {{"flight_recording", 1},
          {"project", "asteroids"},
          {"scene", "level-3"},
          {"build", "1.2"},
          {"machine_class", "a-pc"},
          {"recorded_unix_ms", 1'763'900'000'000},
          {"frame_budget_ms", 50.0},
          {"worst_frame", 13},
          {"arms", {"SAP", "KDTree"}},
          {"frames",
           {{10, 10'000'000, 1'000'000, 60, 7, 0, 0, 0, 4, 0, 0},
            {11, 10'000'000, 3'000'000, 60, 7, 0, 0, 0, 4, 0, nullptr},
            {12, 10'000'000, 5'000'000, 60, 7, 0, 0, 1, 5, 1, 1},
            {13, 70'000'000, 6'000'000, 60, 7, 0, 0, 1, 5, 0, nullptr},
            {14, 10'000'000, 7'000'000, 60, 8, 0, 0, 1, 5, 0, 2}}},
          {"decisions",
           {{{"frame", 11},
             {"decision", 3},
             {"outcome", "switched"},
             {"active_arm", 0},
             {"candidate_arm", 1},
             {"commanded_arm", 1},
             {"reason", "policy"},
             {"verdict", "stable"},
             {"best_probability", {0.125, 0.875}}},
            {{"frame", 13},
             {"decision", 4},
             {"outcome", "kept"},
             {"active_arm", 1},
             {"candidate_arm", nullptr},
             {"commanded_arm", nullptr},
             {"verdict", "stable"},
             {"best_probability", json::array()}}}}};
}

class FlightReplayTest : public testing::Test {
 protected:
  // Returns a file with these notes and three frames of 60 boxes.
  std::string FileWith(const std::string& notes) const {
    const std::string path = (directory_.path() / "flight-x.aabbs").string();
    const auto scene = std::move(*MakeScene("suite-b", {.object_count = 60}));
    EXPECT_TRUE(RecordScene(*scene, 2, path, notes).ok());
    return path;
  }

  std::string ErrorOf(const json& notes) const {
    const CommandRun run = RunLabCommand("replay --recording " + FileWith(notes.dump()));
    EXPECT_EQ(run.exit_code, kBadUsage) << run.out;
    return run.err;
  }

  test_support::TemporaryDirectory directory_;
};

TEST_F(FlightReplayTest, TellsWhatHappenedAndTimesEveryArm) {
  const CommandRun run =
      RunLabCommand("replay --json --recording " + FileWith(PlainNotes().dump()));
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  const json document = json::parse(run.out);
  EXPECT_EQ(document["scene"], "level-3");
  EXPECT_EQ(document["frames"], 5);
  EXPECT_EQ(document["box_frames"], 3);
  EXPECT_EQ(document["worst_frame"], (json{{"frame", 13},
                                           {"frame_ms", 70.0},
                                           {"detection_ms", 6.0},
                                           {"objects", 60},
                                           {"pairs", 7},
                                           {"arm", "KDTree"}}));
  std::set<std::string> arms;
  for (const json& arm : document["arms"]) {
    arms.insert(arm["arm"]);
    EXPECT_GT(arm["ms_mean"], 0.0);
    EXPECT_GE(arm["ms_max"], arm["ms_worst_frame"]);
    if (arm["arm"] == "SAP") {
      EXPECT_EQ(arm["live_frames"], 2);
      EXPECT_EQ(arm["live_ms_mean"], 2.0);
    } else if (arm["arm"] == "KDTree") {
      EXPECT_EQ(arm["live_frames"], 3);
      EXPECT_EQ(arm["live_ms_mean"], 6.0);
    } else {
      EXPECT_EQ(arm["live_ms_mean"], nullptr);
    }
  }
  EXPECT_EQ(arms, std::set<std::string>(BroadPhaseNames().begin(), BroadPhaseNames().end()));
  ASSERT_EQ(document["decisions"].size(), 2U);
  EXPECT_EQ(document["decisions"][0]["commanded"], "KDTree");
  EXPECT_EQ(document["decisions"][1]["candidate"], nullptr);
}

TEST_F(FlightReplayTest, SaysItInWords) {
  const CommandRun run = RunLabCommand("replay --recording " + FileWith(PlainNotes().dump()));
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(
      run.out,
      AllOf(HasSubstr("level-3 of asteroids, build 1.2, on a-pc\n"),
            HasSubstr("Frame 13 took 70.0 ms (budget 50.0 ms): detection 6.000 ms with KDTree, 60 "
                      "objects, 7 pairs\n5 frames, 3 of them with boxes\n"),
            HasSubstr("\nSwitches\nframe 12: SAP → KDTree\n"),
            HasSubstr("frame 11: switched, candidate KDTree, commanded KDTree (policy), KDTree is "
                      "the best with probability 0.88\n"),
            HasSubstr("frame 13: kept\n")));
}

TEST_F(FlightReplayTest, AFileOfOneFrameIsReplayedToo) {
  json notes = PlainNotes();
  notes["frames"] = {{13, 70'000'000, 6'000'000, 60, 7, 0, 0, 1, 5, 0, 0}};
  notes["decisions"] = json::array();
  const CommandRun run = RunLabCommand("replay --recording " + FileWith(notes.dump()));
  ASSERT_EQ(run.exit_code, kDone) << run.err;
  EXPECT_THAT(run.out, HasSubstr("Switches\nnone\n\nDecisions\nnone\n"));
}

TEST_F(FlightReplayTest, ARecordingOfSomethingElseIsRefused) {
  const CommandRun run = RunLabCommand("replay --recording " + FileWith(""));
  EXPECT_EQ(run.exit_code, kBadUsage);
  EXPECT_THAT(run.err, HasSubstr("was not written by a flight recorder"));
  json newer = PlainNotes();
  newer["flight_recording"] = 2;
  EXPECT_THAT(ErrorOf(newer), HasSubstr("or the recorder is newer"));
  EXPECT_THAT(RunLabCommand("replay --recording /none.aabbs").err, HasSubstr("no such file"));
}

TEST_F(FlightReplayTest, BrokenNotesAreRefused) {
  for (const char* key : {"scene", "arms", "frames", "worst_frame", "decisions"}) {
    json notes = PlainNotes();
    notes.erase(key);
    EXPECT_THAT(ErrorOf(notes),
                AllOf(HasSubstr("has invalid data of the flight recorder"), HasSubstr(key)));
  }
  json unknown_arm = PlainNotes();
  unknown_arm["frames"][0][7] = 2;
  EXPECT_THAT(ErrorOf(unknown_arm), HasSubstr("has invalid data of the flight recorder"));
  json missing_boxes = PlainNotes();
  missing_boxes["frames"][2][10] = 2;
  EXPECT_THAT(ErrorOf(missing_boxes), HasSubstr("has invalid data of the flight recorder"));
  json short_row = PlainNotes();
  short_row["frames"][0] = json::array({1, 2});
  EXPECT_THAT(ErrorOf(short_row), HasSubstr("has invalid data of the flight recorder"));
}

TEST_F(FlightReplayTest, NeedsExactlyOneThingToReplay) {
  EXPECT_THAT(RunLabCommand("replay --recording a.aabbs --log b.csv").err,
              HasSubstr("--recording FILE.aabbs"));
}

}  // namespace
}  // namespace sweepstake::cli
