// The sessions in memory: connected ones, and lost ones, whose client has no connection but can
// resume them. Used on the decision loop only.
//
// HostedSessionOptions::max_sessions and resume_window_ns limit its size. Sessions that have left
// memory can be read from the store. The evidence of a lost session that is not on disk is offered
// to the store again every two seconds. A session whose client has sent Goodbye stays until its
// evidence is on disk, because no client would resend it. The clients of other lost sessions still
// have the unacknowledged messages.
//
// If the client of a lost session never returns, only the bail-outs since the last tick would be
// lost. They are therefore offered to the store before the session leaves memory:
// - At the end of the resume window, the session stays until they are stored.
// - If the session makes room for another one, or the daemon drains, they are offered once, unless
//   a commit of the session is under way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <set>
#include <string>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "server/sessions/game_session.h"
#include "server/sessions/lost_sessions.h"
#include "server/sessions/new_scenes.h"

namespace sweepstake::sessions {

// The client of a session, as of its latest connection.
struct SessionClient {
  std::string address;
  std::string build;
};

// The values are those of v1::SessionState. kEnding: the session has ended, and stays in memory
// until its evidence is on disk.
enum class SessionState : uint8_t { kConnected = 1, kLost = 2, kEnding = 3 };

// The present state of a session, for SessionsService.
struct SessionView {
  std::string id;
  priors::SceneKey scene;
  SessionClient client;
  SessionState state = SessionState::kLost;
  std::string active_arm;
  std::string initial_arm;
  Mode mode = Mode::kManual;
  int64_t unix_start_ms = 0;  // when the session began, or was loaded from the store
  std::optional<int64_t> unix_last_message_ms;
  uint64_t dropped_frame_count = 0;
  // According to the latest Hello.
  bool takes_orders = false;
  bool shows_boxes = false;
};

// What the sessions of a scene run.
struct SceneRun {
  uint32_t session_count = 0;  // connected sessions
  // The session that has been connected the longest, and its arm; empty if there is none.
  std::string session_id;
  std::string active_arm;
  bool operator==(const SceneRun&) const = default;
};

// What the sessions of a scene run, and what the one in `run` has measured.
struct SceneActivity {
  SceneRun run;
  // The values below have no meaning if no session is connected.
  int64_t unix_active_since_ms = 0;
  uint32_t recent_switch_count = 0;
  std::vector<std::string> arms;
  uint32_t initial_arm = 0;  // index in `arms`
  bool is_changing = false;  // as in posteriors.proto
  decision::SceneReport report;
};

// Sessions with evidence that the store does not have.
struct HeldEvidence {
  size_t session_count = 0;
  size_t ended_session_count = 0;  // sessions whose clients will not resend the evidence
};

class SessionTable {
 public:
  // The memory of a session grows with its arms: about 57 KiB for 7 arms and four regimes, 231 KiB
  // for 32. For the limits of sessions, a session counts once per this number of arms.
  static constexpr size_t kArmsPerPlace = 8;
  // Maximum number of ids of kicked sessions that are remembered. An id has 32 characters.
  static constexpr size_t kMaxKicked = 10'000;

  explicit SessionTable(const SessionContext& context)
      : context_(context), new_scenes_(context.options) {}

  // Returns null if the session is not in memory.
  std::shared_ptr<GameSession> Find(const std::string& id) const;
  // Adds the session. Error: RESOURCE_EXHAUSTED (the daemon or the session's party has the maximum
  // number of sessions, and no lost one can be removed). REQUIRES: its id is not in the table.
  absl::Status Add(std::shared_ptr<GameSession> session);

  void Attach(GameSession& session, ClientStream& link, SessionClient client);
  // Detaches the link; does nothing if another link is attached. An ended session leaves the table
  // once its evidence is on disk.
  void Detach(GameSession& session, ClientStream& link);

