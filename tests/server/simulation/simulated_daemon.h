// The daemon's decisions, sessions, streams and store as in RpcServer, but without gRPC and
// threads: its owner runs it after each event of the world. Destroying it simulates `kill -9`:
// unfinished operations stay unfinished.
#pragma once

#include <spdlog/logger.h>

#include <functional>
#include <memory>
#include <vector>

#include "server/events/event_bus.h"
#include "server/rpc/services/service_context.h"
#include "server/rpc/services/stall_sweep.h"
#include "server/rpc/services/telemetry_stream.h"
#include "server/sessions/common/decision_loop.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_table.h"
#include "server/storage/store_thread.h"
#include "tests/server/simulation/connection.h"
#include "tests/server/simulation/simulated_watcher.h"
#include "tests/server/simulation/world.h"

namespace sweepstake::simulation {

class SimulatedDaemon final : public std::enable_shared_from_this<SimulatedDaemon> {
 public:
  SimulatedDaemon(World& world, const rpc::RpcOptions& options,
                  std::unique_ptr<priors::PriorStore> store,
                  std::unique_ptr<storage::ReadConnection> reads, SimulatedWatcher& watcher);
  // REQUIRES: the disk is dead, or the daemon is closed.
  ~SimulatedDaemon();

  void Accept(const std::shared_ptr<Connection>& connection, auth::Principal caller);
  // Imports like PriorsService. `done` is not called if the daemon dies before.
  void Import(std::vector<priors::PriorRecord> records,
              std::function<void(const absl::Status&)> done);
  // Runs all work that is due, and schedules the next run in the world.
  void Run();
  // Requests the games to reconnect later, as after SIGTERM.
  void Drain();
  bool drained() const { return streams_.all.empty() && !sessions_.committing(); }
  // Commits everything that is queued.
  void Close() { store_.Close(); }

  // Sets the maximum delay before the store starts a commit, a job or a read.
  void set_store_delay_ns(int64_t max) { max_store_delay_ns_ = max; }
  const rpc::Counters& counters() const { return counters_; }

 private:
  // Runs the next queued item of the store after some time.
  void RunLater(bool& busy, bool (storage::StoreThread::*run_next)());
  // Ends the streams of invalid tokens. Restarts the watcher if it ended because the store could
  // not be read.
  void EachSecond();

  World& world_;
  const rpc::RpcOptions options_;
  rpc::Counters counters_;
  spdlog::logger log_;
  bool draining_ = false;
  sessions::DecisionLoop loop_;
  storage::StoreThread store_;
  rpc::AccessControl access_;
  SimulatedWatcher& watcher_;
  events::EventBus events_;
  sessions::SessionTable sessions_;
  sessions::AdminLog admin_;
  alerts::AlertMonitor alerts_;
  rpc::ServiceContext context_;  // also refers to members below
  rpc::StallSweep stalls_;
  rpc::TelemetryStreams streams_;
  std::vector<std::shared_ptr<Connection>> connections_;
  int64_t max_store_delay_ns_ = 60 * kMsNs;
  bool store_busy_ = false;
  bool reads_busy_ = false;
  // The world runs the daemon again at this time or earlier.
  int64_t wake_ns_ = sessions::LoopClock::kNever;
};

}  // namespace sweepstake::simulation
