// Reads the audit log of a daemon through the AuditService.
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "sweepstake/status.h"
#include "sweepstake/v1/audit.pb.h"

namespace sweepstake::cli {

// Selects a part of the log. An empty field selects everything.
struct AuditSelection {
  std::string session_id;
  std::string project;
  std::string scene;
};

// Lists the segments of the selected sessions. Error: kUnavailable (no daemon answered).
Result<std::vector<v1::AuditSegment>> ListAudit(const DaemonOptions& daemon,
                                                const AuditSelection& selection);
// Writes the log as a CSV file and returns the number of rows. After an error the file is
// unchanged. Errors: those of ListAudit, kNotFound (nothing matches the selection), and
// kInvalidArgument (the file cannot be written).
Result<uint64_t> ExportAudit(const DaemonOptions& daemon, const AuditSelection& selection,
                             const std::filesystem::path& path);

}  // namespace sweepstake::cli
