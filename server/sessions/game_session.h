// One game's session. It turns validated messages into decisions, switch commands, evidence on disk
// and acknowledgements.
//
// It outlives a connection: a link is attached while a client is connected. Without a link there
// are no ticks, since nobody could receive a command, and the window waits. Nor is there a tick if
// the client has sent nothing since the last one, or yet, unless known priors decide at once: that
// costs no row and no commit. It is used on the decision loop only and is owned by the session
// table and the stream of its link. The memory is bounded by the number of arms.
#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "absl/status/status.h"
#include "engine_client/decider/audit/audit_log.h"
#include "engine_client/decider/session/decision_session.h"
#include "server/rpc/common/options.h"
#include "server/sessions/box_views.h"
#include "server/sessions/decision_loop.h"
#include "server/sessions/new_scenes.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_identity.h"
#include "server/sessions/session_ledger.h"
#include "server/watch/log_histogram.h"
#include "server/watch/watch_hub.h"
#include "sweepstake/v1/posteriors.pb.h"
#include "sweepstake/v1/telemetry.pb.h"

namespace sweepstake::rpc {

// The interface through which a session sends messages to its client, and knows it.
//
// Used on the decision loop only. Nothing here waits; only the latest message of each kind is kept
// until it can be written.
class ClientStream {
 public:
  virtual ~ClientStream() = default;

  virtual void SendSwitch(const SwitchCommand& command) = 0;
  virtual void SendAcknowledgement(uint64_t sequence) = 0;
  // Leaves the decision's posteriors for the next message to take along, or Flush.
  virtual void PutSnapshot(const decision::DecisionRecord& record) = 0;
  virtual void Flush() = 0;
  virtual void SendReconnect(uint32_t delay_ms) = 0;
  virtual void SendOrder(uint64_t order_id, const decision::OrderReport& order) = 0;
  // Asks for boxes (v1::BoxRequest); all 0: for none any more.
  virtual void SendBoxRequest(uint32_t interval_ms, uint32_t max_bytes, uint32_t until_ms) = 0;
  // Counts a bail-out of the client's token and address. Returns whether it is evidence.
  virtual bool SpendBailOut() = 0;
  // Ends the stream after all messages are written. The session has released the link before.
  virtual void Close(const absl::Status& status) = 0;
  // Ends the stream at once.
  virtual void Abort(const absl::Status& status) = 0;
};

// The objects that the sessions share. The server owns them and outlives every session.
struct SessionContext {
  const RpcOptions& options;
  DecisionLoop& loop;
  priors::AsyncPriorStore& store;
  Counters& counters;
  watch::WatchHub& watch_hub;
};

// What the store has when a session begins.
struct StoredSession {
  priors::SourceProgress progress;
  bool has_evidence = false;                   // the session's own; it may have progress alone
  std::optional<uint64_t> prior_source_count;  // absent if the store could not be read
};

// UNKNOWN_SESSION: what those are told who name a session that is not in memory, or not theirs.
absl::Status UnknownSession();
// SESSION_KICKED: what the client of a kicked session is told, also where it comes back.
absl::Status SessionKicked();

class GameSession : public std::enable_shared_from_this<GameSession>, private decision::AuditSink {
 public:
  static std::shared_ptr<GameSession> Create(SessionContext& context, SessionIdentity identity,
                                             const decision::SessionSetup& setup,
                                             const StoredSession& stored);

  ~GameSession() override { --context_.counters.session_count; }

  // Keeps the hold until the store has the session's scene.
  void Keep(NewScenes::Hold scene) { new_scene_.emplace(std::move(scene)); }

  // Attaches a link. The previous one, if any, is aborted.
  void Attach(ClientStream& link);
  // Called after the welcome: sends what the client may have missed, and begins to tick.
  void Start(const v1::Hello& hello);
  // Called when the connection is lost. Does nothing if `link` is not the attached one.
  void Detach(ClientStream& link);

  // Applies a request that has passed CheckRequest, or counts it as a replay.
  void Apply(const v1::StreamTelemetryRequest& request);
  // Called when the client has stayed away, or the daemon stops: offers the store what was learnt
  // since the last tick, a bail-out, which the client may not be there to send again. The frames
  // around it count as taken with it, and the window that they began is given up.
  void KeepOpenEvidence();
  // Called at the client's goodbye: closes the link once everything is on disk.
  void End();
  // Called when somebody who runs the daemon wants its client gone: ends the stream, and the
  // session too unless the client may return. What was sent still goes to disk.
  void Kick(bool may_return);
  bool ended() const { return end_ != watch::SessionEnd::kNone; }
  // Tells those who watch sessions that this one has changed; `end` is why it is not there any
  // more.
  void TellChange(watch::SessionEnd end = watch::SessionEnd::kNone) const;
  // Called when the session leaves memory: tells those who watch.
  void TellEnd() const;
  watch::SessionEnd end() const { return end_; }
  // Tells the client to reconnect after `delay_ms`, and closes the link once all pending writes are
  // done.
  void Drain(uint32_t delay_ms);
  // Passes an operator's order on to the game, if it takes any, in place of one that it has not
  // answered. `answer` is called exactly once: with OK when the game has obeyed, and then with what
  // it said or with why it cannot be known. REQUIRES: order.arm is one of the session's arms, if
  // any.
  using OrderAnswer = std::function<void(const absl::Status&)>;
  void Order(const decision::OrderReport& order, OrderAnswer answer);
  // Returns whether nothing waits for the disk. If something does, RetryCommit offers it again.
  bool settled() const { return ledger_->settled(); }
  void RetryCommit() { ledger_->Retry(); }
  void AppendWaiting(std::vector<priors::SourceUpdate>& updates) const {
    ledger_->AppendWaiting(updates);
  }
  bool committing() const { return ledger_->committing(); }
  // Returns whether another daemon goes on with the session: this one only forgets it.
  bool superseded() const { return ledger_->superseded(); }

