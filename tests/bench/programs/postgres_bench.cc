// Measures how many increments of evidence per second daemons commit to their own PostgreSQL on
// this machine, which syncs every commit to the disk.
//
//     postgres_bench [ROWS [GROUP [DAEMONS]]]
//
// Commits ROWS increments (1,000,000) in groups of GROUP (5,000, as a busy daemon does; at most
// 10,000) by DAEMONS (3), each a thread with its own connection. Each daemon has 1,000 sessions
// with ten rows each (seven arms and their shadow visits), in 20 scenes that all daemons share. The
// first commit of each session adds its rows, later commits update them. Prints the rate of each
// kind, and fails if the sums differ from what was committed.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
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

constexpr uint64_t kSessionsOfDaemon = 1000;
constexpr uint64_t kRowsOfSession = 10;
constexpr uint64_t kRoundRows = kSessionsOfDaemon * kRowsOfSession;
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

// Commits these rounds of a daemon's sessions.
absl::Status CommitRounds(PriorStore& store, uint64_t daemon, Rounds rounds, uint64_t group_rows) {
  std::vector<SourceUpdate> group;
  for (uint64_t sequence = rounds.first; sequence < rounds.end; ++sequence) {
    for (uint64_t session = 0; session < kSessionsOfDaemon; ++session) {
      group.push_back(UpdateOf(daemon * kSessionsOfDaemon + session, sequence));
      if (group.size() * kRowsOfSession < group_rows && session + 1 < kSessionsOfDaemon) continue;
      if (absl::Status status = store.Commit(group); !status.ok()) return status;
      group.clear();
    }
  }
  return absl::OkStatus();
}

// Returns the rows that all daemons together commit per second.
absl::StatusOr<double> RowsPerSecond(const Stores& stores, Rounds rounds, uint64_t group_rows) {
  const auto start = std::chrono::steady_clock::now();
  std::vector<absl::Status> ends(stores.size());
  std::vector<std::thread> daemons;
  for (uint64_t daemon = 0; daemon < stores.size(); ++daemon)
    daemons.emplace_back(
        [&, daemon] { ends[daemon] = CommitRounds(*stores[daemon], daemon, rounds, group_rows); });
  for (std::thread& daemon : daemons) daemon.join();
  const std::chrono::duration<double> taken = std::chrono::steady_clock::now() - start;
  for (const absl::Status& end : ends) {
    if (!end.ok()) return end;
  }
  return static_cast<double>((rounds.end - rounds.first) * stores.size() * kRoundRows) /
         taken.count();
}

absl::StatusOr<uint64_t> WindowsIn(PriorStore& store) {
  uint64_t windows = 0;
  const auto scenes = store.List({}, std::nullopt, kScenes);
  if (!scenes.ok()) return scenes.status();
  for (const auto& scene : *scenes) {
    for (const auto& arm : scene.arms) windows += arm.live.window_count + arm.lane.window_count;
  }
  return windows;
}

absl::Status Measure(const std::string& database, uint64_t rows, uint64_t group_rows,
                     uint64_t daemon_count) {
  Stores stores;
  while (stores.size() < daemon_count) {
    auto opened = sweepstake::storage::OpenPostgresPriorStore(database);
    if (!opened.ok()) return opened.status();
    stores.push_back(*std::move(opened));
  }
  const uint64_t rounds = std::max<uint64_t>(2, rows / (kRoundRows * daemon_count));
  const auto first = RowsPerSecond(stores, {1, 2}, group_rows);
  if (!first.ok()) return first.status();
  const auto later = RowsPerSecond(stores, {2, rounds + 1}, group_rows);
  if (!later.ok()) return later.status();
  std::printf(
      "%llu daemons, groups of %llu rows: %.0f rows/s of new sessions, %.0f rows/s of "
      "known ones\n",
      static_cast<unsigned long long>(daemon_count), static_cast<unsigned long long>(group_rows),
      *first, *later);
  const auto windows = WindowsIn(*stores.front());
  if (!windows.ok()) return windows.status();
  if (*windows == rounds * kRoundRows * daemon_count) return absl::OkStatus();
  return absl::InternalError("the sums have " + std::to_string(*windows) + " windows");
}

}  // namespace

int main(int argc, char** argv) {
  const auto argument = [&](int i, uint64_t otherwise) {
    return argc > i ? std::strtoull(argv[i], nullptr, 10) : otherwise;
  };
  const uint64_t group_rows = argument(2, sweepstake::storage::kSharedGroupRows);
  sweepstake::test_support::PostgresServer server(/*synced=*/true);
  const absl::Status status =
      Measure(server.NewDatabase(), argument(1, 1'000'000), std::min(group_rows, kRoundRows),
              std::max<uint64_t>(1, argument(3, 3)));
  if (status.ok()) return 0;
  std::fprintf(stderr, "%s\n", status.ToString().c_str());
  return 1;
}
