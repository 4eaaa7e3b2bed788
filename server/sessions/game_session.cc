#include "server/sessions/game_session.h"

#include <algorithm>
#include <utility>

#include "absl/strings/str_cat.h"
#include "engine_client/decider/pooling/scene_prior.h"
#include "engine_client/decider/session/arm_runs.h"
#include "engine_client/decider/session/policy_registry.h"
#include "server/rpc/common/error_reasons.h"
#include "server/rpc/common/message_validation.h"
#include "server/rpc/common/proto_conversion.h"
#include "server/sessions/unix_time.h"

namespace sweepstake::rpc {
namespace {

constexpr int64_t kOrderPatienceNs = 5'000'000'000;
// A game keeps 48 bits of an order's id.
constexpr uint64_t kOrderIdMask = (uint64_t{1} << 48) - 1;

absl::Status TakesNoOrders() {
  return Refused(v1::ERROR_REASON_ORDER_REFUSED,
                 "this game takes no orders; build it with allow_operator_orders");
}

void Count(RejectionReason reason, RejectionCounts& counts) {
  ++counts.at(static_cast<size_t>(reason));
}

// Returns whether the sample cannot have been measured, and counts it then.
template <typename Sample>
bool IsRejected(const Sample& sample, RejectionCounts& counts) {
  const std::optional<RejectionReason> reason = RejectionOf(sample);
  if (reason) Count(*reason, counts);
  return reason.has_value();
}

}  // namespace

absl::Status UnknownSession() {
  return Refused(v1::ERROR_REASON_UNKNOWN_SESSION,
                 "there is no such session in memory; list those that there are");
}

absl::Status SessionKicked() {
  return Refused(v1::ERROR_REASON_SESSION_KICKED,
                 "an operator ended the session; do not come back");
}

std::shared_ptr<GameSession> GameSession::Create(SessionContext& context, SessionIdentity identity,
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
  session->ledger_->SetOrigin(
      {.build = session->identity_.build, .token_id = session->identity_.token_id});
  return session;
}

GameSession::GameSession(SessionContext& context, SessionIdentity identity,
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
      boxes_(context.loop, context.watch_hub) {
  ++context_.counters.session_count;
}

void GameSession::Hear() {
  heard_ = true;
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
        Refused(v1::ERROR_REASON_SESSION_TAKEN_OVER, "another connection took this session over"));
  }
  LoseOrder();
  boxes_.Disconnect();
  link_ = &link;
  // The welcome message acknowledges this number.
  acknowledged_sequence_ = durable_sequence();
  sent_verdict_ = Verdict::kUnknown;
}

void GameSession::Start(const v1::Hello& hello) {
  takes_orders_ = Has(hello, v1::CAPABILITY_OPERATOR_ORDERS);
  boxes_.Connect(*link_, Has(hello, v1::CAPABILITY_BOX_VIEW));
  const auto mode = FromProto(hello.mode());
  const int64_t now_ns = context_.loop.clock().NowNs();
  if (mode != decisions_.mode()) {
    Hear();
    decisions_.SetMode(mode, hello.active_arm(), now_ns);
  }
  TellChange();
  if (unanswered_) link_->SendSwitch(*unanswered_);
  if (!decisions_.waits_for_frames()) Hear();
  ScheduleTick(decisions_.next_tick_ns());
}

void GameSession::Detach(ClientStream& link) {
  if (link_ != &link) return;
  link_ = nullptr;
  ++timer_generation_;
  boxes_.Disconnect();
  LoseOrder();
}

void GameSession::Apply(const v1::StreamTelemetryRequest& request) {
  last_message_ns_ = context_.loop.clock().NowNs();
  if (request.sequence() <= applied_sequence_) {
    ++context_.counters.replayed_message_count;
    return;
  }
  applied_sequence_ = request.sequence();
  Hear();
  if (IsUnknown(request)) {
    ++context_.counters.unknown_message_count;
    return;
  }
  ApplyEvidence(request);
  ++context_.counters.applied_message_count;
}

