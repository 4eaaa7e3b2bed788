#include "engine_client/cli/game/live_view.h"

#include <utility>

#include "engine_client/cli/game/run_summary.h"
#include "engine_client/cli/game/scene_view.h"
#include "engine_client/cli/io/process.h"
#include "engine_client/cli/io/text_table.h"

namespace sweepstake::cli {
namespace {

constexpr uint64_t kDrawIntervalNs = 50'000'000;
constexpr uint64_t kRateIntervalNs = 500'000'000;

std::string NoSwitchSentence(const AdaptiveBroadPhase& adaptive) {
  const std::string& arm = adaptive.arms()[adaptive.active_arm()];
  return adaptive.mode() == Mode::kAi ? "No switch yet: " + arm + " is active since the start"
                                      : "Mode manual: " + arm + " stays active";
}

}  // namespace

LiveView::LiveView(std::ostream& out, std::function<ScreenSize()> size, bool has_colours,
                   const GameRun& run)
    : screen_(out), size_(std::move(size)), has_colours_(has_colours), run_(run) {}

void LiveView::Draw(const SessionStats& stats, const std::string& state) {
  MeasureRates();
  const AdaptiveBroadPhase& adaptive = run_.adaptive();
  const Scene& scene = run_.scene();
  const SceneView view = {
      .title = std::string(scene.name()) + ", " + std::to_string(scene.aabbs().size()) +
               " objects, " + Fixed(static_cast<double>(run_.elapsed_ns()) * 1e-9, 0) + " s, " +
               state + ". Ctrl-C ends",
      .world = scene.world(),
      .boxes = scene.aabbs(),
      .pairs = run_.pairs(),
      .arms = adaptive.arms(),
      .beliefs = stats.beliefs,
      .active_arm = adaptive.last_sample().arm,
      .detection_ms = detection_ms_,
      .frames_per_s = frames_per_s_,
      .message = switch_sentence_.empty() ? NoSwitchSentence(adaptive) : switch_sentence_};
  screen_.Draw(SceneViewText(view, size_(), has_colours_));
  next_draw_ns_ = run_.elapsed_ns() + kDrawIntervalNs;
}

void LiveView::Suspend() {
  screen_.Leave();
  cli::Suspend();
  screen_.Enter();
  next_draw_ns_ = 0;
}

void LiveView::NoteSwitch(const SessionStats& stats) {
  const SwitchEvent& event = run_.switches().back();
  SwitchRow row = ToRow(event, run_.adaptive());
  row.trial_detection_time_ns =
      OutcomeOf(run_.outcomes(), event.switch_epoch).trial_detection_time_ns;
  switch_sentence_ = SwitchSentence(row, StandingOf(stats.beliefs, row.to));
}

void LiveView::MeasureRates() {
  const uint64_t now_ns = run_.elapsed_ns();
  const uint64_t frame_count = run_.frame_count() - measured_frame_count_;
  if (frame_count == 0 || (measured_ns_ > 0 && now_ns - measured_ns_ < kRateIntervalNs)) return;
  uint64_t detection_ns = 0;
  for (const ArmActivity& activity : run_.activities()) detection_ns += activity.detection_ns;
  const auto frames = static_cast<double>(frame_count);
  frames_per_s_ = 1e9 * frames / static_cast<double>(now_ns - measured_ns_);
  detection_ms_ = 1e-6 * static_cast<double>(detection_ns - measured_detection_ns_) / frames;
  measured_ns_ = now_ns;
  measured_frame_count_ = run_.frame_count();
  measured_detection_ns_ = detection_ns;
}

}  // namespace sweepstake::cli