  // Returns the session; absent if it is not in memory.
  std::optional<SessionView> Describe(const std::string& id) const;
  // Returns up to `limit` matching sessions with ids above `after`, ordered by id.
  std::vector<SessionView> List(const priors::SceneFilter& filter, const std::string& after,
                                size_t limit) const;
  // Calls `use` with up to `limit` sessions with ids above `after`, ordered by id. Returns the id
  // of the last one; empty if there are no further sessions. `use` must not change the table.
  std::string Visit(const std::string& after, size_t limit,
                    const std::function<void(const GameSession&, SessionState)>& use) const;
  // Ends the session's stream, and also the session unless its client may return. REQUIRES: it is
  // in memory.
  void Kick(GameSession& session, bool may_return);
  // Error: SESSION_KICKED (the session is among the latest kMaxKicked that were kicked since the
  // daemon started). The check is needed because the store does not record kicks: a kicked session
  // could be resumed from it.
  absl::Status CheckKicked(const std::string& id) const;

  // Removes a session that another daemon continues. REQUIRES: it is in memory, and superseded.
  void Forget(const GameSession& session);

  // Offers the store all evidence that it failed to write. For lost sessions this includes the
  // evidence of bail-outs since the last tick.
  void RetryCommits();
  // Returns whether a commit of any session is under way.
  bool committing() const;
  HeldEvidence CountHeld() const;
  // Returns the updates that the store has not written yet, of all sessions.
  std::vector<priors::SourceUpdate> Waiting() const;

  SceneRun RunOf(const priors::SceneKey& scene) const;
  // Computes the report of a session, which takes the time of decision::DecisionSession::Report.
  SceneActivity ActivityOf(const priors::SceneKey& scene) const;
  size_t size() const { return entries_.size(); }
  // The scenes of sessions that are not in the store yet.
  NewScenes& new_scenes() { return new_scenes_; }
  const SessionContext& context() const { return context_; }

 private:
  using Owner = priors::SourceOrigin::Owner;
  // The time (ns) of a lost session's next check, and a unique number.
  using LostKey = std::pair<int64_t, uint64_t>;
  struct Entry {
    std::shared_ptr<GameSession> session;
    ClientStream* link = nullptr;
    SessionClient client;            // the client's latest connection
    std::optional<LostKey> lost;     // absent if the session is connected or was never connected
    int64_t resumable_until_ns = 0;  // end of the resume window of a lost session
    LostRank rank;  // rank of the latest loss; in `leaving_` while the session is lost
  };

  // Removes the session from the connected ones, if it is there.
  void Disconnect(const GameSession& session);
  static SessionState StateOf(const Entry& entry);
  SessionView ViewOf(const Entry& entry) const;
  int64_t UnixMsOf(int64_t time_ns) const;
  // Returns the session of the scene that has been connected the longest; null if there is none.
  const GameSession* FirstOf(const priors::SceneKey& scene) const;
  // Returns whether a session that believes in one best arm has switched often. REQUIRES: a session
  // of the scene is connected.
  bool SwitchesOften(const priors::SceneKey& scene) const;
  // Removes the sessions that were lost first, preferably those whose evidence is on disk, until
  // `places` are free. If an owner is given, only sessions of that owner may leave. Returns false,
  // and removes none, if that is not possible.
  bool MakeRoom(const std::optional<Owner>& owner, size_t places);
  void Lose(Entry& entry);
  // Removes the entry from `lost_` and `leaving_`. REQUIRES: its session is lost.
  void Recover(Entry& entry);
  void LookAgainAt(int64_t due_ns, Entry& entry);
  void ScheduleSweep();
  void Sweep();
  void LookAt(const std::string& id);
  void Remove(const std::string& id);
  void RememberKick(const std::string& id);

  const SessionContext context_;
  NewScenes new_scenes_;  // declared before entries_, because it must outlive the sessions
  std::map<std::string, Entry> entries_;
  std::map<LostKey, std::string> lost_;
  LostSessions leaving_;  // lost sessions in the order in which they leave to make room
  // The connected sessions of each scene, in the order of their connection.
  std::map<priors::SceneKey, std::vector<const GameSession*>> connected_;
  size_t place_count_ = 0;                // places of the sessions in the table (kArmsPerPlace)
  std::map<Owner, size_t> owner_places_;  // those of each owner
  std::set<std::string> kicked_;
  std::deque<std::string> kicks_;  // kicked ids, the oldest first
  uint64_t last_lost_number_ = 0;
  bool sweep_scheduled_ = false;  // one timer for all sessions
};

}  // namespace sweepstake::sessions
