#include "engine_client/cli/game/live_view.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <optional>
#include <sstream>
#include <string>
#include <utility>

#include "engine_client/cli/game/scene_choice.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

using testing::EndsWith;
using testing::HasSubstr;

class NoSink final : public FrameSink {
  void OnFrame(const FrameSample&) noexcept override {}
  void OnDescriptor(const SceneDescriptor&) noexcept override {}
  void OnSwitch(const SwitchOutcome&) noexcept override {}
};

class LiveViewTest : public testing::Test {
 protected:
  void Start(Mode mode) {
    scene_ = std::move(*OpenScene({"suite-g", 200, 3}));
    AdaptiveOptions options;
    options.mode = mode;
    options.initial_arm = "SAP";
    options.shadow.enabled = ShadowMode::kOff;
    run_ = std::move(*GameRun::Create(options, *scene_, sink_));
    view_.emplace(
        out_, [this] { return size_; }, /*has_colours=*/false, *run_);
  }

  std::string Draw() {
    out_.str("");
    view_->Draw(stats_, "embedded");
    return out_.str();
  }

  NoSink sink_;
  std::unique_ptr<Scene> scene_;
  std::unique_ptr<GameRun> run_;
  SessionStats stats_;
  ScreenSize size_;
  std::ostringstream out_;
  std::optional<LiveView> view_;
};

TEST_F(LiveViewTest, ShowsTheGameAndTheSession) {
  Start(Mode::kAi);
  EXPECT_TRUE(view_->due());
  run_->Frame();
  stats_.beliefs = {{.arm = "DBVT"}};
  stats_.beliefs[0].standing = ArmStanding{.best_probability = 0.625, .cost_ratio = {}};
  const std::string text = Draw();
  EXPECT_THAT(text, HasSubstr("suite-g, 200 objects, "));
  EXPECT_THAT(text, HasSubstr("s, embedded. Ctrl-C ends"));
  EXPECT_THAT(text, HasSubstr("\nSAP  "));
  EXPECT_THAT(
      text, HasSubstr(" " + std::to_string(run_->adaptive().last_sample().pair_count) + " pairs"));
  EXPECT_GT(run_->pairs().size(), 0U);
  EXPECT_THAT(text, HasSubstr("0.62"));
  EXPECT_THAT(text, EndsWith("No switch yet: SAP is active since the start\x1b[K\x1b[J"));
}

TEST_F(LiveViewTest, MeasuresTheRatesFromTheFramesThatWereRun) {
  Start(Mode::kManual);
  run_->Frame();
  const std::string detection_ms =
      Fixed(1e-6 * static_cast<double>(run_->adaptive().last_sample().detection_time_ns), 3);
  EXPECT_THAT(Draw(), HasSubstr("SAP  " + detection_ms + " ms detection"));
}

TEST_F(LiveViewTest, NamesTheLatestSwitchAndItsReason) {
  Start(Mode::kManual);
  run_->Frame();
  EXPECT_THAT(Draw(), HasSubstr("Mode manual: SAP stays active"));
  ASSERT_TRUE(run_->adaptive().SelectArm("Grid").ok());
  ASSERT_TRUE(run_->Frame());
  view_->NoteSwitch(stats_);
  const std::string text = Draw();
  EXPECT_THAT(text, HasSubstr(" s: SAP → Grid, because it was chosen manually"));
  EXPECT_THAT(text, HasSubstr("\nGrid  "));
}

TEST_F(LiveViewTest, FollowsTheSizeOfTheTerminal) {
  Start(Mode::kManual);
  run_->Frame();
  const auto lines = [&] {
    const std::string text = Draw();
    return 1 + std::count(text.begin(), text.end(), '\n');
  };
  EXPECT_EQ(lines(), 24);
  size_ = {.columns = 40, .rows = 7};
  EXPECT_EQ(lines(), 7);
}

}  // namespace
}  // namespace sweepstake::cli
