// A session's audit log as a store keeps it: rows of text in segments (server/audit/audit_log.h).
// Plain values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sweepstake::priors {

// Rows that continue those stored before.
struct AuditRows {
  uint32_t segment = 1;  // counts from 1
  std::string project;   // project and scene are names (decision/math/names.h)
  std::string scene;
  int64_t unix_start_ms = 0;      // time at which the segment began
  uint64_t first_row = 1;         // number of rows[0] in the segment, from 1
  std::vector<std::string> rows;  // rows of 1 to kMaxAuditRowBytes bytes; may be empty
};

inline constexpr size_t kMaxAuditRowBytes = 65'536;  // a longer row ends its segment's log

// The limits of a store's audit log. A row of 7 arms has some 1 kB.
struct AuditLimits {
  // The log of a session ends after this many rows in all its segments: 11 hours at one row every
  // two seconds.
  uint64_t rows_per_session = 20'000;
  // If there are more rows than this of all sessions, whole segments are removed, the oldest first.
  // 0 keeps nothing.
  uint64_t rows = 200'000;
};

struct AuditSegment {
  uint64_t id = 0;  // given by the store, in the order in which segments begin
  std::string session_id;
  uint32_t segment = 1;
  std::string project;
  std::string scene;
  int64_t unix_start_ms = 0;
  uint64_t row_count = 0;

  friend bool operator==(const AuditSegment&, const AuditSegment&) = default;
};

// An empty field matches everything.
struct AuditFilter {
  std::string session_id;
  std::string project;
  std::string scene;
};

}  // namespace sweepstake::priors
