// A session's audit log as a store keeps it: rows of bytes in segments
// (engine_client/decider/audit/audit_row.h). Plain values.
#pragma once

#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace sweepstake::priors {

inline constexpr size_t kMaxAuditRowBytes = 65'536;  // a longer row is not stored
// Maximum number of rows that one scan of the log examines, whether they match or not.
inline constexpr uint32_t kAuditScanRows = 4'000;

struct StoredAuditRow {
  uint64_t number = 1;  // position in the segment, from 1
  std::string bytes;    // a message sweepstake.v1.AuditRow, 1 to kMaxAuditRowBytes bytes

  friend bool operator==(const StoredAuditRow&, const StoredAuditRow&) = default;
};

// Rows of one segment that follow the rows that are already stored.
struct AuditRows {
  uint32_t segment = 1;  // number of the segment in its session, from 1
  std::string project;   // project and scene are names (text/names.h)
  std::string scene;
  int64_t unix_start_ms = 0;         // time at which the segment began
  std::vector<StoredAuditRow> rows;  // ascending by number; numbers may be missing
};

// Returns the time of the steady clock.
inline int64_t SteadyNs() {
  return std::chrono::nanoseconds(std::chrono::steady_clock::now().time_since_epoch()).count();
}

// Limits of a store's audit log, over all sessions except kAdminSession, whose rows are the actions
// of administrators (engine_client/decider/audit/audit_log.h). Above the limits the oldest rows are
// removed, 1/32 of the log at a time.
struct AuditLimits {
  // Maximum size of all rows; 0: stores none. A row of a session with 7 arms has about 0.8 kB.
  uint64_t bytes = 256ull << 20;
  uint64_t age_s = 30ull * 86'400;  // maximum time since a row's commit (RetentionClock)
  // Number of the latest rows of kAdminSession that are kept, about 200 bytes each. The other
  // limits do not apply to them, because rows of games would push them out.
  uint64_t admin_row_count = 50'000;
  // The steady clock by which the retention clock is limited. Tests replace it.
  int64_t (*steady_ns)() = SteadyNs;

  friend bool operator==(const AuditLimits&, const AuditLimits&) = default;
};

struct AuditSegment {
  uint64_t id = 0;  // assigned by the store, in the order in which segments were first stored
  std::string session_id;
  uint32_t segment = 1;
  std::string project;
  std::string scene;
  int64_t unix_start_ms = 0;
  uint64_t first_row = 1;       // number of the first stored row; earlier rows were removed
  uint64_t row_count = 0;       // stored rows
  uint64_t lost_row_count = 0;  // rows after first_row that could not be written
  // SourceOrigin::owner() of the session; 0 and empty if nothing of the session is stored.
  int64_t token_id = 0;
  std::string party = {};

  friend bool operator==(const AuditSegment&, const AuditSegment&) = default;
};

// A row with its place in the log of all sessions.
struct PlacedAuditRow {
  uint64_t id = 0;  // grows in the order of arrival; from 1
  uint64_t segment_id = 0;
  StoredAuditRow row;

  friend bool operator==(const PlacedAuditRow&, const PlacedAuditRow&) = default;
};

enum class AuditOrder { kNewestFirst, kOldestFirst };

// The result of PriorReader::ScanAudit.
struct AuditScan {
  std::vector<PlacedAuditRow> rows;  // in the order of the scan
  uint64_t first_id = 0;             // the first row that was examined; the start if there was none
  uint64_t last_id = 0;              // the last row that was examined; the start if there was none
  bool at_end = false;               // no rows follow

  friend bool operator==(const AuditScan&, const AuditScan&) = default;
};

// Selects segments of the audit log. An empty field matches everything.
struct AuditFilter {
  std::string session_id;
  std::string project;
  std::string scene;
  // The project must be in this list, and also match `project`.
  std::vector<std::string> projects = {};
};

}  // namespace sweepstake::priors
