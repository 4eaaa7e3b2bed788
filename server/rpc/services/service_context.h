// What the services share. References to objects of the server, which outlives every service and
// stream.
#pragma once

#include "server/rpc/sessions/game_session.h"

namespace spdlog {
class logger;
}

namespace sweepstake::rpc {

class SessionTable;
class WatchHub;

struct ServiceContext : SessionContext {
  SessionTable& sessions;  // on the loop only
  WatchHub& watchers;      // on the loop only
  spdlog::logger& log;
};

}  // namespace sweepstake::rpc
