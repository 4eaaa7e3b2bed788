#include "tests/server/simulation/simulated_daemon.h"

#include <algorithm>
#include <utility>

namespace sweepstake::simulation {

SimulatedDaemon::SimulatedDaemon(World& world, const rpc::RpcOptions& options,
                                 std::unique_ptr<priors::PriorStore> store,
                                 std::unique_ptr<storage::ReadConnection> reads,
                                 watch::WatchListener& watcher)
    : world_(world),
      options_(options),
      log_("simulation"),
      loop_(world, {}, sessions::DecisionLoop::Runner::kCaller),
      store_(std::move(store), {.own_thread = false}, std::move(reads)),
      access_(options_, world, log_),
      watch_hub_(store_, rpc::HubLoop(loop_)),
      sessions_({options_, loop_, store_, counters_, watch_hub_}),
      context_{options_,  loop_,     store_,  counters_, watch_hub_,
               sessions_, watchers_, stalls_, access_,   log_},
      watchers_(context_),
      stalls_(loop_, options_.watcher_patience_ns) {
  watch_hub_.Add(watchers_);
  watch_hub_.Add(watcher);
  EndRefused();
}

SimulatedDaemon::~SimulatedDaemon() {
  for (const auto& connection : connections_) connection->Die();
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
          if (status.ok() || absl::IsUnavailable(status)) watch_hub_.Reset();
          done(status);
        });
      });
}

void SimulatedDaemon::EndRefused() {
  if (access_.asks_for_tokens()) streams_.EndRefused();
  loop_.PostAt(world_.NowNs() + kSecondNs, [this] { EndRefused(); });
}

void SimulatedDaemon::Run() {
  const int64_t due_ns = loop_.RunReady();
  if (due_ns < wake_ns_ || wake_ns_ <= world_.NowNs()) {
    wake_ns_ = due_ns;
    if (due_ns != sessions::Clock::kNever) world_.After(due_ns - world_.NowNs(), [] {});
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
    watch_hub_.Drain();
    sessions_.RetryCommits();
  });
}

}  // namespace sweepstake::simulation
