// Lists, watches, ends and steers the sessions of a daemon through the SessionsService.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "sweepstake/status.h"
#include "sweepstake/v1/sessions.pb.h"

namespace sweepstake::cli {

// Returns the sessions in a daemon's memory, ordered by id. An empty `project` or `scene` selects
// all. Error: kUnavailable (no daemon answered).
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
