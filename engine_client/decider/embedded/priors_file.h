// The priors file that ships with a game: `sweepstake priors export` writes it, and the embedded
// decider reads it.
//
// It is one JSON document: {"format": "sweepstake-priors", "version": 1, "records": […],
// "checksum": "0123456789abcdef", "scenes": […]}. It may lack either array.
//
// "records" has the evidence of sources, which daemons exchange. A record has the fields of
// sweepstake.v1.PriorRecord in snake_case. An absent measured_by, machine_class or build is empty,
// an absent count is 0, and an absent is_quarantined is false. Every other field is required. An
// unknown field is an error, because a misspelt one would silently change the key.
//
// "scenes" has the sums of builds (priors_sums.h), which games ship. It is small, so that a
// repository can hold it, with a line per scene and machine class and a line per build of it:
//   {"project": "p", "scene": "s", "machine_class": "m", "reward_version": 3,
//    "arms": ["Grid/1", "SAP/2"], "builds": {
//   "1.2": [1760000000, [[5.2, 4.1, 12], null], [[80.1, 62.5, 190], [75.5, 30.1, 180]]]}}
// An arm is NAME/BACKEND_VERSION. A build has the time when a source of it learnt last (seconds
// since 1970; 0: unknown), then a cell per arm for the frame thread, then a cell per arm for the
// lane. A cell has the increments of alpha and beta (five digits), the number of windows or visits,
// and the number of bail-outs if there are any. The checksum covers the scenes, independently of
// white space.
//
// Bounds: 128 MiB, 200,000 records or 1,000,000 sums, names of 128 bytes. Errors are one line and
// name the record, or the scene of sums, by its position from 0: kNotFound (no such file),
// kDataLoss (broken content).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/pooling/prior_record.h"
#include "sweepstake/status.h"

namespace sweepstake {

// Parses the text and checks every record. Returns the records, then the sums. Two with one KeyOf
// are an error, because the evidence would count twice.
Result<std::vector<PriorRecord>> ParsePriors(std::string_view text);
// REQUIRES: the sums among the records have distinct keys.
std::string FormatPriors(std::span<const PriorRecord> records);

Result<std::vector<PriorRecord>> ReadPriorsFile(const std::filesystem::path& path);
}  // namespace sweepstake
