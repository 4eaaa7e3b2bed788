// Reads the posteriors of a daemon through the PosteriorsService.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "sweepstake/status.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

// Returns the scenes that a daemon knows. An empty `project` or `scene` selects all. Error:
// kUnavailable (no daemon answered).
Result<std::vector<v1::ScenePosterior>> ListPosteriors(const DaemonOptions& daemon,
                                                       const std::string& project,
                                                       const std::string& scene);

// Calls `on_event` with each event of the daemon until `is_stopped` returns true, which another
// thread calls every 50 ms. Where the daemon is lost, it tells `on_connection` why and goes on once
// it is back, from the beginning, which it tells with OK, maybe on that other thread. Returns
// kUnavailable if the daemon was never reached, and what a daemon says that refuses.
Status WatchPosteriors(const DaemonOptions& daemon, const std::string& project,
                       const std::string& scene, const std::function<bool()>& is_stopped,
                       const std::function<void(const v1::WatchPosteriorsResponse&)>& on_event,
                       const std::function<void(const Status&)>& on_connection);

}  // namespace sweepstake::cli
