// Reads the posteriors of a daemon through the PosteriorsService.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "engine_client/cli/daemon/daemon_options.h"
#include "sweepstake/status.h"
#include "sweepstake/v1/posteriors.pb.h"

namespace sweepstake::cli {

// Returns the posteriors of a daemon's scenes. An empty `project` or `scene` selects all. Error:
// kUnavailable (no daemon answered).
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

}  // namespace sweepstake::cli
