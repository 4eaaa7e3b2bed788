// The objects that the services share. The server owns them and outlives every service and stream.
#pragma once

#include "server/rpc/common/access_control.h"
#include "server/sessions/game_session.h"

namespace spdlog {
class logger;
}

namespace sweepstake::rpc {

class SessionTable;
class StallSweep;
class WatcherSet;

struct ServiceContext : SessionContext {
  SessionTable& sessions;  // used on the loop only
  WatcherSet& watchers;    // used on the loop only
  StallSweep& stalls;      // used on the loop only
  AccessControl& access;
  spdlog::logger& log;
};

}  // namespace sweepstake::rpc