void GameSession::ApplyEvidence(const v1::StreamTelemetryRequest& request) {
  switch (request.message_case()) {
    case v1::StreamTelemetryRequest::kFrameBatch:
      return ApplyFrames(request.frame_batch());
    case v1::StreamTelemetryRequest::kSwitchOutcome:
      return ApplySwitchOutcome(request.switch_outcome());
    case v1::StreamTelemetryRequest::kBailOut:
      return ApplyBailOut(request.bail_out());
    case v1::StreamTelemetryRequest::kModeChange:
      return ApplyModeChange(request.mode_change());
    case v1::StreamTelemetryRequest::kOrderRefusal:
      return ApplyOrderRefusal(request.order_refusal());
    default:
      return;
  }
}

void GameSession::ApplyFrames(const v1::FrameBatch& batch) {
  frames_.clear();
  for (int i = 0; i < batch.frame_time_ns_size(); ++i) {
    FrameSample frame = FrameFromProto(batch, i);
    // The flag is the client's word; only the time makes a bail-out.
    if (!IsOverLimit(frame)) frame.flags &= ~kFrameBailOut;
    if (!IsRejected(frame, context_.counters.rejected_frame_counts)) frames_.push_back(frame);
  }
  frame_count_ += static_cast<uint64_t>(batch.frame_time_ns_size());
  context_.counters.accepted_frame_count += frames_.size();
  context_.counters.dropped_frame_count += batch.dropped_frame_count();
  dropped_frame_count_ += batch.dropped_frame_count();
  decisions_.ObserveFrames(frames_);
  if (measured_) Measure();
  ApplyShadows(batch);
  if (batch.has_scene_descriptor()) {
    decisions_.ObserveDescriptor(FromProto(batch.scene_descriptor()));
  }
}

void GameSession::Measure() {
  for (const FrameSample& frame : frames_) {
    if ((frame.flags & (kFramePaused | kFrameLoading)) != 0) continue;
    measured_->Add(frame.frame_time_ns, frame.detection_time_ns, frame.native_bytes);
  }
}

void GameSession::ApplyShadows(const v1::FrameBatch& batch) {
  shadows_.clear();
  for (const v1::ShadowSample& message : batch.shadow_samples()) {
    const ShadowSample sample = FromProto(message);
    if (!IsRejected(sample, context_.counters.rejected_shadow_counts)) shadows_.push_back(sample);
  }
  context_.counters.accepted_shadow_count += shadows_.size();
  decisions_.ObserveShadow(shadows_);
}

void GameSession::ApplySwitchOutcome(const v1::SwitchOutcome& outcome) {
  if (unanswered_ && outcome.command_id() == unanswered_->command_id) unanswered_.reset();
  if (!outcome.executed()) {
    ++context_.counters.refused_switch_count;
    return decisions_.ObserveRefusal(outcome.command_id());
  }
  // A resent message may be older than the state in the client's Hello.
  if (decision::IsLaterEpoch(switch_epoch_, outcome.switch_epoch())) return;
  switch_epoch_ = outcome.switch_epoch();
  decisions_.ObserveSwitch(outcome.arm(), outcome.switch_epoch(), FromProto(outcome.reason()),
                           context_.loop.clock().NowNs(), FromProto(outcome));
  TellChange();
}

void GameSession::ApplyBailOut(const v1::BailOut& bail_out) {
  if (last_bail_out_frame_ && bail_out.frame_index() <= *last_bail_out_frame_) return;
  last_bail_out_frame_ = bail_out.frame_index();
  FrameSample frame = FromProto(bail_out);
  if (IsRejected(frame, context_.counters.rejected_frame_counts)) return;
  if (!IsOverLimit(frame)) {
    Count(RejectionReason::kFrameTime, context_.counters.rejected_frame_counts);
    return;
  }
  const int64_t now_ns = context_.loop.clock().NowNs();
  // What the session itself does not believe spends nothing of the others'.
  if (decisions_.IsEvidence(frame, now_ns) && link_ != nullptr && !link_->SpendBailOut())
    frame.flags |= decision::kFrameNoEvidence;
  // The evidence of the bail-out goes to disk with the next tick, not now: its sequence number
  // would also acknowledge the frames before it, which are only in memory until then.
  const uint64_t surplus_count = decisions_.counts().surplus_bail_out_count;
  SendDecision(decisions_.ObserveBailOut(frame, now_ns));
  if (link_ != nullptr) link_->Flush();
  context_.counters.surplus_bail_out_count +=
      decisions_.counts().surplus_bail_out_count - surplus_count;
}

