#include "tests/server/simulation/simulation.h"

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <utility>

#include "absl/strings/str_cat.h"
#include "server/audit/audit_log.h"
#include "server/audit/rederive.h"
#include "server/storage/sqlite_prior_store.h"

namespace sweepstake::simulation {
namespace {

constexpr int64_t kTroubledNs = 15 * kSecondNs;
// By then every game has said goodbye: back-off, welcome and retries included.
constexpr int64_t kCalmNs = 120 * kSecondNs;

v1::Hello MakeHello(World& world, size_t game) {
  v1::Hello hello;
  hello.set_protocol_version(1);
  hello.set_project("simulation");
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

// A new database takes many writes to the real disk, so that all runs begin with a copy of one.
const std::filesystem::path& NewDatabase() {
  static const test_support::TemporaryDirectory directory;
  static const bool made = storage::OpenSqlitePriorStore(directory.path() / "priors.db").ok();
  if (!made) std::abort();
  return directory.path();
}

}  // namespace

Tally& Tally::operator+=(const Tally& other) {
  kills += other.kills;
  power_cuts += other.power_cuts;
  failed_starts += other.failed_starts;
  drains += other.drains;
  commits += other.commits;
  failed_commits += other.failed_commits;
  decisions += other.decisions;
  resumed += other.resumed;
  resent += other.resent;
  replayed += other.replayed;
  degraded_starts += other.degraded_starts;
  derived_decisions += other.derived_decisions;
  return *this;
}

std::string Tally::Text() const {
  return absl::StrCat(kills, " kills, ", power_cuts, " of them power cuts; ", failed_starts,
                      " failed starts, ", drains, " drains; ", commits, " commits, ",
                      failed_commits, " failed; ", resumed, " sessions resumed, ", degraded_starts,
                      " begun without their evidence; ", resent, " messages sent again, ", replayed,
                      " of them known; ", decisions, " decisions, ", derived_decisions,
                      " derived again");
}

Simulation::Simulation(uint64_t seed) : world_(seed), disk_(seed) {
  options_.daemon_version = "simulation";
  options_.max_time_scale = 10;
  options_.resume_secret = std::string(32, 's');
  options_.random_bits = [this] { return world_.Bits(); };
  if (world_.Happens(0.3)) options_.max_sessions = 2;
  if (world_.Happens(0.3)) options_.resume_window_ns = kSecondNs;
  for (const char* name : {"priors.db", "store-id"})
    std::filesystem::copy(NewDatabase() / name, directory_.path() / name);
}

std::vector<std::string> Simulation::Run() {
  StartDaemon();
  for (int64_t i = world_.Draw(1, 4); i > 0; --i) AddGame();
  ScheduleTrouble();
  RunFor(kTroubledNs, [] { return false; });
  Calm();
  const auto gone = [this] {
    return std::all_of(games_.begin(), games_.end(), [](const auto& game) { return game->gone(); });
  };
  if (!RunFor(kCalmNs, gone) && problems_.empty()) Complain("a game is stuck");
  for (const auto& game : games_) {
    tally_.resumed += game->resumed_count();
    tally_.resent += game->resent_count();
  }
  Kill();
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
  games_.push_back(std::make_unique<SimulatedGame>(
      world_, MakeHello(world_, games_.size()), [this](ConnectionUser& user) { return Dial(user); },
      [this](const std::string& what) { Complain(what); }));
}

std::shared_ptr<Connection> Simulation::Dial(ConnectionUser& user) {
  auto connection = std::make_shared<Connection>(world_, user);
  connection->Dial([this](Connection& called) {
    if (!daemon_) return called.Refuse();
    daemon_->Accept(called.shared_from_this());
  });
  return connection;
}

void Simulation::StartDaemon() {
  if (daemon_) return;
  if (troubled_ && world_.Happens(0.1)) disk_.Set({.read_error = 0.05});
  auto store = storage::OpenSqlitePriorStore(directory_.path() / "priors.db");
  disk_.Set({});
  if (disk_.killed()) return;  // in the midst of its start
  if (!store.ok()) {
    ++tally_.failed_starts;
    if (!troubled_ || !absl::IsUnavailable(store.status()))
      Complain("the store does not open: " + store.status().ToString());
    world_.After(kSecondNs, [this] { StartDaemon(); });
    return;
  }
  CheckStore(**store);
  if (!troubled_) CheckAudit(**store);
  daemon_ = std::make_shared<SimulatedDaemon>(world_, options_, *std::move(store));
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
    case 1:  // in the midst of a commit
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

void Simulation::Calm() {
  troubled_ = false;
  disk_.Set({});
  if (daemon_) daemon_->set_store_delay_ns(60 * kMsNs);
  for (const auto& game : games_) game->Finish();
}

void Simulation::CheckStore(priors::PriorStore& store) {
  priors::Evidence of_sessions;
  for (const auto& game : games_) {
    std::set<uint64_t> counted;
    for (const auto& [id, sent] : game->sessions())
      of_sessions += CheckSession(id, sent, *game, store, counted);
  }
  const auto scenes = store.List({}, {}, 1000);
  if (!scenes.ok()) return Complain("the scenes cannot be read: " + scenes.status().ToString());
  priors::Evidence of_scenes;
  for (const priors::SceneEvidence& scene : *scenes) {
    for (const auto& arm : scene.arms) of_scenes += arm.evidence;
  }
  if (of_scenes.window_count != of_sessions.window_count ||
      of_scenes.bail_out_count != of_sessions.bail_out_count)
    Complain("the scenes have not what the sessions have");
}

priors::Evidence Simulation::CheckSession(const std::string& id, const SentSession& sent,
                                          const SimulatedGame& game, priors::PriorStore& store,
                                          std::set<uint64_t>& counted) {
  priors::Evidence total;
  const auto source = store.LoadSource(id);
  if (!source.ok()) {
    Complain("a session cannot be read: " + source.status().ToString());
    return total;
  }
  const priors::SourceProgress progress =
      source->has_value() ? (*source)->progress : priors::SourceProgress{};
  if (progress.message_sequence < sent.promised_sequence) {
    Complain(absl::StrCat("session ", id, " has lost evidence: ", sent.promised_sequence,
                          " was promised, on disk is ", progress.message_sequence));
  }
  if (progress.message_sequence > sent.messages.size()) {
    Complain("the store has messages that nobody has sent");
    return total;
  }
  uint64_t frames = 0;
  uint64_t bail_outs = 0;
  for (size_t i = 0; i < progress.message_sequence; ++i) {
    const SentMessage& message = sent.messages[i];
    frames += message.frame_count;
    bail_outs += message.bail_out_count;
    if (message.first_frame != 0 && !counted.insert(message.first_frame).second)
      Complain(absl::StrCat("frame ", message.first_frame, " counts for two sessions"));
  }
  if (source->has_value()) {
    for (const auto& entry : (*source)->evidence) total += entry.evidence;
  }
  if (progress.frame_count != frames || total.bail_out_count != bail_outs) {
    Complain(absl::StrCat("session ", id, " (", game.hello().policy(), ") of ",
                          progress.message_sequence, " messages has ", progress.frame_count,
                          " frames for ", frames, " and ", total.bail_out_count, " bail-outs for ",
                          bail_outs));
  }
  const auto observations = static_cast<double>(total.window_count + 10 * total.bail_out_count);
  if (game.hello().policy() == "paper" && std::abs(total.alpha + total.beta - observations) > 1e-6)
    Complain(absl::StrCat("session ", id, " has other evidence than its windows and bail-outs"));
  return total;
}

void Simulation::CheckAudit(priors::PriorStore& store) {
  const auto segments = store.ListAudit({}, 0, 10'000);
  if (!segments.ok()) return Complain("no audit log: " + segments.status().ToString());
  std::string csv = decision::AuditHeader() + "\n";
  for (const priors::AuditSegment& segment : *segments) {
    const auto rows = store.LoadAudit(segment.id, 1, 1'000'000, size_t{1} << 30);
    if (!rows.ok()) return Complain("no audit rows: " + rows.status().ToString());
    uint64_t next = 1;
    for (const priors::AuditRow& row : *rows) {
      // As the audit service marks rows that the disk has refused.
      if (row.number != next)
        csv += decision::MissingRow(segment.session_id, segment.segment, next) + "\n";
      next = row.number + 1;
      csv += row.text + "\n";
    }
  }
  const decision::AuditReport report = decision::Rederive(csv);
  if (report.difference) Complain("a decision differs: " + report.difference->Text());
  tally_.derived_decisions = report.decision_count;
}

}  // namespace sweepstake::simulation
