// Reads the audit log of a store as one CSV text.
#pragma once

#include <cstddef>
#include <cstdint>
#include <string>

#include "absl/status/statusor.h"
#include "engine_client/decider/audit/audit_log.h"
#include "server/sessions/prior_store.h"

namespace sweepstake::test_support {

// Returns the rows of all sessions, up to 10,000 segments. As in the audit service, a `missing` row
// replaces rows that the disk was too slow to store. Errors: those of the store.
inline absl::StatusOr<std::string> AuditCsv(priors::PriorReader& store) {
  const auto segments = store.ListAudit({}, 0, 10'000);
  if (!segments.ok()) return segments.status();
  std::string csv = decision::AuditHeader() + "\n";
  for (const priors::AuditSegment& segment : *segments) {
    const auto rows = store.LoadAudit(segment.id, 1, 1'000'000, size_t{1} << 30);
    if (!rows.ok()) return rows.status();
    uint64_t next = 1;
    for (const priors::AuditRow& row : *rows) {
      if (row.number != next)
        csv += decision::MissingRow(segment.session_id, segment.segment, next) + "\n";
      next = row.number + 1;
      csv += row.text + "\n";
    }
  }
  return csv;
}

}  // namespace sweepstake::test_support
