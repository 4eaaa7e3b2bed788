// Derives every decision of an audit log (audit_row.h) again, and compares it with the log.
//
// Each segment gets a DecisionSession, made from its setup row. The session receives the inputs of
// each row, with the logged runs instead of the frames. The row that the session makes must equal
// the logged one, field by field. A difference means one of two things: the log was edited, or this
// program decides differently from the program that wrote it.
//
// Rows after a `missing` row of their segment, and rows about administrators, cannot be derived.
// Only their hashes are checked. No input crashes the replay. It takes as long as making the
// decisions did, and holds one session in memory.
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
  uint64_t line = 0;    // line of the file, from 1; 0: the log is not a file
  std::string session;  // empty if the error concerns no row
  uint32_t segment = 0;
  uint64_t row = 0;
  std::string column;   // column of the CSV file; empty if no single one is wrong
  std::string message;  // describes the error

  // Returns one line with all members.
  std::string Text() const;
};

struct AuditReport {
  // The counts stop at the first difference.
  uint64_t session_count = 0;
  uint64_t segment_count = 0;   // segments whose setup row is present
  uint64_t row_count = 0;       // rows in the log, without `missing` ones
  uint64_t decision_count = 0;  // decisions that were derived
  uint64_t incomplete_segment_count = 0;
  uint64_t underived_decision_count = 0;      // decisions that could not be derived
  std::optional<AuditDifference> difference;  // the first difference; absent if all rows are equal
};

// Derives the decisions of `rows` again and compares them. Segments may come in any order. Each
// segment's rows must be consecutive and begin with its setup row or a `missing` row; the last ones
// may be missing. Policies are looked up by name in `policies`.
AuditReport Rederive(std::span<const AuditRow> rows, PolicyRegistry policies = ShippedPolicies());
// Works like Rederive, for a log in a CSV file (audit_csv.h).
AuditReport RederiveCsv(std::string_view csv, PolicyRegistry policies = ShippedPolicies());

}  // namespace sweepstake::decision
