// Replays the file of a flight recorder (`sweepstake-lab replay --recording`). Shows what happened
// in the recorded frames, and times every arm on them on this machine.
//
// Not thread-safe. Cost: kFlightPasses times the arms' own time.
#pragma once

#include <cstdint>
#include <nlohmann/json_fwd.hpp>
#include <optional>
#include <string>
#include <vector>

#include "sweepstake/status.h"

namespace sweepstake::cli {

inline constexpr int kFlightPasses = 3;

struct FlightFrameRow {
  uint64_t frame = 0;
  double frame_ms = 0;
  double detection_ms = 0;
  uint64_t object_count = 0;
  uint64_t pair_count = 0;
  uint32_t arm = 0;             // index in FlightLog::arms
  std::optional<size_t> boxes;  // the number of its boxes in the file; absent: not recorded
};

struct FlightDecisionRow {
  uint64_t frame = 0;  // the latest frame at the time of the decision
  std::string outcome;
  std::string verdict;
  std::string reason;  // of the switch command; empty: none
  std::optional<uint32_t> candidate_arm;
  std::optional<uint32_t> commanded_arm;
  std::vector<double> best_probability;  // per arm; empty: unknown
};

// The notes of a recording.
struct FlightLog {
  std::string project;
  std::string scene;
  std::string build;
  std::string machine_class;
  int64_t recorded_unix_ms = 0;
  double frame_budget_ms = 0;
  size_t worst = 0;  // index in `frames`
  std::vector<std::string> arms;
  std::vector<FlightFrameRow> frames;  // at least one, and one with boxes
  std::vector<FlightDecisionRow> decisions;
};

// The times of an arm on the recorded boxes on this machine, and its times in the game.
struct FlightArm {
  std::string name;
  double ms_mean = 0;
  double ms_max = 0;
  double ms_worst = 0;            // in the longest frame, or the next one with boxes
  uint64_t live_frame_count = 0;  // frames of the game in which it was active
  std::optional<double> live_ms_mean;
};

struct FlightReplay {
  FlightLog log;
  size_t box_frame_count = 0;
  std::vector<FlightArm> arms;  // all arms of this program, the cheapest first
};

// Reads the notes. kNotFound and kDataLoss as of MakeScene; kInvalidArgument: the file was not
// written by a flight recorder, or by a newer one.
Result<FlightLog> ReadFlightLog(const std::string& file);

// Reads the file and times all arms on its boxes. Errors: those of ReadFlightLog.
Result<FlightReplay> ReplayFlight(const std::string& file);

// Return the replay as one JSON document and as lines of text.
nlohmann::ordered_json FlightReplayJson(const FlightReplay& replay, const std::string& file);
std::string FlightReplayText(const FlightReplay& replay, const std::string& file);

}  // namespace sweepstake::cli
