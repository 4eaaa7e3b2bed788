// The screen of `sweepstake watch`: every scene's latest posteriors and the latest decisions.
// Not thread-safe. The stream is borrowed.
#pragma once

#include <chrono>
#include <deque>
#include <map>
#include <ostream>
#include <string>
#include <tuple>

#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

class WatchScreen {
 public:
  // With `redraws` (for a terminal) the screen is redrawn at most five times per second. Without
  // it, each event is printed when it arrives, and a decision includes its session. Each scene's
  // posteriors are followed by what the session of the latest decision has learnt.
  WatchScreen(std::ostream& out, bool redraws) : out_(out), redraws_(redraws) {}

  void Show(const v1::WatchPosteriorsResponse& event);

 private:
  void ShowPosterior(const v1::ScenePosterior& scene);
  void ShowDecision(const std::string& line);
  // Returns the scene's posteriors, and what its latest session has learnt.
  std::string SceneText(const v1::ScenePosterior& scene) const;
  void Draw();

  std::ostream& out_;
  const bool redraws_;
  // The fields are project, scene, machine class and reward version.
  using SceneKey = std::tuple<std::string, std::string, std::string, uint32_t>;
  std::map<SceneKey, v1::ScenePosterior> scenes_;
  std::map<SceneKey, v1::DecisionEvent> latest_;  // latest decision of each scene
  std::deque<std::string> decisions_;
  std::chrono::steady_clock::time_point drawn_at_;
};

}  // namespace sweepstake::cli
