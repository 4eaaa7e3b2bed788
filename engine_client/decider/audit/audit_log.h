// Makes the rows of the audit log (audit_row.h): of a session, and of what administrators do.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "engine_client/decider/audit/audit_row.h"
#include "engine_client/math/hash.h"

namespace sweepstake::decision {

class DecisionSession;

// Returns the hash of a segment up to and including this row, without its log_hash: FNV-1a of 64
// bits over the fields in their order. `before` is the hash up to the row before, or kFnv1aStart.
uint64_t AuditHash(uint64_t before, const AuditRow& row);

// Returns the `missing` row that replaces rows that were removed or not written. `row` is the
// number of the first of these; the other fields are empty.
AuditRow MissingRow(std::string_view session_id, uint32_t segment, uint64_t row);

// Session id of the rows about actions of administrators. No session has this id.
inline constexpr std::string_view kAdminSession = "admin";

// Makes the rows of a segment of kAdminSession, one per action of an administrator. No decision
// follows from them; only their hashes are checked. Not thread-safe.
class AdminRows {
 public:
  explicit AdminRows(uint32_t segment) : segment_(segment) {}

  // `now_ns` is a time of the decider's steady clock, `unix_ms` of the wall clock. `operator_name`
  // and `action` are the subject and the rest of a sentence without its full stop.
  AuditRow Next(int64_t now_ns, int64_t unix_ms, std::string operator_name, std::string action);

 private:
  const uint32_t segment_;
  uint64_t row_count_ = 0;
  uint64_t hash_ = math::kFnv1aStart;
};

// Receives the rows as they are made.
class AuditSink {
 public:
  virtual ~AuditSink() = default;
  // The row is valid during the call, which must not call the session back.
  virtual void OnAuditRow(const AuditRow& row) = 0;
};

// Starts the log: the sink receives the setup's row at once, then a row per event and decision. A
// session without this call makes no rows. The sink must outlive the session. REQUIRES: the session
// has observed nothing yet.
void StartAudit(DecisionSession& session, AuditSink& sink, AuditOrigin origin);

}  // namespace sweepstake::decision
