// The calls of the commands to a daemon's services. Thread-safe.
//
// An empty project or scene selects all. Errors: kUnavailable (no daemon answered), and those that
// the daemon sends.
#pragma once

#include <cstdint>
#include <filesystem>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "engine_client/decider/pooling/prior_record.h"
#include "sweepstake/status.h"
#include "sweepstake/v1/audit.pb.h"
#include "sweepstake/v1/posteriors.pb.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/sessions.pb.h"

namespace sweepstake::cli {

// AuditService.

// Selects a part of the log. An empty field selects everything.
struct AuditSelection {
  std::string session_id;
  std::string project;
  std::string scene;
};

// Lists the segments of the selected sessions.
Result<std::vector<v1::AuditSegment>> ListAudit(const DaemonOptions& daemon,
                                                const AuditSelection& selection);
// Writes the log as a CSV file and returns the number of rows. After an error the file is
// unchanged. More errors: kNotFound (nothing matches the selection), and kInvalidArgument (the file
// cannot be written).
Result<uint64_t> ExportAudit(const DaemonOptions& daemon, const AuditSelection& selection,
                             const std::filesystem::path& path);

// PosteriorsService.

// Returns the posteriors of a daemon's scenes.
Result<std::vector<v1::ScenePosterior>> ListPosteriors(const DaemonOptions& daemon,
                                                       const std::string& project,
                                                       const std::string& scene);
// Calls `on_event` with each event of the daemon until `is_stopped` returns true, which another
// thread calls every 50 ms. If the daemon is lost, calls `on_connection` with the error and
// reconnects. Then it calls `on_connection` with OK, possibly on that other thread, and the events
// start from the beginning again. Returns kUnavailable if the daemon was never reached, or the
// error of a daemon that refuses.
Status WatchPosteriors(const DaemonOptions& daemon, const std::string& project,
                       const std::string& scene, const std::function<bool()>& is_stopped,
                       const std::function<void(const v1::WatchPosteriorsResponse&)>& on_event,
                       const std::function<void(const Status&)>& on_connection);

// PriorsService.

// Selects what to export: all records including those in quarantine, or only those in quarantine.
enum class Exported : uint8_t { kAll, kQuarantined };

// Returns the records of a daemon.
Result<std::vector<PriorRecord>> ExportPriors(const DaemonOptions& daemon,
                                              const std::string& project, const std::string& scene,
                                              Exported what = Exported::kAll);
// Calls `on_record` with each record as it arrives: scene by scene, and all quarantined records
// after all others.
Status StreamPriors(const DaemonOptions& daemon, const std::string& project,
                    const std::string& scene, Exported what,
                    const std::function<void(PriorRecord)>& on_record);

struct ImportCounts {
  uint64_t applied_count = 0;
  uint64_t unchanged_count = 0;
  // The unchanged records that the daemon does not have under their project and scene, because
  // their source was revoked or is stored under another project or scene. Also 0 if the daemon's
  // evidence cannot be read.
  uint64_t absent_count = 0;
};
// Adds all records or, on an error, none. They go to the quarantine or, with `promote`, count at
// once.
Result<ImportCounts> ImportPriors(const DaemonOptions& daemon, std::span<const PriorRecord> records,
                                  bool promote = false);

// Makes quarantined evidence of the sources count. With `preview` it only returns what would
// change.
Result<v1::PromotePriorsResponse> PromotePriors(const DaemonOptions& daemon,
                                                const v1::SourceFilter& sources, bool preview);
// Removes the evidence of the sources from the daemon. With `preview` it only returns what would
// change.
Result<v1::RevokePriorsResponse> RevokePriors(const DaemonOptions& daemon,
                                              const v1::SourceFilter& sources, bool preview);

// SessionsService.

// Returns the sessions in a daemon's memory, ordered by id.
Result<std::vector<v1::SessionInfo>> ListSessions(const DaemonOptions& daemon,
                                                  const std::string& project,
                                                  const std::string& scene);
// Works as WatchPosteriors, for the sessions.
Status WatchSessions(const DaemonOptions& daemon, const std::string& project,
                     const std::string& scene, const std::function<bool()>& is_stopped,
                     const std::function<void(const v1::WatchSessionsResponse&)>& on_event,
                     const std::function<void(const Status&)>& on_connection);

// Ends a session's stream and, unless `may_return`, also the session. Error: kNotFound.
Status KickSession(const DaemonOptions& daemon, const std::string& session_id, bool may_return);

// Sets the mode of a session's game and, if `arm` is not empty, its arm. Returns the mode and arm
// after the game has followed the order. Errors: kNotFound, kFailedPrecondition (the game does not
// accept orders).
Result<v1::OrderSessionResponse> OrderSession(const DaemonOptions& daemon,
                                              const std::string& session_id, v1::Mode mode,
                                              const std::string& arm);

}  // namespace sweepstake::cli
