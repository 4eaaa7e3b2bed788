// Lets a policy play a traced scene in virtual time: a simulated client drives the real
// decision::DecisionSession.
//
// Deterministic: the same scene and setup give the same result bit for bit. No clock, no I/O; safe
// to call from many threads with one scene. Times are nanoseconds of virtual time, which starts at
// 0 with the first frame and advances by the frames' times.
//
// The simulated client behaves like a real one. It sends frames to the session in batches (250 ms
// or 30 frames). Ticks happen when they are due, even within a long frame. A command is executed at
// the start of the next frame. Without a shadow lane this is a cold switch, and the next frames
// have the cost of a freshly built structure. With a lane the structure is warmed up first, and the
// switch has the cost of the warm-up's last frame. The client's own SwitchCostMeter measures switch
// costs. A frame over the bail-out limit is reported at once.
//
// Cost: linear in the frames, plus the policy's own time.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/decider/session/decision_session.h"
#include "tests/laboratory/replay/replay_lane.h"
#include "tests/laboratory/replay/replay_scene.h"

namespace sweepstake::cli {

struct ReplaySetup {
  decision::DecisionOptions options;
  // The session's seed. It also determines the initial arm and the game's start in the trace.
  uint64_t seed = 1;
  std::optional<bool> shadow_lane;                // absent: on if the policy learns from it
  std::vector<decision::BetaPosterior> priors{};  // one per arm; empty: none
  decision::RegimePriors regime_priors{};
  // Called with each tick and bail-out, in order.
  std::function<void(const decision::DecisionRecord&)> on_decision = nullptr;
  // Options of the shadow lane; unused without a lane.
  ShadowScheduleOptions shadow = {};
  LaneErrors lane_errors = {};
  FrameLoad frame_load = {};
};

// Compares the probabilities that a policy predicts with the observed frequencies: a reliability
// table (A. Murphy, "Reliability of subjective probability forecasts", Applied Statistics 26,
// 1977). The prediction of a decision is its leader, the arm with the highest P(best), and that
// probability. Whether the leader was the fastest arm is determined on the frames since the
// previous decision, for which the trace contains the time of every arm.
struct ReliabilityBin {
  uint64_t decision_count = 0;
  double probability_sum = 0;
  uint64_t best_count = 0;  // the leader was the fastest arm
  uint64_t tie_count = 0;   // the leader took at most kTieLossRatio (diagnosis.h) more time
  bool operator==(const ReliabilityBin&) const = default;
};

class Reliability {
 public:
  // A bin begins at its edge and ends before the next one; the last one includes its end, 1.
  static constexpr std::array kEdges = {0.0, 0.5, 0.6, 0.7, 0.8, 0.9, 0.95, 0.99, 1.0};
  static constexpr size_t kBinCount = kEdges.size() - 1;

  // Adds a decision. `loss_ratio` is the leader's time ÷ the fastest arm's time, minus 1. REQUIRES:
  // `probability` is from 0 to 1.
  void Add(double probability, double loss_ratio);
  Reliability& operator+=(const Reliability& other);

  const std::array<ReliabilityBin, kBinCount>& bins() const { return bins_; }
  uint64_t decision_count() const;
  // Returns the calibration error: the mean over the decisions of |mean probability of the
  // decision's bin − share of that bin in which the leader was the fastest arm|. 0 without
  // decisions.
  double error() const;
  bool operator==(const Reliability&) const = default;

 private:
  std::array<ReliabilityBin, kBinCount> bins_{};
};

// Evidence of a game, per arm, by regime (a bucket of decider/policy/regime_bucket.h).
using StoredEvidence = std::map<std::string, std::vector<decision::ArmEvidence>>;

struct ReplayResult {
  // All sums of this struct leave out the time that FrameLoad adds to frames.
  uint64_t total_ns = 0;  // sum over all frames
  // Frames of the start-up, which lasts until the live exploration ends, but at least kStartUpNs.
  uint32_t start_up_frame_count = 0;
  uint64_t after_start_up_ns = 0;            // sum over the frames after the start-up
  uint64_t after_start_up_switch_count = 0;  // switches executed after the start-up
  uint32_t opening_frame_count = 0;          // frames that begin before kOpeningNs
  uint64_t opening_ns = 0;                   // sum over these frames
  decision::ObservationSummary observation;  // active time and switches after the exploration
  std::array<uint64_t, 5> switch_counts{};   // switches executed in the whole run, by SwitchReason
  std::vector<uint64_t> active_ns;           // frame time per arm in the whole run; sum: total_ns
  uint64_t bail_out_count = 0;               // frames over the bail-out limit
  std::vector<std::optional<int64_t>>
      first_active_ns;  // when each arm was first chosen after the exploration
  // The choice of the first tick: the arm that it commands, or the active arm if it commands no
  // switch. Absent if there was no tick.
  std::optional<uint32_t> first_choice;
  StoredEvidence stored;                     // evidence that a daemon would store
  std::array<uint64_t, 5> verdict_counts{};  // number of ticks, by Verdict
  Reliability reliability;                   // reliability of P(best) at the ticks
  uint64_t shadow_visit_count = 0;
  uint64_t shadow_ns = 0;  // time that the lane worked

  // The arm with the most active time after the exploration, and its share of that time.
  uint32_t dominant_arm() const;
  double active_share() const;
};

inline constexpr int64_t kStartUpNs = 60'000'000'000;
inline constexpr int64_t kOpeningNs = 10'000'000'000;

// Plays the game. REQUIRES: setup.options are valid; there are as many priors as arms, or none.
ReplayResult Replay(const ReplayScene& scene, const ReplaySetup& setup);

}  // namespace sweepstake::cli
