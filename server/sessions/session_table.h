// The sessions in memory: connected ones, and lost ones that may be resumed. It is used on the
// decision loop only.
//
// It is bounded by RpcOptions::max_sessions and resume_window_ns; the store knows every session
// that has left. The evidence of a lost session that is not on disk is offered to the store again
// every two seconds. A session that has said goodbye stays until that has succeeded, since nobody
// would send its evidence again. The clients of the others still have what was not acknowledged,
// if they live. For those that do not, the bail-outs since the last tick go to the store before
// their session leaves: at the end of the window it stays until they are there; where it makes
// room, or the daemon drains, they are offered once, unless a commit of the session is under way.
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
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
#include "sweepstake/v1/sessions.pb.h"

namespace sweepstake::rpc {

// What a session's latest connection says about its client.
struct SessionClient {
  std::string address;
  std::string build;
};

// Sessions with evidence that the store does not have.
struct HeldEvidence {
  size_t session_count = 0;
  size_t ended_session_count = 0;  // of these, those whose clients will not send it again
};

class SessionTable {
 public:
  static constexpr size_t kMaxKicked = 10'000;  // ids of 32 bytes

  explicit SessionTable(const RpcOptions& options, DecisionLoop& loop)
      : options_(options), loop_(loop), new_scenes_(options) {}

  // Returns null if the session is not in memory.
  std::shared_ptr<GameSession> Find(const std::string& id) const;
  // Error: RESOURCE_EXHAUSTED (it, or the share of the session's token, is full of sessions that
  // cannot leave). REQUIRES: the session's
  // id is not in the table.
  absl::Status Add(std::shared_ptr<GameSession> session);

  void Attach(GameSession& session, ClientStream& link, SessionClient client);
  // Detaches the link; does nothing if the session has another one. An ended session leaves the
  // table once its evidence is on disk.
  void Detach(GameSession& session, ClientStream& link);

  // Returns the session; absent if it is not in memory.
  std::optional<v1::SessionInfo> Describe(const std::string& id) const;
  // Returns up to `limit` matching sessions in the order of their ids, from the first one after
  // `after` on.
  std::vector<v1::SessionInfo> List(const priors::SceneFilter& filter, const std::string& after,
                                    size_t limit) const;
  // Ends the session's stream, and the session too unless its client may return. REQUIRES: it is in
  // memory.
  void Kick(GameSession& session, bool may_return);
  // Error: SESSION_KICKED (the session of that id was; of the latest kMaxKicked ones since the
  // daemon began). The store, which knows every session, would resume it.
  absl::Status CheckKicked(const std::string& id) const;

  // Removes a session that another daemon goes on with. REQUIRES: it is in memory, and superseded.
  void Forget(const GameSession& session);

  // Offers the store again what it has failed to write, and what lost sessions have not offered.
  void RetryCommits();
  // Returns whether the store has yet to answer for any session.
  bool committing() const;
  HeldEvidence CountHeld() const;
  // Returns what the store does not have of any session, as it is to be committed.
  std::vector<priors::SourceUpdate> Waiting() const;

  uint32_t ActiveCount(const priors::SceneKey& scene) const;
  size_t size() const { return entries_.size(); }
  // The scenes of sessions that the store does not have yet.
  NewScenes& new_scenes() { return new_scenes_; }

 private:
  // The time of a lost session's next check, and a unique number.
  using LostKey = std::pair<int64_t, uint64_t>;
  struct Entry {
    std::shared_ptr<GameSession> session;
    ClientStream* link = nullptr;
    SessionClient client;            // the latest one
    std::optional<LostKey> lost;     // absent if connected or never connected
    int64_t resumable_until_ns = 0;  // end of the resume window of a lost session
    LostRank rank;                   // of its latest loss; in `leaving_` while it is lost
  };

  v1::SessionInfo InfoOf(const Entry& entry) const;
  // Removes the session that was lost first, of the token if one is given; one whose evidence is on
  // disk, if there is such a one. Returns whether there was one that could leave.
  bool MakeRoom(std::optional<int64_t> token_id);
  void Lose(Entry& entry);
  // It is not among the lost ones any more. REQUIRES: it is one.
  void Recover(Entry& entry);
  void LookAgainAt(int64_t due_ns, Entry& entry);
  void ScheduleSweep();
  void Sweep();
  void LookAt(const std::string& id);
  void Remove(const std::string& id);
  void RememberKick(const std::string& id);

  const RpcOptions& options_;
  DecisionLoop& loop_;
  NewScenes new_scenes_;  // outlives the sessions
  std::map<std::string, Entry> entries_;
  std::map<LostKey, std::string> lost_;
  LostSessions leaving_;  // the same, in the order in which they leave where there is no room
  std::map<priors::SceneKey, uint32_t> active_counts_;
  std::map<int64_t, uint32_t> token_counts_;  // sessions in the table, by the token's id
  std::set<std::string> kicked_;
  std::deque<std::string> kicks_;  // the same, the oldest first
  uint64_t last_lost_number_ = 0;
  bool sweep_scheduled_ = false;  // one timer, however many sessions come and go
};

}  // namespace sweepstake::rpc
