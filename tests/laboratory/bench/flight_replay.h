// Replays the file of a flight recorder (`sweepstake-lab replay --recording`). Reports what
// happened in the recorded frames, and how long every arm takes for them on this machine.
//
// Not thread-safe. Cost: three passes through the recording with all arms.
#pragma once

#include <nlohmann/json_fwd.hpp>
#include <string>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// Reads the file and times all arms on its boxes. Returns one JSON document. Errors: those of
// MakeScene, kInvalidArgument (the file was not written by a flight recorder, or by a newer one),
// kDataLoss (the recorder's notes are broken).
Result<nlohmann::ordered_json> ReplayFlight(const std::string& file);

// Returns the document as lines of text.
std::string FlightReplayText(const nlohmann::ordered_json& document);

}  // namespace sweepstake::cli
