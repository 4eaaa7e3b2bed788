// A trace made ready to be played as a game in virtual time.
//
// A game is a fixed amount of work: `frame_count` frames, whatever policy plays them. A window of
// kWindowFrameCount consecutive frames of the trace moves through it evenly, once per pass of the
// run; the game shows the window's frames in turn, again and again. So the scene changes as slowly
// as the pass says, while two seconds of the game hold tens of different frames as they do in real
// life. A shorter window, or a frame held for its share of the run, would let a few disturbed
// frames, or the rebuild of a tree, last for seconds of the game.
//
// Recorded times are multiplied by one factor, so that the mean frame of the best fixed arm, the
// other work included, takes GameOptions::frame_ns: only ratios between arms are judged, and at 10
// ms the paper's absolute scales mean something.
//
// Immutable once made; safe to share between threads. Borrows nothing of the trace. Times in
// nanoseconds of virtual time. Memory: some 25 bytes per frame and arm.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/trace/cost_trace.h"
#include "server/decision/session/decision_session.h"
#include "sweepstake/status.h"

namespace sweepstake::cli {

struct GameOptions {
  uint64_t frame_ns = 10'000'000;     // mean frame of the best fixed arm
  uint64_t run_ns = 900'000'000'000;  // the game lasts this long on it: the paper's window
  uint64_t pass_ns = 0;               // one pass through the trace lasts this long; 0: the run
  uint64_t other_work_ns = 0;         // of a frame, beside detection; < frame_ns
};

class ReplayScene {
 public:
  static constexpr uint32_t kWindowFrameCount = 64;

  // REQUIRES: a valid trace, as ReadCosts gives it. kInvalidArgument: the options make no game, or
  // the trace has more arms than a session.
  static Result<ReplayScene> Create(const CostTrace& trace, const GameOptions& options);

  const GameOptions& options() const { return options_; }
  const std::vector<std::string>& arms() const { return arms_; }
  uint32_t arm_count() const { return static_cast<uint32_t>(arms_.size()); }
  uint32_t frame_count() const { return frame_count_; }  // of the game
  uint32_t trace_frame_count() const { return trace_frame_count_; }

  // Of a frame of the trace.
  double detection_ns(uint32_t trace_frame, uint32_t arm) const {
    return detection_ns_[size_t{trace_frame} * arms_.size() + arm];
  }
  uint64_t aabb_check_count(uint32_t trace_frame, uint32_t arm) const {
    return aabb_check_count_[size_t{trace_frame} * arms_.size() + arm];
  }
  uint64_t native_bytes(uint32_t trace_frame, uint32_t arm) const {
    return native_bytes_[size_t{trace_frame} * arms_.size() + arm];
  }
  uint32_t object_count(uint32_t trace_frame) const { return object_count_[trace_frame]; }

  // The descriptor that the client has sent last at this frame; null: the trace has none.
  const decision::SceneDescriptor* descriptor(uint32_t trace_frame) const;

  // What the first frames of a freshly built structure of `arm` take, from the frame on that builds
  // it, ÷ what a running one takes: from the burst nearest to this frame.
  std::span<const double> slowdown(uint32_t trace_frame, uint32_t arm) const {
    return std::span(slowdown_[nearest_burst_[trace_frame]])
        .subspan(size_t{arm} * burst_frame_count_, burst_frame_count_);
  }
  uint32_t burst_frame_count() const { return burst_frame_count_; }

  // The same arm measured twice, relative difference of the means: what noise alone makes of a
  // regret.
  double control_regret() const { return control_regret_; }

 private:
  ReplayScene() = default;
  void TakeFrames(const CostTrace& trace, double scale);
  void TakeBursts(const CostTrace& trace);
  void FindNearestBursts(const CostTrace& trace);
  void TakeDescriptors(const CostTrace& trace);

  GameOptions options_;
  std::vector<std::string> arms_;
  uint32_t frame_count_ = 0;
  uint32_t trace_frame_count_ = 0;
  uint32_t burst_frame_count_ = 0;
  double control_regret_ = 0;
  std::vector<double> detection_ns_;
  std::vector<uint64_t> aabb_check_count_;
  std::vector<uint64_t> native_bytes_;
  std::vector<uint32_t> object_count_;
  // Per burst: arm-major, burst_frame_count_ values each.
  std::vector<std::vector<double>> slowdown_;
  std::vector<uint32_t> nearest_burst_;  // per frame
  std::vector<decision::SceneDescriptor> descriptors_;
  std::vector<uint32_t> latest_descriptor_;  // per frame; empty: none
};

// Which frame of the trace each game frame shows, in order from the first. `offset` rotates where
// the trace starts.
class FrameOrder {
 public:
  FrameOrder(const ReplayScene& scene, uint32_t offset);

  uint32_t Next();

 private:
  const uint32_t trace_frame_count_;
  const uint32_t window_;
  const double trace_frames_per_game_frame_;
  double begin_;            // of the window, in the trace
  uint32_t in_window_ = 0;  // of the next frame
};

// The start of a seed's game: evenly spread over the trace by the golden ratio.
uint32_t OffsetOfSeed(const ReplayScene& scene, uint64_t seed);

}  // namespace sweepstake::cli
