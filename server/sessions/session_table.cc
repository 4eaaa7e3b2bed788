#include "server/sessions/session_table.h"

#include <algorithm>
#include <iterator>
#include <utility>
#include <vector>

#include "absl/strings/str_cat.h"
#include "server/sessions/common/reasons.h"
#include "server/sessions/common/unix_time.h"

namespace sweepstake::sessions {
namespace {

constexpr int64_t kSweepIntervalNs = 2'000'000'000;
// No session switches more often in a minute, if its scene is not changing.
constexpr uint32_t kMaxCalmSwitches = 4;
// Only so many sessions of a scene are examined, since each event of the scene does this.
constexpr size_t kMaxSessionsOfVerdict = 16;

size_t PlacesOf(const GameSession& session) {
  return (session.identity().arms.size() + SessionTable::kArmsPerPlace - 1) /
         SessionTable::kArmsPerPlace;
}

}  // namespace

std::shared_ptr<GameSession> SessionTable::Find(const std::string& id) const {
  const auto found = entries_.find(id);
  return found == entries_.end() ? nullptr : found->second.session;
}

absl::Status SessionTable::Add(std::shared_ptr<GameSession> session) {
  const Owner owner = session->identity().origin.owner();
  const size_t places = PlacesOf(*session);
  const auto found = owner_places_.find(owner);
  const size_t held = found == owner_places_.end() ? 0 : found->second;
  const size_t max_of_owner = context_.options.max_sessions_per_party;
  if (owner != Owner() && held + places > max_of_owner &&
      !MakeRoom(owner, held + places - max_of_owner)) {
    return Refused(
        reasons::kTooManySessions,
        absl::StrCat("this player, network or token has ", held, " of ", max_of_owner,
                     " sessions (max_sessions_per_party; one counts once per ", kArmsPerPlace,
                     " arms); end some, or raise the limit on the daemon"));
  }
  const size_t max = context_.options.max_sessions;
  if (place_count_ + places > max && !MakeRoom(std::nullopt, place_count_ + places - max)) {
    return Refused(reasons::kTooManySessions,
                   "this daemon has the maximum number of sessions (max_sessions); try again "
                   "later, or use another daemon");
  }
  place_count_ += places;
  owner_places_[owner] += places;
  std::string id = session->identity().id;
  entries_[std::move(id)].session = std::move(session);
  return absl::OkStatus();
}

bool SessionTable::MakeRoom(const std::optional<Owner>& owner, size_t places) {
  std::vector<std::string> leaving;
  size_t freed = 0;
  for (std::string& id : leaving_.First(owner, places)) {  // each has at least one place
    const GameSession& session = *entries_.at(id).session;
    if (freed >= places || (session.ended() && !session.settled())) break;
    freed += PlacesOf(session);
    leaving.push_back(std::move(id));
  }
  if (freed < places) return false;
  for (const std::string& id : leaving) {
    entries_.at(id)
        .session->KeepOpenEvidence();  // the store may write it after the session has left
    Remove(id);
  }
  return true;
}

void SessionTable::Attach(GameSession& session, ClientStream& link, SessionClient client) {
  Entry& entry = entries_.at(session.identity().id);
  if (entry.link == nullptr) connected_[session.identity().scene].push_back(&session);
  if (entry.lost) Recover(entry);
  entry.link = &link;
  entry.client = std::move(client);
  session.Attach(link);
}

void SessionTable::Detach(GameSession& session, ClientStream& link) {
  const auto found = entries_.find(session.identity().id);
  if (found == entries_.end() || found->second.link != &link) return;
  found->second.link = nullptr;
  Disconnect(session);
  session.Detach(link);
  if ((session.ended() || session.superseded()) && session.settled()) {
    Remove(std::string(found->first));
  } else {
    Lose(found->second);
  }
}

void SessionTable::Disconnect(const GameSession& session) {
  const auto found = connected_.find(session.identity().scene);
  if (found == connected_.end()) return;
  std::erase(found->second, &session);
  if (found->second.empty()) connected_.erase(found);
}

void SessionTable::Kick(GameSession& session, bool may_return) {
  // Keeps the session alive, because ending its stream may remove it from the table.
  const std::shared_ptr<GameSession> kept = session.shared_from_this();
  if (!may_return) RememberKick(session.identity().id);
  session.Kick(may_return);
  const auto found = entries_.find(session.identity().id);
  // Check a lost session now. Otherwise it would stay until the end of its resume window.
  if (!may_return && found != entries_.end() && found->second.lost) LookAt(kept->identity().id);
}

void SessionTable::Forget(const GameSession& session) {
  Remove(std::string(session.identity().id));
}

void SessionTable::RememberKick(const std::string& id) {
  if (!kicked_.insert(id).second) return;
  kicks_.push_back(id);
  if (kicks_.size() <= kMaxKicked) return;
  kicked_.erase(kicks_.front());
  kicks_.pop_front();
}

absl::Status SessionTable::CheckKicked(const std::string& id) const {
  return kicked_.contains(id) ? SessionKicked() : absl::OkStatus();
}

std::optional<SessionView> SessionTable::Describe(const std::string& id) const {
  const auto found = entries_.find(id);
  if (found == entries_.end()) return std::nullopt;
  return ViewOf(found->second);
}

std::vector<SessionView> SessionTable::List(const priors::SceneFilter& filter,
                                            const std::string& after, size_t limit) const {
  std::vector<SessionView> sessions;
  for (auto next = entries_.upper_bound(after); next != entries_.end() && sessions.size() < limit;
       ++next) {
    const priors::SceneKey& scene = next->second.session->identity().scene;
    if (filter.Matches(scene.project, scene.scene)) sessions.push_back(ViewOf(next->second));
  }
  return sessions;
}

std::string SessionTable::Visit(
    const std::string& after, size_t limit,
    const std::function<void(const GameSession&, SessionState)>& use) const {
  auto next = entries_.upper_bound(after);
  for (size_t count = 0; next != entries_.end() && count < limit; ++next, ++count)
    use(*next->second.session, StateOf(next->second));
  return next == entries_.end() ? std::string() : std::prev(next)->first;
}

SessionState SessionTable::StateOf(const Entry& entry) {
  if (entry.session->ended()) return SessionState::kEnding;
  return entry.link != nullptr ? SessionState::kConnected : SessionState::kLost;
}

SessionView SessionTable::ViewOf(const Entry& entry) const {
  const GameSession& session = *entry.session;
  const decision::DecisionSession& decisions = session.decisions();
  SessionView view;
  view.id = session.identity().id;
  view.scene = session.identity().scene;
  view.client = entry.client;
  view.state = StateOf(entry);
  view.active_arm = session.identity().arms[decisions.active_arm()];
  view.initial_arm = session.identity().arms[decisions.initial_arm()];
  view.mode = decisions.mode();
  view.unix_start_ms = UnixMsOf(decisions.setup().start_ns);
  if (session.last_message_ns()) view.unix_last_message_ms = UnixMsOf(*session.last_message_ns());
  view.dropped_frame_count = session.dropped_frame_count();
  view.takes_orders = session.takes_orders();
  view.shows_boxes = session.shows_boxes();
  return view;
}

void SessionTable::Lose(Entry& entry) {
  const int64_t now_ns = context_.loop.clock().NowNs();
  entry.resumable_until_ns = now_ns + context_.options.resume_window_ns;
  entry.session->PublishChange();
  entry.rank.number = ++last_lost_number_;
  LookAgainAt(entry.session->settled() ? entry.resumable_until_ns : now_ns + kSweepIntervalNs,
              entry);
  ScheduleSweep();
}

void SessionTable::Recover(Entry& entry) {
  lost_.erase(*std::exchange(entry.lost, std::nullopt));
  leaving_.Remove(entry.session->identity().origin.owner(), entry.rank);
}

void SessionTable::LookAgainAt(int64_t due_ns, Entry& entry) {
  const SessionIdentity& identity = entry.session->identity();
  entry.lost = LostKey{due_ns, entry.rank.number};
  lost_.emplace(*entry.lost, identity.id);
  entry.rank.state = entry.session->settled() ? LostState::kSettled
                     : entry.session->ended() ? LostState::kEnding
                                              : LostState::kUnsettled;
  leaving_.Add(identity.origin.owner(), entry.rank, identity.id);
}

void SessionTable::ScheduleSweep() {
  if (sweep_scheduled_ || lost_.empty()) return;
  sweep_scheduled_ = true;
  context_.loop.PostAt(context_.loop.clock().NowNs() + kSweepIntervalNs, [this] {
    sweep_scheduled_ = false;
    Sweep();
  });
}

void SessionTable::Sweep() {
  const int64_t now_ns = context_.loop.clock().NowNs();
  std::vector<std::string> due;
  for (const auto& [key, id] : lost_) {
    if (key.first > now_ns) break;
    due.push_back(id);
  }
  for (const std::string& id : due) LookAt(id);
  ScheduleSweep();
}

void SessionTable::LookAt(const std::string& id) {
  Entry& entry = entries_.at(id);
  const int64_t now_ns = context_.loop.clock().NowNs();
  const bool over = now_ns >= entry.resumable_until_ns;
  if (over) entry.session->KeepOpenEvidence();
  const bool settled = entry.session->settled();
  if (settled && (entry.session->ended() || entry.session->superseded() || over)) return Remove(id);
  Recover(entry);
  LookAgainAt(settled ? entry.resumable_until_ns : now_ns + kSweepIntervalNs, entry);
  // The store could not write the evidence, which is only in memory: offer it again.
  if (!settled) entry.session->RetryCommit();
}

void SessionTable::Remove(const std::string& id) {
  const auto found = entries_.find(id);
  if (found->second.lost) Recover(found->second);
  Disconnect(*found->second.session);
  const size_t places = PlacesOf(*found->second.session);
  const auto of_owner = owner_places_.find(found->second.session->identity().origin.owner());
  if ((of_owner->second -= places) == 0) owner_places_.erase(of_owner);
  place_count_ -= places;
  found->second.session->PublishEnd();
  entries_.erase(found);
}

void SessionTable::RetryCommits() {
  for (const auto& [id, entry] : entries_) {
    if (entry.lost) entry.session->KeepOpenEvidence();
    if (!entry.session->settled()) entry.session->RetryCommit();
  }
}

bool SessionTable::committing() const {
  return std::any_of(entries_.begin(), entries_.end(),
                     [](const auto& entry) { return entry.second.session->committing(); });
}

HeldEvidence SessionTable::CountHeld() const {
  HeldEvidence held;
  for (const auto& [id, entry] : entries_) {
    if (entry.session->settled()) continue;
    ++held.session_count;
    if (entry.session->ended()) ++held.ended_session_count;
  }
  return held;
}

std::vector<priors::SourceUpdate> SessionTable::Waiting() const {
  std::vector<priors::SourceUpdate> updates;
  for (const auto& [id, entry] : entries_) entry.session->AppendWaiting(updates);
  return updates;
}

// Converts a time of the loop's clock.
int64_t SessionTable::UnixMsOf(int64_t time_ns) const {
  return (priors::UnixNowNs() - (context_.loop.clock().NowNs() - time_ns)) / 1'000'000;
}

const GameSession* SessionTable::FirstOf(const priors::SceneKey& scene) const {
  const auto found = connected_.find(scene);
  return found == connected_.end() ? nullptr : found->second.front();
}

SceneRun SessionTable::RunOf(const priors::SceneKey& scene) const {
  const GameSession* first = FirstOf(scene);
  if (first == nullptr) return {};
  const SessionIdentity& identity = first->identity();
  return {.session_count = static_cast<uint32_t>(connected_.at(scene).size()),
          .session_id = identity.id,
          .active_arm = identity.arms[first->decisions().active_arm()]};
}

bool SessionTable::SwitchesOften(const priors::SceneKey& scene) const {
  const std::vector<const GameSession*>& sessions = connected_.at(scene);
  const int64_t now_ns = context_.loop.clock().NowNs();
  return std::any_of(
      sessions.begin(),
      sessions.begin() + static_cast<ptrdiff_t>(std::min(sessions.size(), kMaxSessionsOfVerdict)),
      [&](const GameSession* session) {
        const decision::DecisionSession& decisions = session->decisions();
        return decisions.diagnosis().verdict == Verdict::kStable &&
               decisions.RecentSwitchCount(now_ns) > kMaxCalmSwitches;
      });
}

SceneActivity SessionTable::ActivityOf(const priors::SceneKey& scene) const {
  const GameSession* first = FirstOf(scene);
  if (first == nullptr) return {};
  const decision::DecisionSession& decisions = first->decisions();
  decision::SceneReport report = decisions.Report();
  const bool is_changing = decision::BestArmsDiffer(report) || SwitchesOften(scene);
  return {.run = RunOf(scene),
          .unix_active_since_ms = UnixMsOf(decisions.active_since_ns()),
          .recent_switch_count = decisions.RecentSwitchCount(context_.loop.clock().NowNs()),
          .arms = first->identity().arms,
          .initial_arm = decisions.initial_arm(),
          .is_changing = is_changing,
          .report = std::move(report)};
}

}  // namespace sweepstake::sessions
