// Simulates a daemon on a failing disk and games on a failing network in virtual time, one run per
// seed. Games have tokens, which are revoked. Thieves try to resume the games' sessions. A watcher
// watches a project. Files of priors are imported. The wall clock jumps.
//
// The invariants are checked at every start of the daemon and at the end. No acknowledged evidence
// is missing, and none counts twice. No caller sees another project. A file is imported completely
// or not at all. The store opens, every game finishes, and the decisions can be replayed from the
// audit log.
#pragma once

#include <cstdint>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <vector>

#include "server/rpc/common/options.h"
#include "tests/server/rpc/common/scripted_tokens.h"
#include "tests/server/simulation/evidence_model.h"
#include "tests/server/simulation/prior_files.h"
#include "tests/server/simulation/simulated_daemon.h"
#include "tests/server/simulation/simulated_game.h"
#include "tests/server/simulation/simulated_watcher.h"
#include "tests/server/simulation/tally.h"
#include "tests/server/simulation/thief.h"
#include "tests/server/simulation/world.h"
#include "tests/server/storage/failing_disk.h"
#include "tests/support/temporary_directory.h"

namespace sweepstake::simulation {

class Simulation {
 public:
  explicit Simulation(uint64_t seed);

  // Performs the run. Returns descriptions of all violations; empty if there are none.
  std::vector<std::string> Run();
  const Tally& tally() const { return tally_; }

 private:
  // Runs the world until `done` returns true or `duration_ns` has passed. Returns whether `done`
  // returned true.
  template <typename Done>
  bool RunFor(int64_t duration_ns, Done done);
  void AfterEvent();

  void StartDaemon();
  void EndDaemon();
  void Kill();
  void AddGame();
  // `token` is the caller's; it is ignored if there are no tokens.
  std::shared_ptr<Connection> Dial(ConnectionUser& user, const std::string& token);
  std::optional<auth::Principal> CallerOf(const std::string& token) const;
  // Creates a token for a game and returns its name.
  std::string NewToken(const std::string& project);

  void ScheduleTrouble();
  void MakeTrouble();
  void FailDisk();
  void ScheduleVisitor();
  void LetVisitorCome();
  void ImportFile();
  void RevokeToken();
  void Steal();
  void JumpWallClock();
  void Calm();

  std::unique_ptr<priors::PriorStore> WithTroubles(std::unique_ptr<priors::PriorStore> store);
  uint64_t UnixNowS() const;
  void CheckFile();
  void CheckStore(priors::PriorStore& store);
  // Checks what a caller for one project receives, given all scenes.
  void CheckProject(priors::PriorStore& store, const std::vector<priors::SceneEvidence>& all);
  void CheckWatcher(priors::PriorStore& store);
  void CheckSession(const std::string& id, const SentSession& sent, const SimulatedGame& game,
                    priors::PriorStore& store, std::set<uint64_t>& counted);
  void CheckAudit(priors::PriorStore& store);
  void Complain(const std::string& what) { problems_.push_back(what); }

  World world_;
  test_support::TemporaryDirectory directory_;
  storage::FailingDisk disk_;
  rpc::RpcOptions options_;
  rpc::ScriptedTokens tokens_;
  std::vector<std::unique_ptr<SimulatedGame>> games_;
  uint64_t token_count_ = 0;
  std::vector<std::string> tokens_of_games_;  // names, in the order of games_
  std::vector<std::unique_ptr<Thief>> thieves_;
  PriorFiles files_;
  EvidenceModel model_;
  SimulatedWatcher watcher_;
  double lost_answer_ratio_ = 0;
  int64_t unix_s_ = 1'800'000'000;           // wall-clock time at the start of the world
  std::shared_ptr<SimulatedDaemon> daemon_;  // null while no daemon runs
  bool troubled_ = true;
  bool ended_ = false;
  bool draining_ = false;
  std::vector<std::string> problems_;
  Tally tally_;
};

}  // namespace sweepstake::simulation