bool GameSession::IsOverLimit(const FrameSample& frame) const {
  return frame.frame_time_ns > static_cast<uint64_t>(identity_.decision.bail_out_ns);
}

void GameSession::ApplyModeChange(const v1::ModeChange& change) {
  decisions_.SetMode(FromProto(change.mode()), change.active_arm(), context_.loop.clock().NowNs());
  unanswered_.reset();
  AnswerOrder(change.order_id(), absl::OkStatus());
  TellChange();
}

void GameSession::ApplyOrderRefusal(const v1::OrderRefusal& refusal) {
  AnswerOrder(refusal.order_id(), refusal.reason() == v1::ORDER_REFUSAL_REASON_NOT_ALLOWED
                                      ? TakesNoOrders()
                                      : Refused(v1::ERROR_REASON_ORDER_REFUSED,
                                                "the game does not know such an order; update it"));
}

void GameSession::Order(const decision::OrderReport& order, OrderAnswer answer) {
  if (link_ == nullptr || ended() || draining_) {
    return answer(Refused(v1::ERROR_REASON_GAME_AWAY,
                          "the game is not connected; try again when it has come back"));
  }
  AnswerOrder(order_id_, Refused(v1::ERROR_REASON_ORDER_REPLACED, "a later order took its place"));
  // An answer may come from before a restart of the daemon, which knows no number of then.
  order_id_ = std::max(order_id_ + 1, static_cast<uint64_t>(order.now_ns) / 1'000 & kOrderIdMask);
  if (!takes_orders_) return answer(TakesNoOrders());
  Hear();
  decisions_.ObserveOrder(order);
  order_answer_ = std::move(answer);
  link_->SendOrder(order_id_, order);
  context_.loop.PostAt(order.now_ns + kOrderPatienceNs, [weak = weak_from_this(), id = order_id_] {
    const auto self = weak.lock();
    if (!self) return;
    self->AnswerOrder(id, Refused(v1::ERROR_REASON_ORDER_UNANSWERED,
                                  "the game has not answered; it may obey yet, or be too old"));
  });
}

void GameSession::AnswerOrder(uint64_t order_id, const absl::Status& status) {
  if (order_id != order_id_ || !order_answer_) return;
  std::exchange(order_answer_, nullptr)(status);
}

void GameSession::LoseOrder() {
  AnswerOrder(order_id_, Refused(v1::ERROR_REASON_GAME_AWAY,
                                 "the game was lost before it answered; it may have obeyed"));
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
  if (!std::exchange(heard_, false)) {
    RetryCommit();
    return ScheduleTick(now_ns + decisions_.setup().options.decision_interval_ns);
  }
  SendDecision(decisions_.Tick(now_ns));
  // What the decision commits is acknowledged soon; the posteriors go to the client with it, unless
  // the store still has the last commit.
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
  // The store may have had them since the commit that seemed to fail, and watched sums with it.
  if (std::exchange(commit_failed_, !status.ok()) && status.ok())
    context_.watch_hub.Forget(identity_.scene);
  if (!increments.empty()) {
    if (new_scene_) new_scene_->OnStored();
    context_.watch_hub.OnEvidence(identity_.scene, increments,
                                  /*new_source=*/!std::exchange(has_stored_evidence_, true));
  }
  if (link_ == nullptr) return;
  if (durable_sequence() > acknowledged_sequence_) {
    acknowledged_sequence_ = durable_sequence();
    link_->SendAcknowledgement(acknowledged_sequence_);
  }
  link_->Flush();
  // If the store cannot write, the client need not wait: it keeps what is not acknowledged.
  if (!status.ok() && (ended() || draining_)) return CloseLink(status);
  CloseIfSettled();
}

// The client is there already, or has come back from there; then it begins from the store again.
void GameSession::LeaveToOther() {
  ++timer_generation_;
  context_.watch_hub.Reload(identity_.scene);
  if (link_ == nullptr) return;
  LoseOrder();
  boxes_.Disconnect();
  std::exchange(link_, nullptr)
      ->Close(Refused(v1::ERROR_REASON_SESSION_TAKEN_OVER,
                      "another daemon has this session's latest evidence; connect again"));
}

void GameSession::CloseIfSettled() {
  if ((ended() || draining_) && ledger_->settled()) CloseLink(absl::OkStatus());
}

void GameSession::CloseLink(const absl::Status& commit) {
  if (link_ == nullptr) return;
  LoseOrder();
  boxes_.Disconnect();
  ClientStream* link = std::exchange(link_, nullptr);
  if (!ended())
    return link->Close(Refused(v1::ERROR_REASON_DRAINING, "the daemon is draining; connect again"));
  if (commit.ok()) return link->Close(absl::OkStatus());
  link->Close(
      Refused(v1::ERROR_REASON_STORE_FAILED,
              absl::StrCat("the last evidence of the session is not on disk (", commit.message(),
                           "); while the daemon runs it keeps it and tries again")));
}

void GameSession::Kick(bool may_return) {
  if (!may_return) {
    end_ = watch::SessionEnd::kKicked;
    boxes_.End();
    ++timer_generation_;
    Checkpoint();
  }
  if (link_ == nullptr) return;
  LoseOrder();
  boxes_.Disconnect();
  ClientStream* link = std::exchange(link_, nullptr);
  link->Close(may_return ? Refused(v1::ERROR_REASON_CONNECTION_KICKED,
                                   "an operator ended the connection; connect again")
                         : SessionKicked());
}

void GameSession::TellChange(watch::SessionEnd end) const {
  context_.watch_hub.OnSession(identity_.id, {.scene = identity_.scene, .end = end});
}

void GameSession::TellEnd() const {
  TellChange(ended() ? end_ : watch::SessionEnd::kForgotten);
  // The store may have, or get, a commit whose answer nobody is going to hear.
  if (!settled()) context_.watch_hub.Reload(identity_.scene);
}

void GameSession::End() {
  end_ = watch::SessionEnd::kGoodbye;
  boxes_.End();
  ++context_.counters.goodbye_count;
  ++timer_generation_;
  Checkpoint();
  CloseIfSettled();
}

void GameSession::Drain(uint32_t delay_ms) {
  draining_ = true;
  ++timer_generation_;
  if (link_ == nullptr) return;
  link_->SendReconnect(delay_ms);
  // A commit that has failed would otherwise wait for the next tick, and there is none.
  RetryCommit();
  CloseIfSettled();
}

void GameSession::SendDecision(const decision::Decision& decision) {
  ++context_.counters.decision_count;
  if (decision.increment) AddEvidence(*decision.increment, {});
  for (const decision::Increment& increment : decision.lane_increments)
    AddEvidence(increment, decision::kLaneName);
  PutPosteriors(decision);
  if (decision.command) {
    ++context_.counters.switch_command_count;
    unanswered_ = decision.command;
    if (link_ != nullptr) link_->SendSwitch(*decision.command);
  }
  TellWatchers(decision.record);
}

// Tells the client changed posteriors or a changed verdict.
void GameSession::PutPosteriors(const decision::Decision& decision) {
  const decision::Diagnosis& diagnosis = decision.record.diagnosis;
  const bool learnt = decision.increment || !decision.lane_increments.empty();
  if (link_ == nullptr || (!learnt && diagnosis.verdict == sent_verdict_)) return;
  link_->PutSnapshot(decision.record);
  sent_verdict_ = diagnosis.verdict;
}

void GameSession::TellWatchers(const decision::DecisionRecord& record) {
  if (!context_.watch_hub.Watches(identity_.scene)) return measured_.reset();
  v1::DecisionEvent event;
  ToProto(record, identity_, event);
  event.set_unix_ms(priors::UnixNowMs());
  TellMeasurements(record.time_ns, event);
  context_.watch_hub.OnDecision(identity_.scene, event);
}

void GameSession::TellMeasurements(int64_t now_ns, v1::DecisionEvent& event) {
  if (!measured_) measured_.emplace();
  if (measured_->empty() || now_ns < next_measurements_ns_) return;
  ToProto(*measured_, *event.mutable_measurements());
  measured_->Clear();
  next_measurements_ns_ = now_ns + watch::WatchHub::kIntervalNs;
}

void GameSession::AddEvidence(const decision::Increment& increment, std::string_view measured_by) {
  const uint32_t arm = increment.arm;
  ledger_->Add(
      {EvidenceKeyOf(identity_.scene, identity_.arms[arm], identity_.backend_versions[arm],
                     measured_by),
       {increment.alpha, increment.beta, increment.window_count, increment.bail_out_count}});
}

}  // namespace sweepstake::rpc
