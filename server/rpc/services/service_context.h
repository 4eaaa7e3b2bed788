// The objects that the services share. The server owns them and outlives every service and stream.
#pragma once

#include "server/rpc/sessions/game_session.h"

namespace spdlog {
class logger;
}

namespace sweepstake::rpc {

class SessionTable;
class WatchHub;

struct ServiceContext : SessionContext {
  SessionTable& sessions;  // used on the loop only
  WatchHub& watchers;      // used on the loop only
  spdlog::logger& log;
};

}  // namespace sweepstake::rpc
