// A policy plays a traced scene in virtual time: the real decision::DecisionSession, driven by a
// simulated client.
//
// Deterministic: the same scene and setup give the same result bit for bit. No clock, no I/O; safe
// to call from many threads with one scene. Times in nanoseconds of virtual time, which begins with
// the first frame at 0 and runs by the frames' own times.
//
// The client does what a real one does. Frames go to the session in batches (250 ms or 30 frames);
// ticks come when they are due, in the middle of a long frame too; a command is executed at the
// next frame's start. Without a shadow lane that is a cold switch: the frames after it cost what a
// freshly built structure costs. With one the structure is warmed up by the lane first, and the
// switch costs what the last frame of the warm-up does. What switches cost is metered by the
// client's own SwitchCostMeter. A frame over the limit is reported at once.
//
// Cost: some 2–3 ms for 90,000 frames and seven arms, without what the policy itself takes.
#pragma once

#include <array>
#include <cstdint>
#include <optional>
#include <vector>

#include "engine_client/adaptive/shadow_schedule.h"
#include "engine_client/cli/replay/replay_scene.h"
#include "server/decision/session/decision_session.h"

namespace sweepstake::cli {

struct ReplaySetup {
  decision::DecisionOptions options;
  uint64_t seed =
      1;  // of the session; rotates the initial arm and where in the trace the game starts
  std::optional<bool> shadow_lane;                // absent: where the policy learns from it
  std::vector<decision::BetaPosterior> priors{};  // one per arm; empty: none
  bool keep_timeline = false;
  ShadowScheduleOptions shadow = {};  // of the lane, where there is one
};

struct Activation {
  int64_t time_ns = 0;
  uint32_t arm = 0;
  decision::SwitchReason reason = decision::SwitchReason::kPolicy;
};

// What a report draws.
struct ReplayTimeline {
  uint32_t initial_arm = 0;
  std::vector<Activation> activations;              // executed switches
  std::vector<decision::DecisionRecord> decisions;  // ticks and bail-outs, in order
};

struct ReplayResult {
  uint64_t total_ns = 0;  // of all frames
  // The start-up is over when the live exploration has ended, and not before kStartUpNs.
  uint32_t start_up_frame_count = 0;
  uint64_t after_start_up_ns = 0;            // of the frames after it
  decision::ObservationSummary observation;  // active time and switches after the exploration
  std::array<uint64_t, 5> switch_counts{};   // executed, of the whole run, by SwitchReason
  std::vector<uint64_t> active_ns;           // frame time per arm, of the whole run; sum: total_ns
  uint64_t bail_out_count = 0;               // frames over the limit
  std::vector<std::optional<int64_t>> first_active_ns;  // per arm, outside of the exploration
  std::vector<decision::BetaPosterior> posteriors;      // at the end
  std::array<uint64_t, 5> verdict_counts{};             // ticks, by Verdict
  uint64_t decision_count = 0;
  uint64_t shadow_visit_count = 0;
  uint64_t shadow_ns = 0;  // the lane's work
  ReplayTimeline timeline;

  // The arm with the most active time after the exploration, and its share of that time.
  uint32_t dominant_arm() const;
  double active_share() const;
};

inline constexpr int64_t kStartUpNs = 60'000'000'000;

// REQUIRES: setup.options are valid, and as many priors as arms, or none.
ReplayResult Replay(const ReplayScene& scene, const ReplaySetup& setup);

}  // namespace sweepstake::cli
