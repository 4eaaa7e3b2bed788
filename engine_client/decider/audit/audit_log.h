// Makes the rows of the audit log (audit_row.h) for sessions and for actions of administrators.
#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "engine_client/decider/audit/audit_row.h"
#include "engine_client/math/hash.h"

namespace sweepstake::decision {

class DecisionSession;

// Returns the hash of a segment up to and including this row: 64-bit FNV-1a over all fields of the
// row except log_hash, in their order. `before` is the log_hash of the previous row, or
// kFnv1aStart.
uint64_t AuditHash(uint64_t before, const AuditRow& row);

// Returns the `missing` row that stands in place of rows that were removed or not written. `row` is
// the number of the first missing row. Fields not passed here stay empty.
AuditRow MissingRow(std::string_view session_id, uint32_t segment, uint64_t row);

// Session id of the rows about actions of administrators. No session has this id.
inline constexpr std::string_view kAdminSession = "admin";

// Makes the rows of one segment of kAdminSession: one row per action of an administrator. These
// rows lead to no decision, so a replay checks only their hashes. Not thread-safe.
class AdminRows {
 public:
  explicit AdminRows(uint32_t segment) : segment_(segment) {}

  // `now_ns` is on the decider's steady clock, `unix_ms` on the wall clock. `operator_name` is the
  // subject of a sentence; `action` is the rest of it, without the full stop.
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
  // Receives the next row, which is valid only during the call. The call must not use the session.
  virtual void OnAuditRow(const AuditRow& row) = 0;
};

// Starts the log of a session. The sink receives the setup row at once, then one row per event and
// decision. Without this call a session makes no rows. The sink must outlive the session. REQUIRES:
// the session has observed nothing yet.
void StartAudit(DecisionSession& session, AuditSink& sink, AuditOrigin origin);

}  // namespace sweepstake::decision
