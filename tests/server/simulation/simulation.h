// A daemon on a disk that fails, with games on a network that breaks, in virtual time: one run for
// each seed. Games have tokens, which are revoked; others try their sessions; somebody watches a
// project; files of priors are imported; the wall clock jumps. What must hold is checked at every
// start of the daemon and at the end: nothing that was promised is missing, nothing is counted
// twice, nobody is shown another project, a file is imported whole or not at all, the store opens,
// every game comes to its end, and the log's decisions can be derived again.
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
  // `token` is the caller's; without tokens it says nothing.
  std::shared_ptr<Connection> Dial(ConnectionUser& user, const std::string& token);
  std::optional<auth::Principal> CallerOf(const std::string& token) const;
  // Makes a token for a game and returns its name.
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
  // Checks what a caller for one project gets, given all scenes.
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
  std::vector<std::string> tokens_of_games_;  // their names, in the order of games_
  std::vector<std::unique_ptr<Thief>> thieves_;
  PriorFiles files_;
  EvidenceModel model_;
  SimulatedWatcher watcher_;
  double lost_answer_ratio_ = 0;
  int64_t unix_s_ = 1'800'000'000;           // the wall clock when the world began
  std::shared_ptr<SimulatedDaemon> daemon_;  // null while there is none
  bool troubled_ = true;
  bool ended_ = false;
  bool draining_ = false;
  std::vector<std::string> problems_;
  Tally tally_;
};

}  // namespace sweepstake::simulation
