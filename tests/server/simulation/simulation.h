// A daemon on a disk that fails, with games on a network that breaks, in virtual time: one run for
// each seed. What must hold is checked at every start of the daemon and at the end: nothing that
// was promised is missing, nothing is counted twice, the store opens, every game comes to its end,
// and the log's decisions can be derived again.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/rpc/common/options.h"
#include "tests/server/simulation/simulated_daemon.h"
#include "tests/server/simulation/simulated_game.h"
#include "tests/server/simulation/world.h"
#include "tests/server/storage/failing_disk.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::simulation {

// How often something happened, so that a test can tell that it does.
struct Tally {
  uint64_t kills = 0;
  uint64_t power_cuts = 0;
  uint64_t failed_starts = 0;
  uint64_t drains = 0;
  uint64_t commits = 0;
  uint64_t failed_commits = 0;
  uint64_t decisions = 0;
  uint64_t resumed = 0;
  uint64_t resent = 0;
  uint64_t replayed = 0;
  uint64_t degraded_starts = 0;
  uint64_t derived_decisions = 0;

  Tally& operator+=(const Tally& other);
  std::string Text() const;
};

class Simulation {
 public:
  explicit Simulation(uint64_t seed);

  // Returns what is wrong, in words; nothing if all is as promised.
  std::vector<std::string> Run();
  const Tally& tally() const { return tally_; }

 private:
  // Runs the world until `done` or for so long; returns whether it was done.
  template <typename Done>
  bool RunFor(int64_t duration_ns, Done done);
  void AfterEvent();

  void StartDaemon();
  void EndDaemon();
  void Kill();
  void AddGame();
  std::shared_ptr<Connection> Dial(ConnectionUser& user);

  void ScheduleTrouble();
  void MakeTrouble();
  void FailDisk();
  void DrainAndRestart();
  void Calm();

  void CheckStore(priors::PriorStore& store);
  // Returns the session's evidence.
  priors::Evidence CheckSession(const std::string& id, const SentSession& sent,
                                const SimulatedGame& game, priors::PriorStore& store,
                                std::set<uint64_t>& counted);
  void CheckAudit(priors::PriorStore& store);
  void Complain(const std::string& what) { problems_.push_back(what); }

  World world_;
  test_support::TemporaryDirectory directory_;
  storage::FailingDisk disk_;
  rpc::RpcOptions options_;
  std::vector<std::unique_ptr<SimulatedGame>> games_;
  std::shared_ptr<SimulatedDaemon> daemon_;  // null while there is none
  bool troubled_ = true;
  bool draining_ = false;
  std::vector<std::string> problems_;
  Tally tally_;
};

}  // namespace sweepstake::simulation
