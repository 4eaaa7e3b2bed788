// The shadow lane of a replayed game: one worker that visits the arms in the order of the real
// lane's schedule (shadow_schedule.h), in virtual time, and warms the next arm up.
//
// What a visit takes and measures is what running structures take in the frames of its sweep, times
// what the trace's nearest burst says a fresh structure takes of that: where in the scene the game
// is stays exact between bursts. Deterministic; not thread-safe. Borrows the scene. Nanoseconds of
// virtual time.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "engine_client/adaptive/shadow_schedule.h"
#include "engine_client/cli/replay/replay_scene.h"
#include "server/decision/types.h"

namespace sweepstake::cli {

class ReplayLane {
 public:
  ReplayLane(const ReplayScene& scene, const ShadowScheduleOptions& options);

  // When something happens next: a sweep begins, or a visit ends.
  int64_t next_event_ns() const { return next_event_ns_; }

  // Where the game is.
  struct Place {
    int64_t now_ns = 0;  // the end of this frame
    uint32_t game_frame = 0;
    uint32_t trace_frame = 0;
    uint32_t active_arm = 0;
  };
  // The visit that has ended, if one has. REQUIRES: place.now_ns >= next_event_ns().
  std::optional<decision::ShadowSample> Advance(const Place& place);

  // Builds `arm` and keeps it up to date with the game from here on: the visit under way goes on
  // afterwards. Returns when it is ready to take over.
  int64_t WarmUp(uint32_t arm, const Place& place);

  uint64_t visit_count() const { return visit_count_; }
  uint64_t busy_ns() const { return busy_ns_; }

 private:
  void BeginVisit(int64_t start_ns);
  std::span<const uint64_t> FreshFrames(uint32_t trace_frame, uint32_t arm);

  const ReplayScene& scene_;
  ShadowSchedule schedule_;
  int64_t next_event_ns_ = 0;
  // The sweep under way; its visits see the frames of its beginning.
  Place sweep_;
  std::optional<ShadowVisit> visit_;  // ends at next_event_ns_; absent: between sweeps
  std::vector<uint64_t> fresh_ns_;    // of FreshFrames
  uint64_t visit_count_ = 0;
  uint64_t busy_ns_ = 0;
};

}  // namespace sweepstake::cli
