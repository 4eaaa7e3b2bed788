// Simulates the shadow lane of a replayed game in virtual time: one worker that visits the arms in
// the order of the real lane's schedule (shadow_schedule.h) and warms up the next arm.
//
// A visit uses the trace's times of a running structure in the frames of the sweep. They are
// multiplied by the slowdown of a freshly built structure, which the trace has measured in the
// nearest burst (cost_trace.h). Each frame between two bursts thus still has a time
// of its own. LaneErrors adds the measurement errors of a real machine. Deterministic; not
// thread-safe. Borrows the scene. Times are nanoseconds of virtual time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine_client/adaptive/shadow_schedule.h"
#include "engine_client/decider/types.h"
#include "tests/laboratory/replay/replay_scene.h"

namespace sweepstake::cli {

// The errors of a visit's times relative to the frame thread, and the slowdown of frames during
// visits. By default there are none.
struct LaneErrors {
  // The standard deviation of ln(lane ÷ frame thread) between arms. Each game draws its own value
  // for each arm.
  double bias_deviation = 0;
  // The standard deviation of the same logarithm between the visits of an arm.
  double noise_deviation = 0;
  // The share of visits that other work interrupts. Their times are multiplied by a draw from the
  // Pareto distribution with shape 1.5 and minimum 1, capped at 100.
  double spike_ratio = 0;
  // Time of a frame during a visit ÷ time of a frame without a visit; >= 1.
  double contention_ratio = 1;
  // By arm: time of a visit on the lane ÷ time of the same frames on the frame thread. The errors
  // above multiply this ratio. Empty: 1 for all arms.
  std::vector<double> arm_ratios{};
};

class ReplayLane {
 public:
  // REQUIRES: errors.arm_ratios is empty or has a ratio for each arm.
  ReplayLane(const ReplayScene& scene, const ShadowScheduleOptions& options, LaneErrors errors = {},
             uint64_t seed = 1);

  // The time at which the next sweep begins or the current visit ends.
  int64_t next_event_ns() const { return next_event_ns_; }

  // The current time and frame of the game.
  struct Place {
    int64_t now_ns = 0;      // the end of this frame
    uint64_t search_ns = 0;  // total time of all searches
    uint32_t game_frame = 0;
    uint32_t trace_frame = 0;
    uint32_t active_arm = 0;
  };
  // Ends the current visit, returns its sample, and begins the sweep's next visit if there is one.
  // If no visit is in progress, begins a sweep if the schedule allows it (ShadowSchedule::IsDue),
  // and returns nothing. REQUIRES: place.now_ns >= next_event_ns().
  std::optional<ShadowSample> Advance(const Place& place);

  // Builds `arm` and updates it on the game's frames. The visit in progress continues afterwards.
  // Returns the time at which the arm can take over.
  int64_t WarmUp(uint32_t arm, const Place& place);

  // Time of a frame ÷ its time without a lane.
  double frame_ratio() const { return visit_ ? errors_.contention_ratio : 1; }

  uint64_t visit_count() const { return visit_count_; }
  uint64_t busy_ns() const { return busy_ns_; }

 private:
  void BeginVisit(int64_t start_ns);
  void RepeatVisit();
  void Charge(int64_t begin_ns, int64_t end_ns);
  std::span<const uint64_t> FreshFrames(uint32_t trace_frame, uint32_t arm, double ratio = 1);
  double ErrorOfVisit(uint32_t arm) const;

  const ReplayScene& scene_;
  const LaneErrors errors_;
  const uint64_t seed_;
  ShadowSchedule schedule_;
  int64_t next_event_ns_ = 0;
  // The start of the current sweep, whose visits use the frames from there on.
  Place sweep_;
  std::optional<ShadowVisit> visit_;  // ends at next_event_ns_; absent between sweeps
  std::vector<uint64_t> fresh_ns_;    // the result of FreshFrames
  uint64_t visit_count_ = 0;
  uint64_t busy_ns_ = 0;
};

// Other work on the core of a replayed game's frame thread, such as another process or memory
// traffic of a neighbour. It starts and stops at random and lengthens all frames in between. The
// shadow lane runs on another core and is not affected.
struct FrameLoad {
  double ratio = 1;    // time of a frame with other work ÷ without; >= 1
  double share = 0.1;  // share of the time with other work; 0 < share < 1
};

class ReplayLoad {
 public:
  ReplayLoad(const FrameLoad& load, uint64_t seed) : load_(load), seed_(seed) {}

  // Returns FrameLoad::ratio if other work is running at now_ns, else 1. REQUIRES: now_ns never
  // decreases from call to call.
  double RatioAt(int64_t now_ns);

 private:
  FrameLoad load_;
  uint64_t seed_;
  // The number of the current stretch. Stretches without and with other work alternate; the first
  // one is without.
  uint64_t stretch_count_ = 0;
  int64_t stretch_end_ns_ = 0;
};

}  // namespace sweepstake::cli
