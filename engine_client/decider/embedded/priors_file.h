// The priors file that ships with a game. `sweepstake priors export` writes it, the embedded
// decider reads it.
//
// The file is one JSON document: {"format": "sweepstake-priors", "version": 1, "records": […],
// "checksum": "0123456789abcdef", "scenes": […]}. Either array may be absent.
//
// "records" has the evidence of single sources, which daemons exchange. A record has the fields of
// sweepstake.v1.PriorRecord in snake_case. These fields may be absent:
// - measured_by, machine_class, regime and build: empty
// - counts: 0
// - is_quarantined: false
// Every other field is required. An unknown one is an error: a misspelt field would change the key.
//
// "scenes" has the sums of builds (priors_sums.h), which games ship. It is small enough for a
// repository. It has one line per scene, machine class and regime, followed by one line per build
// of the game:
//   {"project": "p", "scene": "s", "machine_class": "m", "reward_version": 3,
//    "regime": "13/-4/0", "arms": ["Grid/1", "SAP/2"], "builds": {
//     "1.2": [1760000000, [[5.2, 4.1, 12], null], [[80.1, 62.5, 190], [75.5, 30.1, 180]]]}}
// An arm is written as NAME/BACKEND_VERSION. A build has three items:
// - the time when one of its sources learnt last, in seconds since 1970 (0: unknown)
// - one cell per arm for the frame thread
// - one cell per arm for the lane
// A cell has the increments of alpha and beta (five digits), the number of windows or visits, and
// any bail-outs; null: no evidence. The checksum covers "scenes" apart from white space.
//
// Limits: 128 MiB, 200,000 records, 1,000,000 sums, 128 bytes per name. An error is one line. It
// names the record, or the scene of sums, by its index from 0. Its code is kNotFound (no such file)
// or kDataLoss (broken content).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/pooling/prior_record.h"
#include "sweepstake/status.h"

namespace sweepstake {

// Parses the text and checks every record. Returns the records, then the sums. Two records with the
// same KeyOf are an error, because their evidence would count twice.
Result<std::vector<PriorRecord>> ParsePriors(std::string_view text);
// Error: kResourceExhausted (a file cannot have so many records of sources).
Status CheckRecordCount(std::span<const PriorRecord> records);
// Returns the text of a priors file. REQUIRES: the sums among the records have distinct keys.
std::string FormatPriors(std::span<const PriorRecord> records);

Result<std::vector<PriorRecord>> ReadPriorsFile(const std::filesystem::path& path);
}  // namespace sweepstake
