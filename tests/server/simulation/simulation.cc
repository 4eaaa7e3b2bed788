#include "tests/server/simulation/simulation.h"

#include <algorithm>
#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/storage/sqlite_prior_store.h"
#include "tests/server/simulation/troubled_store.h"

namespace sweepstake::simulation {
namespace {

constexpr int64_t kTroubledNs = 12 * kSecondNs;
// Within this time every game must have said goodbye, including back-off, welcome and retries.
constexpr int64_t kCalmNs = 120 * kSecondNs;

v1::Hello MakeHello(World& world, size_t game) {
  v1::Hello hello;
  hello.set_protocol_version(1);
  hello.set_project(kProjects.at(game % kProjects.size()));
  hello.set_scene(world.Happens(0.5) ? "harbour" : "forest");
  for (const char* name : {"Grid", "SAP", "KDTree", "DBVT"}) {
    if (hello.arms_size() == 3 && world.Happens(0.5)) break;
    v1::Arm& arm = *hello.add_arms();
    arm.set_name(name);
    arm.set_backend_version(1);
  }
  hello.set_mode(v1::MODE_AI);
  hello.set_policy(world.Happens(0.7) ? "paper" : "adaptive");
  hello.set_seed(game + 1);
  hello.set_time_scale(world.Happens(0.8) ? 10 : 1);
  return hello;
}

// Creating a database takes many writes to the real disk, so each run starts with a copy of one.
const std::filesystem::path& NewDatabase() {
  static const test_support::TemporaryDirectory directory;
  static const bool made = storage::OpenSqlitePriorStore(directory.path() / "priors.db").ok();
  if (!made) std::abort();
  return directory.path();
}

}  // namespace

Simulation::Simulation(uint64_t seed)
    : world_(seed),
      disk_(seed),
      files_(world_),
      watcher_({.token_id = INT64_MAX,
                .name = "watcher",
                .role = auth::Role::kWatch,
                .projects = {kProjects.front()}},
               [this](const std::string& what) { Complain(what); }) {
  options_.daemon_version = "simulation";
  options_.max_time_scale = 10;
  options_.resume_secret = std::string(32, 's');
  options_.random_bits = [this] { return world_.Bits(); };
  if (world_.Happens(0.3)) options_.max_sessions = 2;
  if (world_.Happens(0.3)) options_.resume_window_ns = kSecondNs;
  if (world_.Happens(0.6)) options_.tokens = &tokens_;
  if (world_.Happens(0.3)) lost_answer_ratio_ = 0.1;
  for (const char* name : {"priors.db", "store-id"})
    std::filesystem::copy(NewDatabase() / name, directory_.path() / name);
}

std::vector<std::string> Simulation::Run() {
  StartDaemon();
  for (int64_t i = world_.Draw(1, 4); i > 0; --i) AddGame();
  ScheduleTrouble();
  ScheduleVisitor();
  RunFor(kTroubledNs, [] { return false; });
  Calm();
  const auto gone = [this] {
    return std::all_of(games_.begin(), games_.end(), [](const auto& game) { return game->gone(); });
  };
  if (!RunFor(kCalmNs, gone) && problems_.empty()) Complain("a game is stuck");
  // Lets the last evidence of the games reach the disk and the watchers.
  RunFor(4 * kSecondNs, [] { return false; });
  for (const auto& game : games_) {
    tally_.resumed += game->resumed_count();
    tally_.resent += game->resent_count();
    tally_.lost_acknowledgements += game->lost_acknowledgement_count();
  }
  Kill();
  ended_ = true;
  StartDaemon();
  if (daemon_) EndDaemon();
  return problems_;
}

template <typename Done>
bool Simulation::RunFor(int64_t duration_ns, Done done) {
  const int64_t end_ns = world_.NowNs() + duration_ns;
  world_.After(duration_ns, [] {});
  while (world_.NowNs() < end_ns && !done() && problems_.empty()) {
    world_.RunNext();
    AfterEvent();
  }
  return done();
}

void Simulation::AfterEvent() {
  if (disk_.killed()) return Kill();
  if (!daemon_) return;
  daemon_->Run();
  if (!draining_ || !daemon_->drained()) return;
  daemon_->Close();
  EndDaemon();
  ++tally_.drains;
  world_.After(world_.Draw(0, kSecondNs), [this] { StartDaemon(); });
}

void Simulation::AddGame() {
  const size_t game = games_.size();
  const v1::Hello hello = MakeHello(world_, game);
  tokens_of_games_.push_back(NewToken(hello.project()));
  games_.push_back(std::make_unique<SimulatedGame>(
      world_, hello,
      [this, game](ConnectionUser& user) { return Dial(user, tokens_of_games_[game]); },
      [this](const std::string& what) { Complain(what); }));
}

std::string Simulation::NewToken(const std::string& project) {
  const std::string name = absl::StrCat("token ", ++token_count_);
  tokens_.Add(name, auth::Role::kIngest, {project});
  return name;
}

std::shared_ptr<Connection> Simulation::Dial(ConnectionUser& user, const std::string& token) {
  auto connection = std::make_shared<Connection>(world_, user);
  connection->Dial([this, token](Connection& called) {
    if (!daemon_) return called.Refuse(absl::UnavailableError("nobody listens"));
    const auto caller = CallerOf(token);
    if (!caller) return called.Refuse(absl::UnauthenticatedError("this token was revoked"));
    daemon_->Accept(called.shared_from_this(), *caller);
  });
  return connection;
}

std::optional<auth::Principal> Simulation::CallerOf(const std::string& token) const {
  return options_.tokens == nullptr ? auth::Principal{} : tokens_.Find(token + "-token");
}

void Simulation::StartDaemon() {
  if (daemon_) return;
  if (troubled_ && world_.Happens(0.1)) disk_.Set({.read_error = 0.05});
  const std::filesystem::path path = directory_.path() / "priors.db";
  auto store = storage::OpenSqlitePriorStore(path);
  using Reads = absl::StatusOr<std::unique_ptr<storage::ReadConnection>>;
  Reads reads = store.ok() ? storage::OpenSqliteReadConnection(path) : Reads(store.status());
  disk_.Set({});
  if (disk_.killed()) return;  // killed during its start
  if (!reads.ok()) {
    ++tally_.failed_starts;
    if (!troubled_ || !absl::IsUnavailable(reads.status()))
      Complain("the store does not open: " + reads.status().ToString());
    world_.After(kSecondNs, [this] { StartDaemon(); });
    return;
  }
  model_.Settle(**store, [this](const std::string& what) { Complain(what); });
  CheckStore(**store);
  if (!troubled_) CheckAudit(**store);
  if (ended_) {
    CheckFile();
    CheckWatcher(**store);
  }
  watcher_.Forget();
  daemon_ = std::make_shared<SimulatedDaemon>(world_, options_, WithTroubles(*std::move(store)),
                                              *std::move(reads), watcher_);
}

std::unique_ptr<priors::PriorStore> Simulation::WithTroubles(
    std::unique_ptr<priors::PriorStore> store) {
  const auto loses_answer = [this] {
    const bool loses = troubled_ && world_.Happens(lost_answer_ratio_);
    tally_.lost_answers += loses;
    return loses;
  };
  return std::make_unique<TroubledStore>(
      std::move(store), model_,
      TroubledStore::Troubles{.loses_answer = loses_answer,
                              .unix_now_s = [this] { return UnixNowS(); }});
}

uint64_t Simulation::UnixNowS() const {
  return static_cast<uint64_t>(unix_s_ + world_.NowNs() / kSecondNs);
}

void Simulation::EndDaemon() {
  const rpc::Counters& counters = daemon_->counters();
  tally_.commits += counters.stored_commit_count;
  tally_.failed_commits += counters.failed_commit_count;
  tally_.decisions += counters.decision_count;
  tally_.replayed += counters.replayed_message_count;
  tally_.degraded_starts += counters.degraded_start_count;
  daemon_.reset();
  draining_ = false;
}

void Simulation::Kill() {
  disk_.Kill();
  if (daemon_) EndDaemon();
  ++tally_.kills;
  if (world_.Happens(0.5)) {
    ++tally_.power_cuts;
    disk_.RestartAfterPowerCut();
  } else {
    disk_.Restart();
  }
  world_.After(world_.Draw(0, kSecondNs), [this] { StartDaemon(); });
}

void Simulation::ScheduleTrouble() {
  world_.After(world_.Draw(100 * kMsNs, 3 * kSecondNs), [this] {
    if (!troubled_) return;
    if (daemon_) MakeTrouble();
    ScheduleTrouble();
  });
}

void Simulation::MakeTrouble() {
  SimulatedGame& game =
      *games_[static_cast<size_t>(world_.Draw(0, static_cast<int64_t>(games_.size()) - 1))];
  switch (world_.Draw(0, 6)) {
    case 0:
      return disk_.Kill();
    case 1:  // during a commit
      return disk_.KillAfter(static_cast<uint64_t>(world_.Draw(1, 12)));
    case 2:
      return FailDisk();
    case 3:
      return daemon_->set_store_delay_ns(world_.Happens(0.5) ? 8 * kSecondNs : 60 * kMsNs);
    case 4:
      draining_ = true;
      return daemon_->Drain();
    case 5:
      game.Finish();
      return AddGame();
    default:
      game.BreakConnection();
  }
}

void Simulation::FailDisk() {
  const double ratio = world_.Happens(0.5) ? 1 : 0.2;
  switch (world_.Draw(0, 4)) {
    case 0:
      disk_.Set({.read_error = ratio / 10});
      break;
    case 1:
      disk_.Set({.write_error = ratio});
      break;
    case 2:
      disk_.Set({.sync_error = ratio});
      break;
    case 3:
      disk_.Set({.full = true});
      break;
    default:
      disk_.Set({.read_only = true});
  }
  world_.After(world_.Draw(100 * kMsNs, 4 * kSecondNs), [this] {
    if (!disk_.killed()) disk_.Set({});
  });
}

void Simulation::ScheduleVisitor() {
  world_.After(world_.Draw(300 * kMsNs, 4 * kSecondNs), [this] {
    if (!troubled_) return;
    LetVisitorCome();
    ScheduleVisitor();
  });
}

void Simulation::LetVisitorCome() {
  switch (world_.Draw(0, 4)) {
    case 0:
    case 1:
      return ImportFile();
    case 2:
      return RevokeToken();
    case 3:
      return Steal();
    default:
      JumpWallClock();
  }
}

void Simulation::ImportFile() {
  if (!daemon_) return;
  ++tally_.imports;
  const size_t file = files_.Choose();
  daemon_->Import(files_.records(file), [this, file](const absl::Status& status) {
    if (status.ok() && world_.Happens(0.7)) files_.MarkPromised(file);
  });
}

void Simulation::RevokeToken() {
  if (options_.tokens == nullptr) return;
  ++tally_.revoked_tokens;
  const auto game = static_cast<size_t>(world_.Draw(0, static_cast<int64_t>(games_.size()) - 1));
  tokens_.Revoke(tokens_of_games_[game]);
  world_.After(world_.Draw(0, 3 * kSecondNs), [this, game] {
    tokens_of_games_[game] = NewToken(games_[game]->hello().project());
  });
}

void Simulation::Steal() {
  const auto game = static_cast<size_t>(world_.Draw(0, static_cast<int64_t>(games_.size()) - 1));
  std::optional<v1::Hello> stolen = games_[game]->resumption();
  if (!stolen) return;
  ++tally_.thefts;
  if (options_.tokens == nullptr || world_.Happens(0.3)) stolen->clear_resume_token();
  const std::string token = NewToken(stolen->project());
  thieves_.push_back(std::make_unique<Thief>(
      *stolen, [this, token](ConnectionUser& user) { return Dial(user, token); },
      [this](const std::string& what) { Complain(what); }));
}

void Simulation::JumpWallClock() {
  if (lost_answer_ratio_ > 0) return;  // a jump would remove old audit rows
  ++tally_.clock_jumps;
  constexpr int64_t kTenYearsS = 10 * 365 * 86'400;
  unix_s_ += world_.Happens(0.5) ? kTenYearsS : -kTenYearsS;
}

void Simulation::Calm() {
  troubled_ = false;
  disk_.Set({});
  if (daemon_) daemon_->set_store_delay_ns(60 * kMsNs);
  for (const auto& game : games_) game->Finish();
}

}  // namespace sweepstake::simulation
