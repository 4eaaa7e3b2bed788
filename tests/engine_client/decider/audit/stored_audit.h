// Reads the audit log of a store for tests.
#pragma once

#include <cstddef>
#include <cstdint>
#include <vector>

#include "absl/status/statusor.h"
#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/telemetry/conversion/audit_conversion.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::test_support {

// Returns the rows of all sessions, up to 10,000 segments. As the audit service does it, a
// `missing` row replaces rows that are not on disk. Returns errors of the store.
inline absl::StatusOr<std::vector<decision::AuditRow>> StoredAudit(priors::PriorReader& store) {
  const auto segments = store.ListAudit({}, 0, 10'000);
  if (!segments.ok()) return segments.status();
  std::vector<decision::AuditRow> log;
  for (const priors::AuditSegment& segment : *segments) {
    const auto rows = store.LoadAudit(segment.id, 1, 1'000'000, size_t{1} << 30);
    if (!rows.ok()) return rows.status();
    uint64_t next = 1;
    for (const priors::StoredAuditRow& row : *rows) {
      if (row.number != next)
        log.push_back(decision::MissingRow(segment.session_id, segment.segment, next));
      next = row.number + 1;
      v1::AuditRow message;
      message.ParseFromString(row.bytes);
      log.push_back(FromProto(message));
    }
  }
  return log;
}

}  // namespace sweepstake::test_support
