// The audit log of a daemon, over the AuditService.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "sweepstake/status.h"

namespace sweepstake::cli {

// An empty field selects all.
struct AuditSelection {
  std::string session_id;
  std::string project;
  std::string scene;
};

struct AuditSegmentRow {
  std::string session_id;
  uint32_t segment = 1;
  std::string project;
  std::string scene;
  int64_t unix_start_ms = 0;
  uint64_t row_count = 0;
};

// kUnavailable: no daemon answered.
Result<std::vector<AuditSegmentRow>> ListAudit(const std::string& address,
                                               const AuditSelection& selection);
// Writes the log as a CSV file, which appears whole or not at all, and returns the number of rows.
// Has the errors of ListAudit, and kInvalidArgument: the file cannot be written.
Result<uint64_t> ExportAudit(const std::string& address, const AuditSelection& selection,
                             const std::filesystem::path& path);

}  // namespace sweepstake::cli
