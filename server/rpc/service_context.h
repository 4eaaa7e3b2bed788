// What the services share. References to objects of the server, which outlives every service,
// stream and session.
#pragma once

#include <memory>

#include "server/priors/prior_store.h"
#include "server/rpc/counters.h"
#include "server/rpc/decision_loop.h"
#include "server/rpc/options.h"

namespace spdlog {
class logger;
}

namespace sweepstake::rpc {

class SessionTable;
class WatchHub;

struct ServiceContext {
  const RpcOptions& options;
  DecisionLoop& loop;
  priors::AsyncPriorStore& store;
  Counters& counters;
  SessionTable& sessions;  // on the loop only
  WatchHub& watchers;      // on the loop only
  spdlog::logger& log;
};

}  // namespace sweepstake::rpc
