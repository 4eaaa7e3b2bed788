// Prepares a trace to be played as a game in virtual time.
//
// A game is a fixed amount of work: `frame_count` frames for every policy. A pass moves a window of
// kWindowFrameCount consecutive frames evenly through the trace, and the game shows the frames of
// the window repeatedly. The scene thus changes at the speed of the pass, while two seconds of the
// game contain tens of different frames, as in a real game. With a shorter window, or if each frame
// were repeated for its share of the run, a few disturbed frames or the rebuild of a tree would
// last for seconds of the game.
//
// Recorded times are multiplied by one factor, so that the mean frame of the best fixed arm takes
// GameOptions::frame_ns, other work included. Only ratios between arms are judged. Frames of 10 ms
// suit the parameters of the paper's policy, which are absolute times.
//
// Immutable, so it is safe to share between threads. It keeps no reference to the trace. Times are
// nanoseconds of virtual time. Memory: some 25 bytes per frame and arm.
#pragma once

#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "engine_client/decider/session/decision_session.h"
#include "sweepstake/status.h"
#include "tests/laboratory/trace/cost_trace.h"

namespace sweepstake::cli {

struct GameOptions {
  uint64_t frame_ns = 10'000'000;     // mean frame time of the best fixed arm
  uint64_t run_ns = 900'000'000'000;  // length of a game on that arm; default: the paper's window
  uint64_t pass_ns = 0;               // length of one pass through the trace; 0 means run_ns
  uint64_t other_work_ns = 0;         // time of a frame besides detection; < frame_ns
};

class ReplayScene {
 public:
  static constexpr uint32_t kWindowFrameCount = 64;

  // Error: kInvalidArgument (the options are not valid, or the trace has more arms than a session
  // can have). REQUIRES: a valid trace, as ReadCosts returns it.
  static Result<ReplayScene> Create(const CostTrace& trace, const GameOptions& options);

  // Returns the same game on a machine on which each arm's times are multiplied by the arm's ratio.
  ReplayScene WithArmRatios(std::span<const double> ratios) const;

  const GameOptions& options() const { return options_; }
  const std::vector<std::string>& arms() const { return arms_; }
  uint32_t arm_count() const { return static_cast<uint32_t>(arms_.size()); }
  uint32_t frame_count() const { return frame_count_; }  // frames of the game
  uint32_t trace_frame_count() const { return trace_frame_count_; }

  // detection_ns, aabb_check_count, native_bytes and object_count return the measured values of a
  // frame of the trace.
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
  double mean_object_count() const;  // over the trace

  // Returns the latest descriptor up to this frame, or the first one if all are later. Returns null
  // if the trace has none.
  const SceneDescriptor* descriptor(uint32_t trace_frame) const;

  // Returns a factor for each of the first frames of a fresh structure of `arm`, beginning with the
  // frame that builds it. A factor is the frame's time ÷ the time of a running structure, measured
  // in the burst nearest to this frame.
  std::span<const double> slowdown(uint32_t trace_frame, uint32_t arm) const {
    return std::span(slowdown_[nearest_burst_[trace_frame]])
        .subspan(size_t{arm} * burst_frame_count_, burst_frame_count_);
  }
  uint32_t burst_frame_count() const { return burst_frame_count_; }

  // Game time ÷ recorded time, the same for all frames.
  double time_ratio() const { return time_ratio_; }

  // The relative difference between two measurements of one arm: the regret that noise alone
  // causes.
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
  double time_ratio_ = 1;
  double control_regret_ = 0;
  std::vector<double> detection_ns_;
  std::vector<uint64_t> aabb_check_count_;
  std::vector<uint64_t> native_bytes_;
  std::vector<uint32_t> object_count_;
  // One list per burst: burst_frame_count_ values for the first arm, then for the next.
  std::vector<std::vector<double>> slowdown_;
  std::vector<uint32_t> nearest_burst_;  // index, per frame
  std::vector<SceneDescriptor> descriptors_;
  std::vector<uint32_t> latest_descriptor_;  // index, per frame; empty if there are none
};

// Determines which frame of the trace each game frame shows, in order from the first. `offset`
// rotates the start of the trace.
class FrameOrder {
 public:
  FrameOrder(const ReplayScene& scene, uint32_t offset);

  uint32_t Next();

 private:
  const uint32_t trace_frame_count_;
  const uint32_t window_;
  const double trace_frames_per_game_frame_;
  double begin_;            // the window's start in the trace
  uint32_t in_window_ = 0;  // the next frame's index in the window
};

// Returns the start of a seed's game in the trace. The golden ratio spreads the starts evenly.
uint32_t OffsetOfSeed(const ReplayScene& scene, uint64_t seed);

// Computes the total time of each fixed arm and of two oracles on the frames of one seed's game. An
// oracle has all costs in advance. Exploration and the build of the first structure are free.
// Borrows the scene.
class FixedCosts {
 public:
  FixedCosts(const ReplayScene& scene, uint64_t seed);

  // Returns the total time of the frames from `first_frame` on, per arm.
  std::vector<double> TotalsFrom(uint32_t first_frame) const;

  struct OracleCost {
    // Total time with the best arm in each frame, if switches cost nothing.
    double frame_ns = 0;
    double regime_ns = 0;       // time of the cheapest sequence of arms, including its switches
    uint32_t switch_count = 0;  // number of switches in that sequence
    uint32_t dominant_arm = 0;  // the arm with the largest share of that sequence
    double active_share = 1;    // share of dominant_arm in the time of that sequence
  };
  // Finds the best arm of each frame and the cheapest sequence of arms, in O(frames × arms). The
  // sequence may switch once per `interval_ns` of the best arm's frames. If `warm`, a switch costs
  // as much as after a preparation by the shadow lane, else as a cold switch.
  OracleCost Oracle(int64_t interval_ns, bool warm) const;

 private:
  static constexpr uint32_t kBlock = 1024;

  double FrameNs(uint32_t game_frame, uint32_t arm) const;
  double SwitchNs(uint32_t game_frame, uint32_t arm, bool warm) const;

  const ReplayScene& scene_;
  std::vector<uint32_t> order_;     // the trace frame of each game frame
  std::vector<double> from_block_;  // per block, then arm: total time from the block on
};

}  // namespace sweepstake::cli
