// Shows a game on a terminal while it runs: draws its SceneView about 20 times per second. Not
// thread-safe. The stream and the game are borrowed.
//
// Call Draw between frames: frame times and detection times then exclude the drawing. The next
// frame begins after it, with colder caches, as after the rendering of a game.
#pragma once

#include <functional>
#include <ostream>
#include <string>

#include "engine_client/cli/game/game_run.h"
#include "engine_client/cli/io/screen.h"
#include "sweepstake/session.h"

namespace sweepstake::cli {

class LiveView {
 public:
  // Takes the whole screen until the end of its life. `size` is called for each drawing, because
  // the user may resize the terminal.
  LiveView(std::ostream& out, std::function<ScreenSize()> size, bool has_colours,
           const GameRun& run);

  // Returns whether Draw is due.
  bool due() const { return run_.elapsed_ns() >= next_draw_ns_; }
  // `state` describes the session, for the title.
  void Draw(const SessionStats& stats, const std::string& state);
  // Restores the terminal while the process is suspended (Suspend in process.h). Draw is due then.
  void Suspend();
  // Call it after each switch, with what the session knows then.
  void NoteSwitch(const SessionStats& stats);

 private:
  // Measures the rates of the frames since the latest measurement, if these are enough frames to
  // give a steady number.
  void MeasureRates();

  FullScreen screen_;
  const std::function<ScreenSize()> size_;
  const bool has_colours_;
  const GameRun& run_;
  uint64_t next_draw_ns_ = 0;
  std::string switch_sentence_;  // about the latest switch; empty: none yet
  // Time and totals at the latest measurement, and its results.
  uint64_t measured_ns_ = 0;
  uint64_t measured_frame_count_ = 0;
  uint64_t measured_detection_ns_ = 0;
  double frames_per_s_ = 0;
  double detection_ms_ = 0;
};

}  // namespace sweepstake::cli
