// Writes the content of a frozen FlightRing as a .aabbs file. The file's notes contain the
// measurements of the frames and the decisions of the recorded seconds.
//
// The files are flight-TIME.aabbs in the folder of the options; TIME is in UTC. The newest
// kMaxRecordings of a session are kept. For a further one the session removes its own oldest file,
// and never another file.
//
// Thread safety: Step on the sender thread, the ring's OnBoxes and OnFrame on the frame thread,
// recordings() and error() on any thread. Memory: the ring; during a write also one frame and the
// notes, at most about 400 kB.
#pragma once

#include <cstdint>
#include <deque>
#include <mutex>
#include <string>
#include <vector>

#include "engine_client/telemetry/common/flight_ring.h"
#include "sweepstake/adaptive_broad_phase.h"
#include "sweepstake/session.h"

namespace sweepstake {

// A decision and the index of the latest frame when it was recorded.
struct FlightDecision {
  uint64_t frame_index = 0;
  LastDecision decision;
};

class FlightRecorder {
 public:
  static constexpr size_t kMaxRecordings = 8;
  static constexpr size_t kMaxDecisions = 64;

  // REQUIRES: options.flight_recorder is valid, with memory_mb > 0.
  explicit FlightRecorder(const SessionOptions& options);

  FlightRing& ring() { return ring_; }
  // Records the latest decision if it is new, and writes a frozen ring to a file. Called every few
  // milliseconds.
  void Step(const AdaptiveBroadPhase& adaptive);
  // Returns the files that this session wrote and has not removed, the oldest first.
  std::vector<FlightRecording> recordings() const;
  // Returns why the latest recording could not be written; empty if it succeeded.
  std::string error() const;

 private:
  void NoteDecision(const AdaptiveBroadPhase& adaptive);
  Status Write(const AdaptiveBroadPhase& adaptive);
  Status Keep(FlightRecording recording);

  const SessionOptions options_;
  FlightRing ring_;
  std::deque<FlightDecision> decisions_;  // the latest kMaxDecisions

  mutable std::mutex mutex_;
  std::vector<FlightRecording> recordings_;  // guarded by mutex_
  std::string error_;                        // guarded by mutex_
};

// Returns the recording's notes: one JSON document (engine_client/README.md, Flight recorder).
// `worst` is the index of the longest frame in `frames`.
std::string FlightNotes(const SessionOptions& options, const AdaptiveBroadPhase& adaptive,
                        const std::vector<FlightFrame>& frames, size_t worst,
                        const std::deque<FlightDecision>& decisions, int64_t recorded_unix_ms);

}  // namespace sweepstake