  // The boxes of its objects, for those who look at them.
  BoxViews& boxes() { return boxes_; }

  const SessionIdentity& identity() const { return identity_; }
  const decision::DecisionSession& decisions() const { return decisions_; }
  uint64_t durable_sequence() const { return ledger_->durable_sequence(); }
  // By the clock of the loop; absent if no message came yet.
  std::optional<int64_t> last_message_ns() const { return last_message_ns_; }
  uint64_t dropped_frame_count() const { return dropped_frame_count_; }
  std::optional<uint64_t> prior_source_count() const { return prior_source_count_; }

 private:
  GameSession(SessionContext& context, SessionIdentity identity,
              const decision::SessionSetup& setup, const StoredSession& stored);

  // There is something to decide on, or to report, with the next tick. The audit log begins with
  // the first of it, since most of what a game costs that has said hello and no more would be the
  // log's first rows.
  void Hear();
  void StartAudit();
  void OnAuditRow(std::string_view row) override { ledger_->AddAuditRow(row); }

  void ApplyEvidence(const v1::StreamTelemetryRequest& request);
  void ApplyFrames(const v1::FrameBatch& batch);
  void ApplyShadows(const v1::FrameBatch& batch);
  void ApplySwitchOutcome(const v1::SwitchOutcome& outcome);
  void ApplyBailOut(const v1::BailOut& bail_out);
  bool IsOverLimit(const FrameSample& frame) const;
  void Measure();
  void ApplyModeChange(const v1::ModeChange& change);
  void ApplyOrderRefusal(const v1::OrderRefusal& refusal);
  // Ends the order that waits for an answer, if it is this one.
  void AnswerOrder(uint64_t order_id, const absl::Status& status);
  void LoseOrder();

  void ScheduleTick(int64_t due_ns);
  void OnTimer(uint64_t generation);
  void Checkpoint();
  void OnCommitted(const absl::Status& status, std::span<const priors::KeyedEvidence> increments);
  void LeaveToOther();
  void CloseIfSettled();
  // `commit` is the status of the session's last commit.
  void CloseLink(const absl::Status& commit);
  void SendDecision(const decision::Decision& decision);
  void PutPosteriors(const decision::Decision& decision);
  void TellWatchers(const decision::DecisionRecord& record);
  void TellMeasurements(int64_t now_ns, v1::DecisionEvent& event);
  void AddEvidence(const decision::Increment& increment, std::string_view measured_by);

  SessionContext& context_;
  const SessionIdentity identity_;
  decision::DecisionSession decisions_;
  std::shared_ptr<SessionLedger> ledger_;
  const std::optional<uint64_t> prior_source_count_;
  std::optional<NewScenes::Hold> new_scene_;

  ClientStream* link_ = nullptr;
  uint64_t applied_sequence_;
  uint64_t frame_count_;            // frames in the messages up to applied_sequence_
  uint64_t acknowledged_sequence_;  // sent to the client
  uint32_t switch_epoch_;           // the latest in a message other than frames
  bool has_stored_evidence_;
  std::optional<uint64_t> last_bail_out_frame_;
  std::optional<SwitchCommand> unanswered_;   // sent again to a client that reconnects
  Verdict sent_verdict_ = Verdict::kUnknown;  // sent to the client
  bool takes_orders_ = false;                 // says the latest Hello
  BoxViews boxes_;
  uint64_t order_id_ = 0;          // of the latest order
  OrderAnswer order_answer_;       // empty if the game has answered it
  uint64_t timer_generation_ = 0;  // timers of an older generation are ignored
  bool commit_failed_ = false;     // the last one
  bool heard_ = false;             // the next tick has something to decide on
  bool audited_ = false;           // the audit log has begun, if there is one
  watch::SessionEnd end_ =
      watch::SessionEnd::kNone;  // why the session ends; its last evidence may wait
  std::optional<int64_t> last_message_ns_;
  uint64_t dropped_frame_count_ = 0;  // that the client reported
  bool draining_ = false;
  // What frames have cost since the watchers were told; absent while nobody watches the scene.
  std::optional<watch::FrameHistograms> measured_;
  int64_t next_measurements_ns_ = 0;   // the watchers are told again from then on
  std::vector<FrameSample> frames_;    // reused
  std::vector<ShadowSample> shadows_;  // reused
};

}  // namespace sweepstake::rpc
