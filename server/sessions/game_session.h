// One game's session. It turns checked messages into decisions, switch commands, stored evidence
// and acknowledgements.
//
// A session outlives the connections of its client. While the client is connected, its stream is
// attached to the session as the link.
//
// At each tick, once per decision interval, the session learns from the frames since the last tick
// and makes a decision. Without a link there are no ticks, because nobody could receive a switch
// command. The frames then wait for the next tick.
//
// A tick makes a decision only if a message has arrived since the last tick. The first tick after a
// connection also decides without a message, unless there are no priors and the first decision
// waits for frames. A silent client therefore causes no audit rows and no commits.
//
// A session is used on the decision loop only. The session table and the stream of its link own it.
// The memory is bounded by the number of arms.
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
#include "server/sessions/box_views.h"
#include "server/sessions/client_messages.h"
#include "server/sessions/common/decision_loop.h"
#include "server/sessions/common/log_histogram.h"
#include "server/sessions/common/options.h"
#include "server/sessions/common/session_use.h"
#include "server/sessions/new_scenes.h"
#include "server/sessions/prior_store.h"
#include "server/sessions/session_identity.h"
#include "server/sessions/session_ledger.h"
#include "server/sessions/session_observer.h"

namespace sweepstake::sessions {

// The interface through which a session sends messages to its client.
//
// Used on the decision loop only. Calls do not block. While a message waits to be written, a newer
// message of the same kind replaces it.
class ClientStream {
 public:
  virtual ~ClientStream() = default;

  virtual void SendSwitch(const SwitchCommand& command) = 0;
  virtual void SendAcknowledgement(uint64_t sequence) = 0;
  // Adds the decision's posteriors to the next message that is sent. Flush sends them at once, in a
  // message without other content.
  virtual void PutSnapshot(const decision::DecisionRecord& record) = 0;
  virtual void Flush() = 0;
  virtual void SendReconnect(uint32_t delay_ms) = 0;
  virtual void SendOrder(uint64_t order_id, const decision::OrderReport& order) = 0;
  // Requests the boxes of the game's objects every `interval_ms`, in messages of at most
  // `max_bytes`, for the next `until_ms`. If all arguments are 0, requests the game to stop sending
  // boxes.
  virtual void SendBoxRequest(uint32_t interval_ms, uint32_t max_bytes, uint32_t until_ms) = 0;
  // Counts a bail-out against the limit of the client's party. Returns whether it is within the
  // limit and therefore evidence.
  virtual bool SpendBailOut() = 0;
  // Ends the stream after all messages are written. REQUIRES: the session does not use the stream
  // any more.
  virtual void Close(const absl::Status& status) = 0;
  // Ends the stream at once.
  virtual void Abort(const absl::Status& status) = 0;
};

// The objects that the sessions share. They outlive every session.
struct SessionContext {
  const HostedSessionOptions& options;
  DecisionLoop& loop;
  priors::AsyncPriorStore& store;
  SessionCounters& counters;
  SessionObserver& observer;
};

// The part of a new session that was read from the store.
struct StoredSession {
  priors::SourceProgress progress;
  // Whether evidence is stored. A session can have stored progress without evidence.
  bool has_evidence = false;
  // Number of sources of the session's prior; absent if the store could not be read.
  std::optional<uint64_t> prior_source_count;
};

// Returns the error UNKNOWN_SESSION, for callers that name a session that is not in memory or that
// they may not see.
absl::Status UnknownSession();
// Returns the error SESSION_KICKED, for the client of a kicked session. The client also receives it
// when it connects again.
absl::Status SessionKicked();

class GameSession : public std::enable_shared_from_this<GameSession>, private decision::AuditSink {
 public:
  static std::shared_ptr<GameSession> Create(const SessionContext& context,
                                             SessionIdentity identity,
                                             const decision::SessionSetup& setup,
                                             const StoredSession& stored);

  ~GameSession() override { --context_.counters.session_count; }

  // Keeps the session's claim to its new scene (new_scenes.h) until the scene is in the store.
  void Keep(NewScenes::Hold scene) { new_scene_.emplace(std::move(scene)); }

  // Attaches a link. The previous one, if any, is aborted.
  void Attach(ClientStream& link);
  // Called after the welcome message: sends the switch command that the client has not answered, if
  // any, and starts the ticks.
  void Start(const SessionRequest& hello);
  // Called when the connection is lost. Does nothing if `link` is not the attached one.
  void Detach(ClientStream& link);

  // Applies a message. If its sequence number was applied before, it is only counted as a replay.
  // The frames of the message may be modified.
  void Apply(Telemetry& telemetry);
  // Called when the client has not returned in time, or the daemon stops. Commits the evidence of
  // bail-outs since the last tick, because the client might never resend them. The commit marks all
  // received messages as applied, so the other frames since the last tick give no evidence.
  void KeepOpenEvidence();
  // Called at the client's goodbye: closes the link once everything is on disk.
  void End();
  // Called when an operator kicks the client. Ends the stream, and also the session unless the
  // client may return. Received evidence still goes to disk.
  void Kick(bool may_return);
  bool ended() const { return end_ != SessionEnd::kNone; }
  // Notifies the observer that the session has changed. `end` is the reason if it has left memory.
  void PublishChange(SessionEnd end = SessionEnd::kNone) const;
  // Notifies the observer that the session leaves memory.
  void PublishEnd();
  SessionEnd end() const { return end_; }
  // Requests the client to reconnect after `delay_ms`, and closes the link once all pending writes
  // are done.
  void Drain(uint32_t delay_ms);
  // Sends an operator's order to the game. It replaces an order that the game has not answered.
  // `answer` is called exactly once: with OK when the game has executed the order, otherwise with
  // the game's refusal or the reason why the outcome is unknown. REQUIRES: order.arm, if set, is
  // one of the session's arms.
  using OrderAnswer = std::function<void(const absl::Status&)>;
  void Order(const decision::OrderReport& order, OrderAnswer answer);
  // Returns whether no update of the session waits for the disk. If one does, RetryCommit offers it
  // to the store again.
  bool settled() const { return ledger_->settled(); }
  void RetryCommit() { ledger_->Retry(); }
  void AppendWaiting(std::vector<priors::SourceUpdate>& updates) const {
    ledger_->AppendWaiting(updates);
  }
  bool committing() const { return ledger_->committing(); }
  // Returns whether another daemon continues the session. If so, this daemon only removes it from
  // memory.
  bool superseded() const { return ledger_->superseded(); }

