// The screen of `sweepstake watch`: every scene's latest posteriors and the latest decisions.
// Thread-safe. The stream is borrowed.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <mutex>
#include <ostream>
#include <string>
#include <tuple>

#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

class WatchScreen {
 public:
  using TimePoint = std::chrono::steady_clock::time_point;

  // If `redraws` is true (for a terminal), redraws the screen at most once per 150 ms. If it is
  // false, prints each event as it arrives; decisions then include their session's id. Below each
  // scene's posteriors is what the session of the scene's latest decision has learnt.
  WatchScreen(std::ostream& out, bool redraws) : out_(out), redraws_(redraws) {}

  void Show(const v1::WatchPosteriorsResponse& event,
            TimePoint now = std::chrono::steady_clock::now());
  // Draws a change that came too soon after the last drawing. Call it every 50 ms.
  void Redraw(TimePoint now = std::chrono::steady_clock::now());
  // Forgets the scenes, because a new watch begins, which receives all of them again.
  void Restart();
  // Lets the next Redraw draw, although nothing has changed: the new watch may have no scenes.
  void DrawAgain();

 private:
  // Shows a scene, or removes it if it has no arms, because its evidence was revoked.
  void ShowPosterior(const v1::ScenePosterior& scene);
  void ShowDecision(const std::string& line);
  // Returns the text of the scene's posteriors, and of what the session of its latest decision has
  // learnt.
  std::string SceneText(const v1::ScenePosterior& scene) const;
  void DrawIfDue(TimePoint now);
  void Draw();

  std::mutex mutex_;  // guards the members below
  std::ostream& out_;
  const bool redraws_;
  // Project, scene, machine class and reward version.
  using SceneName = std::tuple<std::string, std::string, std::string, uint32_t>;
  std::map<SceneName, v1::ScenePosterior> scenes_;
  std::map<SceneName, v1::DecisionEvent> latest_;  // latest decision of each scene
  std::deque<std::string> decisions_;
  TimePoint drawn_at_;
  bool is_changed_ = false;  // there is a change that is not drawn yet
};

}  // namespace sweepstake::cli
