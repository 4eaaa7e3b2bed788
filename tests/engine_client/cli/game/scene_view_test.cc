#include "engine_client/cli/game/scene_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <limits>
#include <sstream>

#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

using testing::HasSubstr;
using testing::Not;

constexpr float kInfinity = std::numeric_limits<float>::infinity();
constexpr float kNan = std::numeric_limits<float>::quiet_NaN();
constexpr Aabb kWorld = {{-10, -10, -10}, {10, 10, 10}};
constexpr ScreenSize kSmall = {.columns = 21, .rows = 13};
const std::vector<std::string> kArms = {"SAP", "Grid"};

// Two boxes that touch, and one alone above them.
const std::vector<Aabb> kBoxes = {
    {{-6, -6, -6}, {0, 0, 0}}, {{0, -6, -6}, {6, 0, 0}}, {{-2, 4, -2}, {2, 8, 2}}};
const std::vector<OverlapPair> kPairs = {{0, 1}};

SceneView ViewOf(std::span<const Aabb> boxes, std::span<const OverlapPair> pairs = {}) {
  return {.title = "suite-b",
          .world = kWorld,
          .boxes = boxes,
          .pairs = pairs,
          .arms = kArms,
          .beliefs = {},
          .active_arm = 1,
          .detection_ms = 0.0625,
          .frames_per_s = 60,
          .message = "No switch yet"};
}

std::string Text(const SceneView& view, ScreenSize size = kSmall, bool has_colours = false) {
  return SceneViewText(view, size, has_colours);
}

TEST(SceneView, DrawsTheEdgesOfTheWorldAndOfAFewBoxes) {
  EXPECT_EQ('\n' + Text(ViewOf(kBoxes, kPairs)), R"(
suite-b
Grid  0.062 ms detec
       ⣀⠤⠒⡗⠤⣀
   ⢀⡠⠔⠊   ⡇  ⠑⠢⢄⡀
 ⢠⠒⠁    ⢀⡠⣇⡀    ⠈⠒⡄
 ⢸      ⣏⡲⣗⣹      ⡇
 ⢸     ⡞⠭⣒⣗⠭⢳⠤⣀   ⡇
 ⢸     ⣧⡔⠊⡟⢲⣼⠒⠉⡇  ⡇
 ⢸ ⢀⠤⠒⠉ ⠈⠑⠯⣁⢸⣉⠶⠧⡀ ⡇
 ⠘⠮⡁        ⠉   ⢈⠵⠃
   ⠈⠑⠢⢄      ⡠⠔⠊⠁
       ⠉⠒⠤⡤⠒⠉
No switch yet)");
}

TEST(SceneView, AnEmptySceneShowsTheWorldAlone) {
  EXPECT_EQ('\n' + Text(ViewOf({})), R"(
suite-b
Grid  0.062 ms detec
       ⣀⠤⠒⡗⠤⣀
   ⢀⡠⠔⠊   ⡇  ⠑⠢⢄⡀
 ⢠⠒⠁      ⡇     ⠈⠒⡄
 ⢸        ⡇       ⡇
 ⢸        ⡇       ⡇
 ⢸     ⡠⠔⠊⠑⠢⢄     ⡇
 ⢸ ⢀⠤⠒⠉      ⠉⠒⠤⡀ ⡇
 ⠘⠮⡁            ⢈⠵⠃
   ⠈⠑⠢⢄      ⡠⠔⠊⠁
       ⠉⠒⠤⡤⠒⠉
No switch yet)");
}

TEST(SceneView, BoxesThatTouchHaveTheColourOfTheActiveArm) {
  EXPECT_EQ(Text(ViewOf(kBoxes, kPairs), {.columns = 13, .rows = 6}, true),
            "suite-b\n"
            "\x1b[38;5;39mGrid  0.062\n"
            "   \x1b[38;5;240m⢀⠤\x1b[38;5;244m⢒⡗\x1b[38;5;240m⠤⡀\n"
            "   ⢸⢀\x1b[38;5;39m⣾⣷⡆\x1b[38;5;240m⡇\n"
            "   ⠈⠓⠤\x1b[38;5;39m⡭⠛\x1b[38;5;240m⠁\n"
            "\x1b[39mNo switch ye");
}

TEST(SceneView, DrawsPointsIfTheEdgesOfManyBoxesWouldFillTheSpace) {
  std::vector<Aabb> boxes;
  for (int i = 0; i < 200; ++i) boxes.push_back({{-4, -4, -4}, {4, 4, 4}});
  EXPECT_EQ(Text(ViewOf(boxes)), Text(ViewOf(std::vector<Aabb>{{{0, 0, 0}, {0, 0, 0}}})));
}

