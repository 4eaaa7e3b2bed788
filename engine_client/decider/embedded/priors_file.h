// The priors file that ships with a game: `sweepstake priors export` writes it, and the embedded
// decider reads it.
//
// It is one JSON document: {"format": "sweepstake-priors", "version": 1, "records": [{…}, …]}. A
// record has the fields of sweepstake.v1.PriorRecord in snake_case. An absent measured_by,
// machine_class or build is empty, an absent count is 0, and an absent is_quarantined is false.
// Every other field is required. An unknown field is an error, because a misspelt one would
// silently change the key.
//
// Version 2 is smaller and holds sums of builds (priors_sums.h). ParsePriors returns them as
// records.
//
// Bounds: 128 MiB, 200,000 records or 1,000,000 sums, names of 128 bytes. Errors are one line and
// name the record, or the scene of sums, by its position from 0: kNotFound (no such file),
// kDataLoss (broken content), kUnavailable (cannot be written).
#pragma once

#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "engine_client/decider/pooling/prior_record.h"
#include "sweepstake/status.h"

namespace sweepstake {

// Parses the text and checks every record. Two records with the same KeyOf are an error, because
// the evidence would count twice.
Result<std::vector<PriorRecord>> ParsePriors(std::string_view text);
// Formats version 2 if all records are sums, otherwise version 1.
std::string FormatPriors(std::span<const PriorRecord> records);

Result<std::vector<PriorRecord>> ReadPriorsFile(const std::filesystem::path& path);
// Writes the file atomically: after an error the previous file is unchanged.
Status WritePriorsFile(std::span<const PriorRecord> records, const std::filesystem::path& path);
// Does the same with a text that FormatPriors or SumsWriter returned.
Status WritePriorsText(std::string_view text, const std::filesystem::path& path);

}  // namespace sweepstake
