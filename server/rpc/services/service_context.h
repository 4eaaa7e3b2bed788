// The objects that the services share. The server owns them and outlives every service and stream.
#pragma once

#include "server/alerts/alert_monitor.h"
#include "server/events/event_bus.h"
#include "server/rpc/common/access_control.h"
#include "server/sessions/admin_log.h"
#include "server/sessions/session_table.h"

namespace spdlog {
class logger;
}

namespace sweepstake::rpc {

class StallSweep;

struct ServiceContext {
  const RpcOptions& options;
  sessions::DecisionLoop& loop;
  priors::AsyncPriorStore& store;
  Counters& counters;
  events::EventBus& events;          // used on the loop only
  sessions::SessionTable& sessions;  // used on the loop only
  StallSweep& stalls;                // used on the loop only
  AccessControl& access;
  spdlog::logger& log;
  sessions::AdminLog& admin;
  alerts::AlertMonitor& alerts;  // used on the loop only
};

}  // namespace sweepstake::rpc