TEST(SceneView, LeavesOutInvalidBoxesAndDrawsTheCentreOfHugeOnes) {
  std::vector<Aabb> boxes = kBoxes;
  boxes.push_back({{kNan, 0, 0}, {1, 1, 1}});
  boxes.push_back({{0, 0, 0}, {1, 1, kInfinity}});
  boxes.push_back({{9, 1, 1}, {7, -1, -1}});
  EXPECT_EQ(Text(ViewOf(boxes, kPairs)), Text(ViewOf(kBoxes, kPairs)));
  const Aabb huge = {{-3e38F, -3e38F, -3e38F}, {3e38F, 3e38F, 3e38F}};
  EXPECT_EQ(Text(ViewOf(std::vector<Aabb>{huge})),
            Text(ViewOf(std::vector<Aabb>{{{0, 0, 0}, {0, 0, 0}}})));
}

TEST(SceneView, DrawsNothingInAWorldThatIsNotFiniteAndAPointForOneWithoutSize) {
  SceneView view = ViewOf(kBoxes);
  view.world.max[1] = kInfinity;
  EXPECT_EQ(Text(view), "suite-b\nGrid  0.062 ms detec" + std::string(11, '\n') + "No switch yet");
  view.world = {{5, 5, 5}, {5, 5, 5}};
  EXPECT_EQ(Text(view), "suite-b\nGrid  0.062 ms detec" + std::string(6, '\n') +
                            std::string(10, ' ') + "⠁" + std::string(5, '\n') + "No switch yet");
}

TEST(SceneView, FitsIntoEverySize) {
  for (size_t columns = 0; columns < 90; ++columns) {
    for (const size_t rows : {0, 1, 2, 3, 4, 12, 24}) {
      const std::string text = Text(ViewOf(kBoxes, kPairs), {.columns = columns, .rows = rows});
      EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), rows == 0 ? 0 : rows - 1);
      std::istringstream lines(text);
      for (std::string line; std::getline(lines, line);)
        EXPECT_LT(LetterCount(line), std::max<size_t>(columns, 1));
    }
  }
}

TEST(SceneView, AWideScreenHasATableOfTheArms) {
  std::vector<ArmBelief> beliefs = {{.arm = "Grid"}, {.arm = "SAP"}};
  beliefs[0].standing = ArmStanding{.best_probability = 0.75, .cost_ratio = CostRatio{}};
  beliefs[1].standing = ArmStanding{.best_probability = kNan, .cost_ratio = CostRatio{12.5, 9, 20}};
  SceneView view = ViewOf({});
  view.beliefs = beliefs;
  view.world.max[0] = kInfinity;  // leaves only the table
  EXPECT_EQ('\n' + Text(view, {.columns = 62, .rows = 10}), R"(
suite-b
Grid  0.062 ms detection  0 pairs  60 frames/s

                            arm        P(best)           cost
                            SAP                  nan    ×12.5
                          ▶ Grid       ██████▊   0.75   ×1.00

                          cost: ratio to the leader's cost
                          coloured boxes touch another box
No switch yet)");
  EXPECT_THAT(Text(view, {.columns = 61, .rows = 10}), Not(HasSubstr("P(best)")));
}

TEST(SceneView, TheTableLeavesOutWhatIsNotKnown) {
  std::vector<ArmBelief> beliefs = {{.arm = "SAP"}};
  SceneView view = ViewOf(kBoxes, kPairs);
  view.beliefs = beliefs;
  const std::string text = Text(view, {.columns = 80, .rows = 24});
  EXPECT_THAT(text, HasSubstr("Grid  0.062 ms detection  1 pair  60 frames/s\n"));
  EXPECT_THAT(text, HasSubstr("▶ Grid\n"));
  EXPECT_THAT(text, HasSubstr("  SAP\n"));
}

TEST(SwitchSentence, NamesTheReason) {
  SwitchRow row = {.time_s = 12.34, .from = "SAP", .to = "Grid", .reason = SwitchReason::kPolicy};
  const ArmStanding standing = {.best_probability = 0.93, .cost_ratio = {}};
  EXPECT_EQ(SwitchSentence(row, &standing),
            "12.3 s: SAP → Grid, because Grid is the best with probability 0.93");
  const auto reason = [&](SwitchReason each) {
    row.reason = each;
    return SwitchSentence(row, nullptr).substr(std::string("12.3 s: SAP → Grid, because ").size());
  };
  EXPECT_EQ(reason(SwitchReason::kPolicy), "the policy expects lower costs");
  EXPECT_EQ(reason(SwitchReason::kExploration), "the policy measures Grid");
  EXPECT_EQ(reason(SwitchReason::kBailOut), "a frame with SAP exceeded the bail-out limit");
  EXPECT_EQ(reason(SwitchReason::kManual), "it was chosen manually");
  row.trial_detection_time_ns = 1;
  EXPECT_EQ(reason(SwitchReason::kPolicy), "the trial of SAP was too expensive");
}

}  // namespace
}  // namespace sweepstake::cli
