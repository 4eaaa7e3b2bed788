// The calls that the commands make to a daemon's services. Thread-safe.
//
// An empty project or scene selects all. Errors: kUnavailable if no daemon answers, and the errors
// that the daemon returns.
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
#include "sweepstake/v1/alerts.pb.h"
#include "sweepstake/v1/audit.pb.h"
#include "sweepstake/v1/posteriors.pb.h"
#include "sweepstake/v1/priors.pb.h"
#include "sweepstake/v1/sessions.pb.h"

namespace sweepstake::cli {

// ---- AuditService ----

// Selects a part of the audit log. An empty field selects everything.
struct AuditSelection {
  std::string session_id;
  std::string project;
  std::string scene;
};

// Lists the segments of the selected sessions.
Result<std::vector<v1::AuditSegment>> ListAudit(const DaemonOptions& daemon,
                                                const AuditSelection& selection);
// Writes the selected part of the audit log to a CSV file and returns the number of rows. After an
// error the file is unchanged. Further errors: kNotFound if nothing is selected, kInvalidArgument
// if the file cannot be written.
Result<uint64_t> ExportAudit(const DaemonOptions& daemon, const AuditSelection& selection,
                             const std::filesystem::path& path);

// ---- PosteriorsService ----

// Returns the posteriors of the selected scenes.
Result<std::vector<v1::ScenePosterior>> ListPosteriors(const DaemonOptions& daemon,
                                                       const std::string& project,
                                                       const std::string& scene);
// Calls `on_event` with each event of the daemon until `is_stopped` returns true. Another thread
// calls `is_stopped` every 50 ms. If the connection is lost, calls `on_connection` with the error
// and reconnects. After that it calls `on_connection` with OK, possibly on the other thread, and
// the events start from the beginning. Returns kUnavailable if the daemon was never reached, or the
// daemon's error if it refuses the call.
Status WatchPosteriors(const DaemonOptions& daemon, const std::string& project,
                       const std::string& scene, const std::function<bool()>& is_stopped,
                       const std::function<void(const v1::WatchPosteriorsResponse&)>& on_event,
                       const std::function<void(const Status&)>& on_connection);

// ---- PriorsService ----

// The records to export: all (also in quarantine), or only the records in quarantine.
enum class Exported : uint8_t { kAll, kQuarantined };

// Returns the selected records of a daemon.
Result<std::vector<PriorRecord>> ExportPriors(const DaemonOptions& daemon,
                                              const std::string& project, const std::string& scene,
                                              Exported what = Exported::kAll);
// Calls `on_record` with each record as it arrives. Records come scene by scene; records in
// quarantine come after all others.
Status StreamPriors(const DaemonOptions& daemon, const std::string& project,
                    const std::string& scene, Exported what,
                    const std::function<void(PriorRecord)>& on_record);

struct ImportCounts {
  uint64_t applied_count = 0;
  uint64_t unchanged_count = 0;
  // Number of unchanged records that the daemon does not have under their project and scene. Their
  // source was revoked, or is stored under another project or scene. Also 0 if the daemon's
  // evidence cannot be read.
  uint64_t absent_count = 0;
};
// Sends the records to the daemon, which adds all of them or, after an error, none. They go into
// quarantine, or count at once if `promote` is true.
Result<ImportCounts> ImportPriors(const DaemonOptions& daemon, std::span<const PriorRecord> records,
                                  bool promote = false);

// Moves evidence of the selected sources out of quarantine, so that it counts. With `preview`, only
// returns what would change.
Result<v1::PromotePriorsResponse> PromotePriors(const DaemonOptions& daemon,
                                                const v1::SourceFilter& sources, bool preview);
// Removes the evidence of the selected sources. With `preview`, only returns what would change.
Result<v1::RevokePriorsResponse> RevokePriors(const DaemonOptions& daemon,
                                              const v1::SourceFilter& sources, bool preview);

// ---- SessionsService ----

// Returns the sessions in a daemon's memory, ordered by id.
Result<std::vector<v1::SessionInfo>> ListSessions(const DaemonOptions& daemon,
                                                  const std::string& project,
                                                  const std::string& scene);
// Works like WatchPosteriors, but for changes of sessions.
Status WatchSessions(const DaemonOptions& daemon, const std::string& project,
                     const std::string& scene, const std::function<bool()>& is_stopped,
                     const std::function<void(const v1::WatchSessionsResponse&)>& on_event,
                     const std::function<void(const Status&)>& on_connection);

// Ends the stream of a session's game. Unless `may_return`, also ends the session, so that the game
// cannot resume it. Error: kNotFound if there is no such session.
Status KickSession(const DaemonOptions& daemon, const std::string& session_id, bool may_return);

// Orders a session's game to change its mode and, if `arm` is not empty, its arm. Returns mode and
// arm after the game has executed the order. Errors: kNotFound (no such session),
// kFailedPrecondition (the game does not accept orders).
Result<v1::OrderSessionResponse> OrderSession(const DaemonOptions& daemon,
                                              const std::string& session_id, v1::Mode mode,
                                              const std::string& arm);

// ---- AlertsService ----

// Returns the most urgent alerts of the project and, if it is empty, of the daemon too.
Result<v1::ListAlertsResponse> ListAlerts(const DaemonOptions& daemon, const std::string& project);

}  // namespace sweepstake::cli
