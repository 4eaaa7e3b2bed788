// How many increments of evidence a second one daemon commits into a PostgreSQL of its own on this
// machine, which syncs every commit to the disk.
//
//     postgres_bench [ROWS [GROUP]]
//
// ROWS increments (1,000,000) in commits of GROUP (5,000, as a busy daemon groups them), of 1,000
// sessions that teach ten rows each, of seven arms and their shadow visits, in 20 scenes: the first
// commit of each session adds its rows, the later ones add to them. Prints the rate of each kind,
// and fails where the sums are not what was committed.
#include <algorithm>
#include <chrono>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string>
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

// Returns the seconds that the commits of one round of all sessions take.
double Round(PriorStore& store, uint64_t sequence, uint64_t group_rows) {
  double seconds = 0;
  std::vector<SourceUpdate> group;
  for (uint64_t session = 0; session < kSessions; ++session) {
    group.push_back(UpdateOf(session, sequence));
    if (group.size() * kRowsOfSession < group_rows && session + 1 < kSessions) continue;
    const auto start = std::chrono::steady_clock::now();
    if (const auto status = store.Commit(group); !status.ok()) {
      std::fprintf(stderr, "%s\n", status.ToString().c_str());
      std::exit(1);
    }
    seconds += std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    group.clear();
  }
  return seconds;
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
  const uint64_t rows = argc > 1 ? std::strtoull(argv[1], nullptr, 10) : 1'000'000;
  const uint64_t group =
      argc > 2 ? std::strtoull(argv[2], nullptr, 10) : sweepstake::storage::kSharedGroupRows;
  sweepstake::test_support::PostgresServer server(/*synced=*/true);
  const auto store = sweepstake::storage::OpenPostgresPriorStore(server.NewDatabase());
  if (!store.ok()) {
    std::fprintf(stderr, "%s\n", store.status().ToString().c_str());
    return 1;
  }
  constexpr uint64_t kRoundRows = kSessions * kRowsOfSession;
  const uint64_t rounds = std::max<uint64_t>(2, rows / kRoundRows);
  const double first = Round(**store, 1, group);
  double later = 0;
  for (uint64_t sequence = 2; sequence <= rounds; ++sequence)
    later += Round(**store, sequence, group);
  std::printf("groups of %llu rows: %.0f rows/s of new sessions, %.0f rows/s of known ones\n",
              static_cast<unsigned long long>(group), static_cast<double>(kRoundRows) / first,
              static_cast<double>((rounds - 1) * kRoundRows) / later);
  const uint64_t windows = WindowsIn(**store);
  if (windows == rounds * kRoundRows) return 0;
  std::fprintf(stderr, "the sums have %llu windows\n", static_cast<unsigned long long>(windows));
  return 1;
}
