// Derives every decision of an audit log (audit_row.h) again and compares.
//
// Each segment gets a DecisionSession made from its setup row. The session receives the inputs of
// each row, with the runs in place of the frames. The row that it then makes must equal the logged
// one, field by field. A difference means that the log was edited, or that this program decides
// differently from the program that wrote it. Rows of a segment after a `missing` row and rows
// about administrators cannot be derived; only their hashes are checked. No input makes it crash.
// It takes the time of the decisions, and memory for the session of one segment.
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "engine_client/decider/audit/audit_row.h"
#include "engine_client/decider/session/policy_registry.h"

namespace sweepstake::decision {

struct AuditDifference {
  uint64_t line = 0;    // line of the file; the first one is 1. 0: not from a file
  std::string session;  // empty if there is no row
  uint32_t segment = 0;
  uint64_t row = 0;
  std::string column;   // of the CSV file; empty if the row as a whole is wrong
  std::string message;  // what is wrong, in words

  // Returns all of it in one line.
  std::string Text() const;
};

struct AuditReport {
  // The counts stop at the first difference.
  uint64_t session_count = 0;
  uint64_t segment_count = 0;   // segments whose first row is present
  uint64_t row_count = 0;       // rows in the log, without `missing` ones
  uint64_t decision_count = 0;  // decisions that were derived
  uint64_t incomplete_segment_count = 0;
  uint64_t underived_decision_count = 0;      // decisions after missing rows
  std::optional<AuditDifference> difference;  // the first one; absent if everything is equal
};

// Segments may be in any order, but each must be in one piece that begins with its setup row or
// with a `missing` row. Their last rows may be missing. Policies are looked up in `policies`.
AuditReport Rederive(std::span<const AuditRow> rows, PolicyRegistry policies = ShippedPolicies());
// The same for a CSV file (audit_csv.h).
AuditReport RederiveCsv(std::string_view csv, PolicyRegistry policies = ShippedPolicies());

}  // namespace sweepstake::decision
