#include "engine_client/cli/daemon/watch_screen.h"

#include <utility>

#include "engine_client/cli/daemon/posterior_view.h"
#include "engine_client/cli/io/duration.h"
#include "engine_client/text/names.h"

namespace sweepstake::cli {
namespace {

constexpr size_t kMaxDecisions = 10;
// Redraw is called every 50 ms, so a change is drawn at most 200 ms late.
constexpr std::chrono::milliseconds kRedrawInterval{150};
constexpr char kHomeAndClear[] = "\x1b[H\x1b[2J";
constexpr char kLegend[] =
    "|: mean, -: central 95 % of the posterior, cost: ratio to the leader's,\n"
    "best: probability of being the best arm, equiv: equivalent number of live windows.\n"
    "Ctrl-C ends.\n";

}  // namespace

void WatchScreen::Show(const v1::WatchPosteriorsResponse& event, TimePoint now) {
  const std::lock_guard lock(mutex_);
  if (event.has_posterior()) ShowPosterior(event.posterior());
  for (const v1::DecisionEvent& decision : event.decisions()) {
    // On a terminal the session's id is left out to save space.
    const std::string session = redraws_ ? "" : decision.session_id() + " of ";
    latest_[{decision.project(), decision.scene(), decision.machine_class(),
             decision.reward_version()}] = decision;
    ShowDecision(UtcText(decision.unix_ms()) + " " + session + DecisionText(decision));
  }
  if (!redraws_) out_ << std::flush;
  is_changed_ = redraws_;
  DrawIfDue(now);
}

void WatchScreen::Redraw(TimePoint now) {
  const std::lock_guard lock(mutex_);
  DrawIfDue(now);
}

void WatchScreen::DrawIfDue(TimePoint now) {
  if (!is_changed_ || now - drawn_at_ < kRedrawInterval) return;
  drawn_at_ = now;
  is_changed_ = false;
  Draw();
}

void WatchScreen::Restart() {
  const std::lock_guard lock(mutex_);
  if (std::exchange(is_changed_, false)) Draw();
  scenes_.clear();
}

void WatchScreen::DrawAgain() {
  const std::lock_guard lock(mutex_);
  is_changed_ = redraws_;
}

void WatchScreen::ShowPosterior(const v1::ScenePosterior& scene) {
  if (!redraws_) {
    out_ << text::PrintableLines(SceneText(scene));
    return;
  }
  const SceneName name = {scene.project(), scene.scene(), scene.machine_class(),
                          scene.reward_version()};
  if (scene.arms().empty()) {
    scenes_.erase(name);
  } else {
    scenes_[name] = scene;
  }
}

std::string WatchScreen::SceneText(const v1::ScenePosterior& scene) const {
  const auto latest =
      latest_.find({scene.project(), scene.scene(), scene.machine_class(), scene.reward_version()});
  return PosteriorText(scene) + (latest == latest_.end() ? "" : StandingsText(latest->second));
}

void WatchScreen::ShowDecision(const std::string& line) {
  if (!redraws_) {
    out_ << text::PrintableLines(line) << '\n';
    return;
  }
  decisions_.push_back(line);
  if (decisions_.size() > kMaxDecisions) decisions_.pop_front();
}

void WatchScreen::Draw() {
  out_ << kHomeAndClear << kLegend << '\n';
  for (const auto& [key, scene] : scenes_) out_ << text::PrintableLines(SceneText(scene)) << '\n';
  for (const std::string& decision : decisions_) out_ << text::PrintableLines(decision) << '\n';
  out_ << std::flush;
}

}  // namespace sweepstake::cli
