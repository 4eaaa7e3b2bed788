// The priors file that ships with a game: `sweepstake priors export` writes it, and the embedded
// decider reads it.
//
// It is one JSON document: {"format": "sweepstake-priors", "version": 1, "records": [{…}, …]}. A
// record has the fields of sweepstake.v1.PriorRecord in snake_case. An absent measured_by,
// machine_class or build is empty, an absent count is 0, an absent is_quarantined false, and every
// other field is required. An
// unknown field is an error, since a misspelt one would silently change the key.
//
// Sums of builds (priors_sums.h) make a version 2, a smaller one, of which ParsePriors returns the
// sums as records.
//
// Bounds: 128 MiB, 200,000 records or 1,000,000 sums, names of 128 bytes. Errors are one line and
// name the record, or the scene of sums, by its position from 0: kNotFound (no such file),
// kDataLoss (broken content), kUnavailable (cannot be written).
#pragma once

#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <vector>

#include "sweepstake/status.h"

namespace sweepstake {

// The evidence of one source (a session) about one arm.
struct PriorRecord {
  std::string project;
  std::string scene;
  std::string measured_by;  // "lane" or, for the frame thread, empty
  std::string arm;
  uint32_t backend_version = 0;  // >= 1
  std::string machine_class;     // empty: unknown
  uint32_t reward_version = 0;   // >= 1
  std::string source_id;
  uint64_t source_sequence = 0;  // >= 1
  double alpha_increment = 0;    // finite, 0 to 1e15, without any prior
  double beta_increment = 0;
  uint64_t window_count = 0;
  uint64_t bail_out_count = 0;
  std::string build = {};         // of the game that the source played; empty: unknown
  uint64_t last_seen_unix_s = 0;  // when the source taught last, below 2^63; 0: unknown
  // It waited in the quarantine of the daemon that exported it. It counts nowhere; a daemon that
  // imports it takes no notice of the mark.
  bool is_quarantined = false;
};

// Returns what names the evidence; two records of which it is equal are the same evidence. What
// waits may be newer than what counts of the same source, and stands beside it.
inline auto KeyOf(const PriorRecord& record) {
  return std::tie(record.project, record.scene, record.measured_by, record.arm,
                  record.backend_version, record.machine_class, record.reward_version,
                  record.source_id, record.is_quarantined);
}

// Parses the text and checks every record. A repeated pair of key and source is an error, since it
// would count twice.
Result<std::vector<PriorRecord>> ParsePriors(std::string_view text);
// Formats version 2 if all records are sums, and version 1 else.
std::string FormatPriors(std::span<const PriorRecord> records);

Result<std::vector<PriorRecord>> ReadPriorsFile(const std::filesystem::path& path);
// Writes the file, which appears whole or not at all.
Status WritePriorsFile(std::span<const PriorRecord> records, const std::filesystem::path& path);
// Likewise, of what FormatPriors or SumsWriter returned.
Status WritePriorsText(std::string_view text, const std::filesystem::path& path);

}  // namespace sweepstake
