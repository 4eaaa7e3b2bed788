#include "server/sessions/game_session.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/session/arm_runs.h"
#include "engine_client/decider/session/policy_registry.h"
#include "server/sessions/common/reasons.h"
#include "server/sessions/common/rejection.h"
#include "server/sessions/common/unix_time.h"

namespace sweepstake::sessions {
namespace {

// Time after which an order without an answer is reported as unanswered.
constexpr int64_t kOrderPatienceNs = 5'000'000'000;
// Order ids have 48 bits, because a game stores only 48 bits of them.
constexpr uint64_t kOrderIdMask = (uint64_t{1} << 48) - 1;

absl::Status TakesNoOrders() {
  return Refused(reasons::kOrderRefused,
                 "this game does not accept orders; set allow_operator_orders in the game");
}

void Count(RejectionReason reason, RejectionCounts& counts) {
  ++counts.at(static_cast<size_t>(reason));
}

// Removes the impossible samples and counts them by reason.
template <typename Sample>
void Reject(std::vector<Sample>& samples, RejectionCounts& counts) {
  std::erase_if(samples, [&](const Sample& sample) {
    const std::optional<RejectionReason> reason = RejectionOf(sample);
    if (reason) Count(*reason, counts);
    return reason.has_value();
  });
}

}  // namespace

absl::Status UnknownSession() {
  return Refused(reasons::kUnknownSession,
                 "no session with this id is in memory; list the sessions to see their ids");
}

absl::Status SessionKicked() {
  return Refused(reasons::kSessionKicked, "an operator ended this session; it cannot be resumed");
}

std::shared_ptr<GameSession> GameSession::Create(const SessionContext& context,
                                                 SessionIdentity identity,
                                                 const decision::SessionSetup& setup,
                                                 const StoredSession& stored) {
  std::shared_ptr<GameSession> session(
      new GameSession(context, std::move(identity), setup, stored));
  session->ledger_ = std::make_shared<SessionLedger>(
      context.store, context.loop, context.counters, stored.progress,
      [weak = session->weak_from_this()](const absl::Status& status,
                                         std::span<const priors::KeyedEvidence> increments) {
        if (const auto self = weak.lock()) self->OnCommitted(status, increments);
      });
  session->ledger_->SetOrigin(session->identity_.origin, session->identity_.is_of_player,
                              session->KnownKeys());
  return session;
}

GameSession::GameSession(const SessionContext& context, SessionIdentity identity,
                         const decision::SessionSetup& setup, const StoredSession& stored)
    : context_(context),
      identity_(std::move(identity)),
      decisions_(setup, decision::ShippedPolicies()),
      prior_source_count_(stored.prior_source_count),
      applied_sequence_(stored.progress.message_sequence),
      frame_count_(stored.progress.frame_count),
      acknowledged_sequence_(stored.progress.message_sequence),
      switch_epoch_(setup.switch_epoch),
      has_stored_evidence_(stored.has_evidence),
      boxes_(context.loop),
      use_(identity_.arms.size()) {
  ++context_.counters.session_count;
}

std::vector<priors::EvidenceKey> GameSession::KnownKeys() const {
  std::vector<priors::EvidenceKey> keys;
  for (size_t i = 0; i < identity_.arms.size() && !identity_.is_of_player; ++i)
    keys.push_back(
        EvidenceKeyOf(identity_.scene, identity_.arms[i], identity_.backend_versions[i], {}));
  return keys;
}

void GameSession::MarkActive() {
  active_ = true;
  if (!std::exchange(audited_, true) && context_.options.keeps_audit) StartAudit();
}

void GameSession::StartAudit() {
  const int64_t unix_now_ms = priors::UnixNowMs();
  const priors::SceneKey& scene = identity_.scene;
  ledger_->StartAudit({.segment = identity_.audit_segment,
                       .project = scene.project,
                       .scene = scene.scene,
                       .unix_start_ms = unix_now_ms,
                       .rows = {}});
  decision::StartAudit(decisions_, *this,
                       {.session_id = identity_.id,
                        .segment = identity_.audit_segment,
                        .project = scene.project,
                        .scene = scene.scene,
                        .machine_class = scene.machine_class,
                        .program_version = context_.options.daemon_version,
                        .backend_versions = identity_.backend_versions,
                        .unix_start_ms = unix_now_ms,
                        .prior_sources = identity_.prior_sources});
}

void GameSession::Attach(ClientStream& link) {
  if (link_ != nullptr) {
    link_->Abort(
        Refused(reasons::kSessionTakenOver, "another connection has resumed this session"));
  }
  LoseOrder();
  boxes_.Disconnect();
  link_ = &link;
  // The Welcome contains this number, so that no separate acknowledgement of it is needed.
  acknowledged_sequence_ = durable_sequence();
  sent_verdict_ = Verdict::kUnknown;
}

void GameSession::Start(const SessionRequest& hello) {
  takes_orders_ = hello.takes_orders;
  boxes_.Connect(*link_, hello.shows_boxes);
  if (hello.mode != decisions_.mode()) {
    MarkActive();
    decisions_.SetMode(hello.mode, hello.active_arm, context_.loop.clock().NowNs());
  }
  PublishChange();
  if (unanswered_) link_->SendSwitch(*unanswered_);
  if (!decisions_.waits_for_frames()) MarkActive();
  ScheduleTick(decisions_.next_tick_ns());
}

void GameSession::Detach(ClientStream& link) {
  if (link_ != &link) return;
  link_ = nullptr;
  ++timer_generation_;
  boxes_.Disconnect();
  LoseOrder();
  ReportUse();
}

void GameSession::Apply(Telemetry& telemetry) {
  last_message_ns_ = context_.loop.clock().NowNs();
  if (telemetry.sequence <= applied_sequence_) {
    ++context_.counters.replayed_message_count;
    return;
  }
  applied_sequence_ = telemetry.sequence;
  MarkActive();
  if (std::holds_alternative<UnknownMessage>(telemetry.message)) {
    ++context_.counters.unknown_message_count;
    return;
  }
  std::visit([this](auto& message) { ApplyMessage(message); }, telemetry.message);
  ++context_.counters.applied_message_count;
}

void GameSession::ApplyMessage(protocol::FrameBatch& batch) {
  frame_count_ += batch.frames.size();
  context_.counters.dropped_frame_count += batch.dropped_frame_count;
  dropped_frame_count_ += batch.dropped_frame_count;
  for (FrameSample& frame : batch.frames) {
    // The client sets the flag, but only the frame time decides whether the frame is a bail-out.
    if (!IsOverLimit(frame)) frame.flags &= ~kFrameBailOut;
  }
  if (batch.invalid_box_count > 0) ++context_.counters.invalid_box_batch_count;
  Reject(batch.frames, context_.counters.rejected_frame_counts);
  Reject(batch.shadow_samples, context_.counters.rejected_shadow_counts);
  context_.counters.accepted_frame_count += batch.frames.size();
  context_.counters.suspended_frame_count += static_cast<uint64_t>(std::ranges::count_if(
      batch.frames, [](const FrameSample& frame) { return (frame.flags & kFrameSuspended) != 0; }));
  context_.counters.accepted_shadow_count += batch.shadow_samples.size();
  decisions_.ObserveFrames(batch.frames);
  if (measured_) Measure(batch.frames);
  use_.AddFrames(batch.frames, priors::UnixNowMs());
  decisions_.ObserveShadow(batch.shadow_samples);
  if (!batch.scene_descriptor) return;
  const int64_t due_ns = decisions_.next_tick_ns();
  decisions_.ObserveDescriptor(*batch.scene_descriptor);
  if (decisions_.next_tick_ns() < due_ns) ScheduleTick(decisions_.next_tick_ns());
}

void GameSession::Measure(std::span<const FrameSample> frames) {
  for (const FrameSample& frame : frames) {
    if ((frame.flags & kFrameWithoutCost) != 0) continue;
    measured_->Add(frame.frame_time_ns, frame.detection_time_ns, frame.native_bytes);
  }
}

void GameSession::ApplyMessage(SwitchAnswer& outcome) {
  if (unanswered_ && outcome.command_id == unanswered_->command_id) unanswered_.reset();
  if (!outcome.executed) {
    ++context_.counters.refused_switch_count;
    return decisions_.ObserveRefusal(outcome.command_id);
  }
  // Ignore a switch that is older than the switch epoch in the client's Hello. After a reconnection
  // the client resends such messages.
  if (decision::IsLaterEpoch(switch_epoch_, outcome.switch_epoch)) return;
  switch_epoch_ = outcome.switch_epoch;
  decisions_.ObserveSwitch(outcome.arm, outcome.switch_epoch, outcome.reason,
                           context_.loop.clock().NowNs(), outcome.cost);
  use_.AddSwitch();
  PublishChange();
}

void GameSession::ApplyMessage(protocol::BailOut& bail_out) {
  FrameSample& frame = bail_out.frame;
  if (last_bail_out_frame_ && frame.frame_index <= *last_bail_out_frame_) return;
  last_bail_out_frame_ = frame.frame_index;
  std::optional<RejectionReason> rejection = RejectionOf(frame);
  if (!rejection && !IsOverLimit(frame)) rejection = RejectionReason::kFrameTime;
  if (rejection) return Count(*rejection, context_.counters.rejected_frame_counts);
  const int64_t now_ns = context_.loop.clock().NowNs();
  // Only a bail-out that the session would use as evidence counts against the limit of the client's
  // party.
  if (decisions_.IsEvidence(frame, now_ns) && link_ != nullptr && !link_->SpendBailOut())
    frame.flags |= decision::kFrameNoEvidence;
  // The evidence of the bail-out goes to disk with the next tick. Committing it now would also
  // acknowledge the frames before it, whose evidence is computed only at that tick.
  const uint64_t surplus_count = decisions_.counts().surplus_bail_out_count;
  SendDecision(decisions_.ObserveBailOut(frame, now_ns));
  if (link_ != nullptr) link_->Flush();
  context_.counters.surplus_bail_out_count +=
      decisions_.counts().surplus_bail_out_count - surplus_count;
}

bool GameSession::IsOverLimit(const FrameSample& frame) const {
  return frame.frame_time_ns > static_cast<uint64_t>(decisions_.setup().options.bail_out_ns);
}

void GameSession::ApplyMessage(ModeChange& change) {
  decisions_.SetMode(change.mode, change.active_arm, context_.loop.clock().NowNs());
  unanswered_.reset();
  AnswerOrder(change.order_id, absl::OkStatus());
  PublishChange();
}

void GameSession::ApplyMessage(protocol::OrderRefusal& refusal) {
  AnswerOrder(refusal.order_id,
              refusal.reason == protocol::OrderRefusalReason::kNotAllowed
                  ? TakesNoOrders()
                  : Refused(reasons::kOrderRefused,
                            "the game does not support this order; update the game"));
}

void GameSession::Order(const decision::OrderReport& order, OrderAnswer answer) {
  if (link_ == nullptr || ended() || draining_) {
    return answer(Refused(reasons::kGameAway,
                          "the game is not connected; try again when it has reconnected"));
  }
  AnswerOrder(order_id_, Refused(reasons::kOrderReplaced, "a later order replaced this one"));
  // An id derived from the time is greater than the ids of all earlier orders. An answer to an
  // order that was sent before a restart of the daemon therefore does not match this order.
  order_id_ = std::max(order_id_ + 1, static_cast<uint64_t>(order.now_ns) / 1'000 & kOrderIdMask);
  if (!takes_orders_) return answer(TakesNoOrders());
  MarkActive();
  decisions_.ObserveOrder(order);
  order_answer_ = std::move(answer);
  link_->SendOrder(order_id_, order);
  context_.loop.PostAt(order.now_ns + kOrderPatienceNs, [weak = weak_from_this(), id = order_id_] {
    const auto self = weak.lock();
    if (!self) return;
    self->AnswerOrder(id, Refused(reasons::kOrderUnanswered,
                                  "the game has not answered; it may execute the order later, or "
                                  "its version may not support orders"));
  });
}

void GameSession::AnswerOrder(uint64_t order_id, const absl::Status& status) {
  if (order_id != order_id_ || !order_answer_) return;
  std::exchange(order_answer_, nullptr)(status);
}

void GameSession::LoseOrder() {
  AnswerOrder(order_id_, Refused(reasons::kGameAway,
                                 "the connection to the game was lost before it answered; it may "
                                 "have executed the order"));
}

void GameSession::ScheduleTick(int64_t due_ns) {
  const uint64_t generation = ++timer_generation_;
  context_.loop.PostAt(due_ns, [weak = weak_from_this(), generation] {
    if (const auto self = weak.lock()) self->OnTimer(generation);
  });
}

void GameSession::OnTimer(uint64_t generation) {
  if (generation != timer_generation_ || link_ == nullptr) return;
  const int64_t now_ns = context_.loop.clock().NowNs();
  if (now_ns < decisions_.next_tick_ns()) return ScheduleTick(decisions_.next_tick_ns());
  if (!std::exchange(active_, false)) {
    RetryCommit();
    return ScheduleTick(now_ns + decisions_.setup().options.decision_interval_ns);
  }
  SendDecision(decisions_.Tick(now_ns));
  // Normally the posteriors travel to the client in the same message as the acknowledgement of this
  // decision's commit. If the store is still busy with the previous commit, or there is nothing to
  // commit, that message is not expected soon: send the posteriors now.
  const bool waits = ledger_->committing();
  Checkpoint();
  if (waits || !ledger_->committing()) link_->Flush();
  ScheduleTick(decisions_.next_tick_ns());
}

void GameSession::Checkpoint() {
  ledger_->Checkpoint({.message_sequence = applied_sequence_,
                       .explored_arm_count = decisions_.explored_arm_count(),
                       .decision_count = decisions_.decision_count(),
                       .frame_count = frame_count_});
}

void GameSession::KeepOpenEvidence() {
  if (ledger_->open()) Checkpoint();
}

void GameSession::OnCommitted(const absl::Status& status,
                              std::span<const priors::KeyedEvidence> increments) {
  if (superseded()) return LeaveToOther();
  // This commit has succeeded after a failed one. The failed commit may have reached the disk after
  // all. The observer's sums may then contain these increments already, so it must read them again.
  if (std::exchange(commit_failed_, !status.ok()) && status.ok())
    context_.observer.Reload(identity_.scene);
  if (!increments.empty()) {
    if (new_scene_) new_scene_->OnStored();
    context_.observer.OnEvidence(identity_.scene, increments,
                                 /*new_source=*/!std::exchange(has_stored_evidence_, true));
  }
  if (link_ == nullptr) return;
  if (durable_sequence() > acknowledged_sequence_) {
    acknowledged_sequence_ = durable_sequence();
    link_->SendAcknowledgement(acknowledged_sequence_);
  }
  link_->Flush();
  // If the store cannot write, close the link of an ending session at once. The client need not
  // wait, because it keeps the unacknowledged messages.
  if (!status.ok() && (ended() || draining_)) return CloseLink(status);
  CloseIfSettled();
}

// Called when another daemon has written this session to the store. The client is connected to that
// daemon, or has returned to this one. If it has returned, it must connect again: then the session
// is read from the store.
void GameSession::LeaveToOther() {
  ++timer_generation_;
  context_.observer.Reload(identity_.scene);
  if (link_ == nullptr) return;
  ReleaseLink().Close(Refused(reasons::kSessionTakenOver,
                              "another daemon has this session's latest evidence; connect again"));
}

ClientStream& GameSession::ReleaseLink() {
  LoseOrder();
  boxes_.Disconnect();
  return *std::exchange(link_, nullptr);
}

void GameSession::CloseIfSettled() {
  if ((ended() || draining_) && ledger_->settled()) CloseLink(absl::OkStatus());
}

void GameSession::CloseLink(const absl::Status& commit) {
  if (link_ == nullptr) return;
  ClientStream& link = ReleaseLink();
  if (!ended())
    return link.Close(Refused(reasons::kDraining, "the daemon is draining; connect again"));
  if (commit.ok()) return link.Close(absl::OkStatus());
  link.Close(
      Refused(reasons::kStoreFailed,
              absl::StrCat("the last evidence of the session is not on disk (", commit.message(),
                           "); the daemon keeps it in memory and tries again")));
}

void GameSession::Kick(bool may_return) {
  if (!may_return) {
    end_ = SessionEnd::kKicked;
    boxes_.End();
    ++timer_generation_;
    Checkpoint();
  }
  if (link_ == nullptr) return;
  ReleaseLink().Close(may_return ? Refused(reasons::kConnectionKicked,
                                           "an operator ended the connection; connect again")
                                 : SessionKicked());
}

void GameSession::PublishChange(SessionEnd end) const {
  context_.observer.OnSession(identity_.id, {.scene = identity_.scene, .end = end});
}

void GameSession::PublishEnd() {
  ReportUse();
  PublishChange(ended() ? end_ : SessionEnd::kForgotten);
  // A commit of this session may still be under way, and its result will not be reported. Therefore
  // the observer must read the scene again.
  if (!settled()) context_.observer.Reload(identity_.scene);
}

void GameSession::End() {
  end_ = SessionEnd::kGoodbye;
  boxes_.End();
  ++context_.counters.goodbye_count;
  ++timer_generation_;
  Checkpoint();
  CloseIfSettled();
}

void GameSession::Drain(uint32_t delay_ms) {
  draining_ = true;
  ++timer_generation_;
  ReportUse();
  if (link_ == nullptr) return;
  link_->SendReconnect(delay_ms);
  // Retry a failed commit now. The next tick would retry it, but there are no more ticks.
  RetryCommit();
  CloseIfSettled();
}

void GameSession::SendDecision(const decision::Decision& decision) {
  ++context_.counters.decision_count;
  if (decision.increment) AddEvidence(*decision.increment, {}, decision.regime);
  for (const decision::Increment& increment : decision.lane_increments)
    AddEvidence(increment, decision::kLaneName, decision.regime);
  PutPosteriors(decision);
  if (decision.command) {
    ++context_.counters.switch_command_count;
    unanswered_ = decision.command;
    if (link_ != nullptr) link_->SendSwitch(*decision.command);
  }
  PublishDecision(decision.record);
}

// Puts the posteriors into the next message to the client, if they or the verdict have changed.
void GameSession::PutPosteriors(const decision::Decision& decision) {
  const decision::Diagnosis& diagnosis = decision.record.diagnosis;
  const bool learnt = decision.increment || !decision.lane_increments.empty();
  if (link_ == nullptr || (!learnt && diagnosis.verdict == sent_verdict_)) return;
  link_->PutSnapshot(decision.record);
  sent_verdict_ = diagnosis.verdict;
}

void GameSession::ReportUse() {
  if (use_.is_empty() || !context_.options.on_use) return;
  context_.options.on_use(
      identity_, use_.Take(decisions_.total_use(), decisions_.initial_arm(), priors::UnixNowMs()));
}

void GameSession::PublishDecision(const decision::DecisionRecord& record) {
  if (use_.IsDue(priors::UnixNowMs())) ReportUse();
  if (!context_.observer.Watches(identity_.scene)) return measured_.reset();
  if (!measured_) measured_.emplace();
  const bool is_due = !measured_->empty() && record.time_ns >= next_measurements_ns_;
  context_.observer.OnDecision({.session = identity_,
                                .record = record,
                                .unix_ms = priors::UnixNowMs(),
                                .measurements = is_due ? &*measured_ : nullptr});
  if (!is_due) return;
  measured_->Clear();
  next_measurements_ns_ = record.time_ns + SessionObserver::kIntervalNs;
}

void GameSession::AddEvidence(const decision::Increment& increment, std::string_view measured_by,
                              const std::string& regime) {
  const uint32_t arm = increment.arm;
  if (!identity_.kept_arms[arm]) return;
  ledger_->Add(
      {EvidenceKeyOf(identity_.scene, identity_.arms[arm], identity_.backend_versions[arm],
                     measured_by, regime),
       {increment.alpha, increment.beta, increment.window_count, increment.bail_out_count}});
}

}  // namespace sweepstake::sessions