  // The boxes of the session's objects, and their viewers.
  BoxViews& boxes() { return boxes_; }

  // Returns whether the game executes orders, or shows its boxes, according to the latest Hello.
  bool takes_orders() const { return takes_orders_; }
  bool shows_boxes() const { return boxes_.shows(); }

  const SessionIdentity& identity() const { return identity_; }
  const decision::DecisionSession& decisions() const { return decisions_; }
  uint64_t durable_sequence() const { return ledger_->durable_sequence(); }
  // Time of the last message by the clock of the decision loop; absent before the first message.
  std::optional<int64_t> last_message_ns() const { return last_message_ns_; }
  uint64_t dropped_frame_count() const { return dropped_frame_count_; }
  std::optional<uint64_t> prior_source_count() const { return prior_source_count_; }

 private:
  GameSession(const SessionContext& context, SessionIdentity identity,
              const decision::SessionSetup& setup, const StoredSession& stored);

  // Returns the keys whose arms the session makes known.
  std::vector<priors::EvidenceKey> KnownKeys() const;
  // Makes the next tick decide. The first call also starts the session's audit log. The Hello does
  // not start it: for a session that only sends a Hello, the first rows of the log would dominate
  // the cost.
  void MarkActive();
  void StartAudit();
  void OnAuditRow(const decision::AuditRow& row) override {
    ledger_->AddAuditRow(context_.options.encode_audit_row(row));
  }

  // Each ApplyMessage applies one kind of message. It may modify the frames of the message.
  void ApplyMessage(UnknownMessage& /*unknown*/) {}
  void ApplyMessage(protocol::FrameBatch& batch);
  void ApplyMessage(SwitchAnswer& outcome);
  void ApplyMessage(protocol::BailOut& bail_out);
  void ApplyMessage(ModeChange& change);
  void ApplyMessage(protocol::OrderRefusal& refusal);
  bool IsOverLimit(const FrameSample& frame) const;
  void Measure(std::span<const FrameSample> frames);
  // Reports the frames since the previous report to HostedSessionOptions::on_use.
  void ReportUse();
  // Reports `status` to the caller of Order if the order with this id still waits for an answer.
  void AnswerOrder(uint64_t order_id, const absl::Status& status);
  void LoseOrder();

  void ScheduleTick(int64_t due_ns);
  void OnTimer(uint64_t generation);
  void Checkpoint();
  void OnCommitted(const absl::Status& status, std::span<const priors::KeyedEvidence> increments);
  void LeaveToOther();
  void CloseIfSettled();
  // Detaches the link and returns it. REQUIRES: a link is attached.
  ClientStream& ReleaseLink();
  // Closes the link of a session that has ended or drains. `commit` is the status of its last
  // commit.
  void CloseLink(const absl::Status& commit);
  void SendDecision(const decision::Decision& decision);
  void PutPosteriors(const decision::Decision& decision);
  void PublishDecision(const decision::DecisionRecord& record);
  void AddEvidence(const decision::Increment& increment, std::string_view measured_by,
                   const std::string& regime);

  const SessionContext context_;
  const SessionIdentity identity_;
  decision::DecisionSession decisions_;
  std::shared_ptr<SessionLedger> ledger_;
  const std::optional<uint64_t> prior_source_count_;
  std::optional<NewScenes::Hold> new_scene_;

  ClientStream* link_ = nullptr;
  uint64_t applied_sequence_;
  uint64_t frame_count_;            // frames in the messages up to applied_sequence_
  uint64_t acknowledged_sequence_;  // latest number sent to the client
  uint32_t switch_epoch_;           // the latest in a Hello or switch answer
  bool has_stored_evidence_;
  std::optional<uint64_t> last_bail_out_frame_;
  // Switch command without an answer; sent again to a client that reconnects.
  std::optional<SwitchCommand> unanswered_;
  Verdict sent_verdict_ = Verdict::kUnknown;  // latest verdict sent to the client
  bool takes_orders_ = false;
  BoxViews boxes_;
  uint64_t order_id_ = 0;          // id of the latest order
  OrderAnswer order_answer_;       // empty if no order waits for an answer
  uint64_t timer_generation_ = 0;  // timers of an older generation are ignored
  bool commit_failed_ = false;     // whether the latest commit failed
  bool active_ = false;            // whether the next tick has something to decide on
  bool audited_ = false;           // whether the audit log has begun, or is off
  SessionEnd end_ =
      SessionEnd::kNone;  // why it has ended; its last evidence may not be on disk yet
  std::optional<int64_t> last_message_ns_;
  uint64_t dropped_frame_count_ = 0;  // reported by the client
  bool draining_ = false;
  // The cost of frames since the last publication; absent while nobody watches the scene.
  std::optional<FrameHistograms> measured_;
  int64_t next_measurements_ns_ = 0;  // the earliest time at which `measured_` is published
  UseMeter use_;
};

}  // namespace sweepstake::sessions
