// A session's audit log as a store keeps it: rows of text in segments
// (engine_client/decider/audit/audit_log.h). Plain values.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace sweepstake::priors {

inline constexpr size_t kMaxAuditRowBytes = 65'536;  // a longer row is not stored

struct AuditRow {
  uint64_t number = 1;  // its number in the segment, from 1
  std::string text;     // 1 to kMaxAuditRowBytes bytes

  friend bool operator==(const AuditRow&, const AuditRow&) = default;
};

// Rows of one segment that come after those stored before.
struct AuditRows {
  uint32_t segment = 1;  // counts from 1
  std::string project;   // project and scene are names (text/names.h)
  std::string scene;
  int64_t unix_start_ms = 0;   // time at which the segment began
  std::vector<AuditRow> rows;  // in the order of their numbers, which may leave out some
};

// The limits of a store's audit log, of all sessions together but kAdminSession
// (engine_client/decider/audit/audit_log.h). Beyond them the oldest rows are removed, in chunks of
// a 32nd.
struct AuditLimits {
  uint64_t bytes = 256ull << 20;    // of the rows' text, some 1 kB a row of 7 arms; 0 keeps nothing
  uint64_t age_s = 30ull * 86'400;  // by the wall clock's time of the commits
  // The latest rows of kAdminSession, some 200 bytes each. They stay whatever the other limits are,
  // since games would push them out.
  uint64_t admin_row_count = 50'000;

  friend bool operator==(const AuditLimits&, const AuditLimits&) = default;
};

struct AuditSegment {
  uint64_t id = 0;  // given by the store, in the order in which segments were first stored
  std::string session_id;
  uint32_t segment = 1;
  std::string project;
  std::string scene;
  int64_t unix_start_ms = 0;
  uint64_t first_row = 1;       // number of the first stored row; those before it were removed
  uint64_t row_count = 0;       // stored rows
  uint64_t lost_row_count = 0;  // rows after the first stored one that could not be written

  friend bool operator==(const AuditSegment&, const AuditSegment&) = default;
};

// An empty field matches everything.
struct AuditFilter {
  std::string session_id;
  std::string project;
  std::string scene;
  std::vector<std::string> projects = {};  // any of these, and `project`
};

}  // namespace sweepstake::priors
