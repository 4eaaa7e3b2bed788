// Counts of events in the runs of the simulation. A plain value.
#pragma once

#include <cstdint>
#include <string>

namespace sweepstake::simulation {

// How often each event happened, so that a test can check that every event occurs.
struct Tally {
  uint64_t kills = 0;
  uint64_t power_cuts = 0;
  uint64_t failed_starts = 0;
  uint64_t drains = 0;
  uint64_t commits = 0;
  uint64_t failed_commits = 0;
  uint64_t decisions = 0;
  uint64_t resumed = 0;
  uint64_t resent = 0;
  uint64_t replayed = 0;
  uint64_t degraded_starts = 0;
  uint64_t derived_decisions = 0;
  uint64_t lost_acknowledgements = 0;
  uint64_t lost_answers = 0;
  uint64_t imports = 0;
  uint64_t revoked_tokens = 0;
  uint64_t thefts = 0;
  uint64_t clock_jumps = 0;
  uint64_t watched_scenes = 0;

  Tally& operator+=(const Tally& other);
  std::string Text() const;
  // Returns the names of the events that never happened.
  std::string NeverHappened() const;
};

}  // namespace sweepstake::simulation
