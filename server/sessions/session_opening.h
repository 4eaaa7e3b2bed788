// The path from a Hello to its session: session_table, store, scene_quota, session_start (which
// calls decision::PriorFor), new_scenes, session_table. The table is searched again after the read,
// because the loop does other work in between. If another connection resumes the session in that
// time, and this Hello does not match the resumed session, this Hello is refused. Its client then
// connects again.
//
// - If the session to resume is in memory, the client gets it back unchanged.
// - Otherwise the store is read, on its reading thread. If it does not have the scene, its writing
//   thread then counts the scene against the quotas, because only there the count is exact. A
//   session to resume is read on the writing thread, because its latest commit may wait in the
//   queue.
// - Then a new session begins or, if the store has the session to resume, one that continues with
//   its stored progress.
//
// If the resume token is wrong, or the session to resume is unknown, has ended, or has another
// scene, machine class, reward version or other arms, a new session begins. The answer is the same
// in all these cases, so it reveals nothing about other sessions.
//
// If some evidence cannot be read, the session begins without it: from Beta(1,1) plus the evidence
// that could be read. If the progress of a session cannot be read, it is not resumed, because its
// messages might count twice: a new one begins.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <utility>

#include "absl/status/status.h"
#include "absl/status/statusor.h"
#include "server/sessions/client_messages.h"
#include "server/sessions/session_start.h"
#include "server/sessions/session_table.h"

namespace sweepstake::sessions {

struct OpenedSession {
  std::shared_ptr<GameSession> session;  // the session, already in the table
  bool resumed = false;
  absl::Status missing;  // the error that made stored evidence missing; OK if none is missing
};

// Used on the decision loop only. The client's stream owns this object: if the stream ends, no
// session begins.
class SessionOpening : public std::enable_shared_from_this<SessionOpening> {
 public:
  using Done = std::function<void(absl::StatusOr<OpenedSession>)>;

  // `table` must outlive this object.
  SessionOpening(SessionTable& table, SessionRequest hello, Done done)
      : table_(table), hello_(std::move(hello)), done_(std::move(done)) {}

  // Calls `done` once, on the loop, perhaps before Run returns. Errors: PERMISSION_DENIED (the
  // session began with another token, or was kicked), RESOURCE_EXHAUSTED (a quota is exceeded, or
  // the table is full), INVALID_ARGUMENT (the arms and the policy do not make a valid session),
  // UNAVAILABLE (the store is overloaded, or cannot read a session that another daemon may have).
  void Run();

  // The Hello, without the id of a session that it may not resume.
  const SessionRequest& hello() const { return hello_; }

 private:
  const SessionContext& context() const { return table_.context(); }
  absl::Status CheckResumption();
  // Returns the session in memory that the Hello resumes, or null. If the Hello may not resume that
  // session, the Hello's session id is cleared.
  std::shared_ptr<GameSession> FindInMemory();
  void ReadStore();
  // Offers the store a read. Returns false if it is overloaded.
  bool SubmitRead();
  void OnRead(const StoredStart& start);
  absl::StatusOr<OpenedSession> Begin(const StoredStart& start);
  void Finish(absl::StatusOr<OpenedSession> result);

  SessionTable& table_;
  SessionRequest hello_;
  Done done_;  // empty after the call
};

}  // namespace sweepstake::sessions
