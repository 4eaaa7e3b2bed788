// How many increments of evidence a second daemons commit into a PostgreSQL of their own on this
// machine, which syncs every commit to the disk.
//
//     postgres_bench [ROWS [GROUP [DAEMONS]]]
//
// ROWS increments (1,000,000) in commits of GROUP (5,000, as a busy daemon groups them), of 1,000
// sessions that teach ten rows each, of seven arms and their shadow visits, in 20 scenes: the first
// commit of each session adds its rows, the later ones add to them. The sessions are spread over
// DAEMONS (3), each a thread with a connection of its own. Prints the rate of each kind, and fails
// where the sums are not what was committed.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <functional>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/storage/postgres/postgres_prior_store.h"
#include "server/storage/postgres/shared_store.h"
#include "tests/support/postgres/postgres_server.h"

namespace {

using sweepstake::priors::EvidenceKey;
using sweepstake::priors::PriorStore;
using sweepstake::priors::SourceUpdate;

constexpr uint64_t kSessions = 1000;
constexpr uint64_t kRowsOfSession = 10;
constexpr uint64_t kScenes = 20;
constexpr uint64_t kLiveArms = 7;

SourceUpdate UpdateOf(uint64_t session, uint64_t sequence) {
  SourceUpdate update;
  update.progress.source_id = "session " + std::to_string(session);
  update.progress.commit_sequence = sequence;
  update.progress.message_sequence = 10 * sequence;
  for (uint64_t row = 0; row < kRowsOfSession; ++row) {
    const EvidenceKey key{.project = "game",
                          .scene = "scene " + std::to_string(session % kScenes),
                          .measured_by = row < kLiveArms ? "" : "lane",
                          .arm = "arm " + std::to_string(row % kLiveArms),
                          .machine_class = "desktop"};
    update.increments.push_back(
        {key, {.alpha = 0.25, .beta = 0.75, .window_count = 1, .bail_out_count = 0}});
  }
  return update;
}

using Stores = std::vector<std::unique_ptr<PriorStore>>;

struct Rounds {
  uint64_t first = 0;
  uint64_t end = 0;
};

void Check(const absl::Status& status) {
  if (status.ok()) return;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  std::exit(1);
}

// Commits these rounds of every `daemon_count`-th session.
void CommitRounds(PriorStore& store, uint64_t daemon, uint64_t daemon_count, Rounds rounds,
                  uint64_t group_rows) {
  std::vector<SourceUpdate> group;
  for (uint64_t sequence = rounds.first; sequence < rounds.end; ++sequence) {
    for (uint64_t session = daemon; session < kSessions; session += daemon_count) {
      group.push_back(UpdateOf(session, sequence));
      if (group.size() * kRowsOfSession < group_rows && session + daemon_count < kSessions)
        continue;
      Check(store.Commit(group));
      group.clear();
    }
  }
}

// Returns the rows that all daemons commit in a second.
double RowsPerSecond(const Stores& stores, Rounds rounds, uint64_t group_rows) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<std::thread> daemons;
  for (uint64_t daemon = 0; daemon < stores.size(); ++daemon)
    daemons.emplace_back(CommitRounds, std::ref(*stores[daemon]), daemon, stores.size(), rounds,
                         group_rows);
  for (std::thread& daemon : daemons) daemon.join();
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  return static_cast<double>((rounds.end - rounds.first) * kSessions * kRowsOfSession) /
         taken.count();
}

uint64_t WindowsIn(PriorStore& store) {
  uint64_t windows = 0;
  const auto scenes = store.List({}, std::nullopt, kScenes);
  for (const auto& scene : *scenes) {
    for (const auto& arm : scene.arms) windows += arm.live.window_count + arm.lane.window_count;
  }
  return windows;
}

}  // namespace

int main(int argc, char** argv) {
  const auto argument = [&](int i, uint64_t otherwise) {
    return argc > i ? std::strtoull(argv[i], nullptr, 10) : otherwise;
  };
  const uint64_t rows = argument(1, 1'000'000);
  const uint64_t group_rows = argument(2, sweepstake::storage::kSharedGroupRows);
  sweepstake::test_support::PostgresServer server(/*synced=*/true);
  const std::string database = server.NewDatabase();
  Stores stores(std::max<uint64_t>(1, argument(3, 3)));
  for (auto& store : stores) {
    auto opened = sweepstake::storage::OpenPostgresPriorStore(database);
    Check(opened.status());
    store = *std::move(opened);
  }
  const uint64_t rounds = std::max<uint64_t>(2, rows / (kSessions * kRowsOfSession));
  const double first = RowsPerSecond(stores, {1, 2}, group_rows);
  const double later = RowsPerSecond(stores, {2, rounds + 1}, group_rows);
  std::printf(
      "%zu daemons, groups of %llu rows: %.0f rows/s of new sessions, %.0f rows/s of known "
      "ones\n",
      stores.size(), static_cast<unsigned long long>(group_rows), first, later);
  const uint64_t windows = WindowsIn(*stores.front());
  if (windows == rounds * kSessions * kRowsOfSession) return 0;
  std::fprintf(stderr, "the sums have %llu windows\n", static_cast<unsigned long long>(windows));
  return 1;
}
