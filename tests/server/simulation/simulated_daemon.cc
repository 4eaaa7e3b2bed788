#include "tests/server/simulation/simulated_daemon.h"

#include <algorithm>
#include <utility>

namespace sweepstake::simulation {

SimulatedDaemon::SimulatedDaemon(World& world, const rpc::RpcOptions& options,
                                 std::unique_ptr<priors::PriorStore> store,
                                 std::unique_ptr<storage::ReadConnection> reads,
                                 SimulatedWatcher& watcher)
    : world_(world),
      options_(options),
      log_("simulation"),
      loop_(world, {}, sessions::DecisionLoop::Runner::kCaller),
      store_(std::move(store), {.own_thread = false}, std::move(reads)),
      access_(options_, world, log_),
      watcher_(watcher),
      events_(store_, loop_, sessions_, watcher),
      sessions_({options_, loop_, store_, counters_, events_}),
      admin_(options_, loop_, store_, counters_),
      alerts_(options_.alerts, loop_, sessions_),
      context_{options_, loop_,   store_, counters_, events_, sessions_,
               stalls_,  access_, log_,   admin_,    alerts_},
      stalls_(loop_, options_.watcher_patience_ns) {
  EachSecond();
}

SimulatedDaemon::~SimulatedDaemon() {
  watcher_.Leave();
  for (const auto& connection : connections_) connection->Die();
  store_.Close();  // its queue holds jobs of the members that are destroyed before it
}

void SimulatedDaemon::Accept(const std::shared_ptr<Connection>& connection,
                             auth::Principal caller) {
  std::erase_if(connections_, [](const auto& old) { return !old->open(); });
  connections_.push_back(connection);
  connection->Open(context_, streams_, std::move(caller));
}

void SimulatedDaemon::Import(std::vector<priors::PriorRecord> records,
                             std::function<void(const absl::Status&)> done) {
  store_.Submit(
      [this, records = std::move(records), done = std::move(done)](priors::PriorStore& store) {
        loop_.Post([this, done, status = store.Import(records).status()] {
          if (status.ok() || absl::IsUnavailable(status)) events_.Reset();
          done(status);
        });
      });
}

void SimulatedDaemon::EachSecond() {
  if (access_.asks_for_tokens()) streams_.EndRefused();
  if (!draining_ && !watcher_.watching()) {
    watcher_.Forget();
    watcher_.Watch(events_);
  }
  loop_.PostAt(world_.NowNs() + kSecondNs, [this] { EachSecond(); });
}

void SimulatedDaemon::Run() {
  const int64_t due_ns = loop_.RunReady();
  if (due_ns < wake_ns_ || wake_ns_ <= world_.NowNs()) {
    wake_ns_ = due_ns;
    if (due_ns != sessions::LoopClock::kNever) world_.After(due_ns - world_.NowNs(), [] {});
  }
  if (store_.queued_count() > 0) RunLater(store_busy_, &storage::StoreThread::RunNext);
  if (store_.queued_read_count() > 0) RunLater(reads_busy_, &storage::StoreThread::RunNextRead);
}

void SimulatedDaemon::RunLater(bool& busy, bool (storage::StoreThread::*run_next)()) {
  if (std::exchange(busy, true)) return;
  world_.After(world_.Draw(0, max_store_delay_ns_), [weak = weak_from_this(), &busy, run_next] {
    const auto self = weak.lock();
    if (!self) return;
    busy = false;
    (self->store_.*run_next)();
  });
}

void SimulatedDaemon::Drain() {
  draining_ = true;
  loop_.Post([this] {
    streams_.Drain(options_);
    events_.Drain();
    sessions_.RetryCommits();
  });
}

}  // namespace sweepstake::simulation
