// The objects that the services share. The server owns them and outlives every service and stream.
#pragma once

#include "server/rpc/common/access_control.h"
#include "server/sessions/session_table.h"
#include "server/watch/watch_hub.h"

namespace spdlog {
class logger;
}

namespace sweepstake::rpc {

class StallSweep;
class WatcherSet;

struct ServiceContext {
  const RpcOptions& options;
  sessions::DecisionLoop& loop;
  priors::AsyncPriorStore& store;
  Counters& counters;
  watch::WatchHub& watch_hub;
  sessions::SessionTable& sessions;  // used on the loop only
  WatcherSet& watchers;              // used on the loop only
  StallSweep& stalls;                // used on the loop only
  AccessControl& access;
  spdlog::logger& log;
};

}  // namespace sweepstake::rpc
