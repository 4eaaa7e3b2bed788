#include "engine_client/telemetry/protocol/session_link.h"

#include <algorithm>
#include <cassert>
#include <cmath>
#include <utility>

#include "engine_client/decider/session/policy_registry.h"
#include "engine_client/telemetry/common/decider_loop.h"
#include "engine_client/telemetry/protocol/wire.h"
#include "engine_client/text/names.h"
#include "sweepstake/machine_class.h"

namespace sweepstake {
namespace {

// Maximum time for the daemon to answer Hello, and to end a stream after the client has closed its
// side. After that the stream is cancelled.
constexpr uint64_t kAnswerTimeoutNs = 10'000 * kNsPerMs;
// If a connection lasted at least this long, the next back-off starts from its minimum again.
constexpr uint64_t kGoodConnectionNs = 1'000 * kNsPerMs;
// After a refused token, the delay before the next attempt is this number times Backoff::LongMs.
constexpr uint32_t kTokenDelayFactor = 6;
// Maximum length, in bytes, of a status message in log lines and errors.
constexpr size_t kMaxEndBytes = 256;

// The gRPC status codes that this file distinguishes.
enum GrpcCode : uint32_t {
  kGrpcOk = 0,
  kGrpcInvalidArgument = 3,
  kGrpcNotFound = 5,
  kGrpcPermissionDenied = 7,
  kGrpcFailedPrecondition = 9,
  kGrpcUnimplemented = 12,
  kGrpcUnavailable = 14,
  kGrpcUnauthenticated = 16,
};

protocol::Hello MakeHello(const SessionOptions& options, const AdaptiveBroadPhase& adaptive) {
  protocol::Hello hello;
  hello.protocol_version = protocol::kVersion;
  using protocol::Capability;
  if (options.allow_operator_orders) hello.capabilities.push_back(Capability::kOperatorOrders);
  if (options.allow_box_view) hello.capabilities.push_back(Capability::kBoxView);
  hello.capabilities.push_back(Capability::kStopsTrials);  // AdaptiveBroadPhase does
  hello.project = options.project;
  hello.scene = options.scene;
  hello.build = options.build;
  hello.machine_class = options.machine_class.empty() ? MachineClass() : options.machine_class;
  for (size_t arm = 0; arm < adaptive.arms().size(); ++arm)
    hello.arms.push_back(
        {.name = adaptive.arms()[arm], .backend_version = adaptive.arm_versions()[arm]});
  hello.time_scale = options.time_scale;
  hello.ignore_priors = options.ignore_priors;
  hello.seed = options.seed;
  hello.policy = options.policy;
  hello.rules = options.rules;
  hello.initial_arm = adaptive.initial_arm();
  return hello;
}

BatchLimits LimitsOf(const SessionOptions& options) {
  return {.interval_ns = options.batch_interval_ms * kNsPerMs,
          .frames = options.batch_frames,
          .bytes = options.batch_bytes};
}

// Returns the limits of a batch. A daemon may require smaller batches than the options. At least
// two batches are sent per decision interval, so that each decision has frames.
BatchLimits LimitsOf(const SessionOptions& options, const protocol::Welcome& welcome) {
  uint64_t interval_ms = options.batch_interval_ms;
  if (welcome.batch_interval_ms > 0) interval_ms = welcome.batch_interval_ms;
  if (welcome.decision_interval_ms > 0)
    interval_ms = std::min<uint64_t>(interval_ms, welcome.decision_interval_ms / 2 + 1);
  BatchLimits limits = LimitsOf(options);
  limits.interval_ns = interval_ms * kNsPerMs;
  if (welcome.max_batch_frames > 0)
    limits.frames = std::min({limits.frames, welcome.max_batch_frames, protocol::kMaxBatchFrames});
  if (welcome.max_message_bytes > 0)
    limits.bytes = std::min(limits.bytes, welcome.max_message_bytes);
  return limits;
}

// Returns whether the policy learns from the shadow lane. A policy of a newer daemon may do so.
bool UsesShadow(std::string_view policy) {
  const decision::PolicyEntry* known = decision::FindPolicy(policy, decision::ShippedPolicies());
  return known == nullptr || known->kind.uses_shadow;
}

// Returns the rules in the welcome; none before the first welcome.
DecisionRules RulesOf(const protocol::Welcome& welcome) {
  if (welcome.session_id.empty()) return {};
  return {.weights = welcome.weights,
          .decision_interval_ns = welcome.decision_interval_ms * kNsPerMs,
          .cooldown_ns = welcome.cooldown_ms * kNsPerMs,
          .settling_ns = welcome.settling_ms * kNsPerMs};
}

bool Has(const protocol::Welcome& welcome, protocol::Capability capability) {
  const auto& chosen = welcome.capabilities;
  return std::find(chosen.begin(), chosen.end(), capability) != chosen.end();
}

// Returns whether the daemon refused the session for a reason that is likely to persist, so that an
// early retry would fail too.
bool IsLasting(uint32_t code) {
  return code == kGrpcInvalidArgument || code == kGrpcFailedPrecondition ||
         code == kGrpcUnauthenticated || code == kGrpcPermissionDenied ||
         code == kGrpcUnimplemented;
}

// Returns whether the daemon refused the token. Retries are then rare, because only a person can
// replace the token.
bool IsTokenRefused(uint32_t code, const std::string& reason) {
  return code == kGrpcUnauthenticated || reason == "TOO_MANY_FAILURES";
}

// Makes a received text, which can contain any bytes, safe for one line of a log.
std::string OneLine(std::string_view text) {
  const std::string_view beginning = text.substr(0, kMaxEndBytes);
  return text::IsLine(beginning) ? std::string(beginning) : text::PrintableLine(beginning);
}

StreamEnd Readable(StreamEnd end) {
  end.message = OneLine(end.message);
  if (!end.advice.empty()) end.message += "; " + end.advice;
  return end;
}

std::string TryingAgain(uint32_t delay_ms) {
  return "; trying again in " + std::to_string(delay_ms) + " ms";
}

std::string WithReason(const std::string& message, const std::string& reason) {
  return reason.empty() ? message : message + " (" + reason + ")";
}

std::string Describe(const StreamEnd& end, const std::string& reason, const std::string& daemon) {
  std::string what = daemon + " ended the connection";
  // A status with details was made by the daemon, so in that case there was a connection.
  if (end.code == kGrpcUnavailable && end.details.empty()) what = "no connection to " + daemon;
  if (IsLasting(end.code)) what = daemon + " refuses the session";
  return end.message.empty() ? what : what + ": " + WithReason(end.message, reason);
}

bool IsKnown(SwitchReason reason) {
  return reason >= SwitchReason::kPolicy && reason <= SwitchReason::kManual;
}

bool IsBeta(const decision::BetaPosterior& posterior) {
  return std::isfinite(posterior.alpha) && std::isfinite(posterior.beta) && posterior.alpha > 0 &&
         posterior.beta > 0;
}

bool IsRatio(const CostRatio& ratio) {
  return ratio.low >= 0 && ratio.low <= ratio.median && ratio.median <= ratio.high &&
         std::isfinite(ratio.high);
}

bool IsStanding(const ArmStanding& standing) {
  return std::isfinite(standing.effective_window_count) && standing.effective_window_count >= 0 &&
         standing.best_probability >= 0 && standing.best_probability <= 1 &&
         (!standing.cost_ratio || IsRatio(*standing.cost_ratio));
}

}  // namespace

SessionLink::SessionLink(const SessionOptions& options, std::string daemon, uint64_t jitter_seed,
                         SampleQueue& queue, AdaptiveBroadPhase& adaptive)
    : options_(options),
      daemon_(std::move(daemon)),
      adaptive_(adaptive),
      state_(MakeHello(options, adaptive), options.unacknowledged_messages),
      intake_(queue, state_, LimitsOf(options)),
      boxes_(adaptive.view_tap()),
      backoff_(options.backoff_min_ms, options.backoff_max_ms, jitter_seed) {}

void SessionLink::Connected(uint64_t now_ns) {
  assert(!stream_ && !finished());
  stream_.emplace();
  stream_->deadline_ns = now_ns + kAnswerTimeoutNs;
}

LinkAction SessionLink::Advance(uint64_t now_ns) {
  const bool queue_empty = taken_all_ || intake_.Pump(now_ns);
  if (goodbye_deadline_ns_ || !state_.online()) boxes_.Stop();
  next_is_view_ = boxes_.Advance(now_ns);
  next_ = stream_ ? NextStep(queue_empty, now_ns) : LinkAction::kNone;
  if (next_ == LinkAction::kSend) next_message_ = NextMessage();
  return next_;
}

// Returns the next action for the open stream. REQUIRES: stream_ is present.
LinkAction SessionLink::NextStep(bool queue_empty, uint64_t now_ns) {
  if (goodbye_deadline_ns_ && now_ns >= *goodbye_deadline_ns_) GiveUp();
  if (stream_->IsBeingCancelled() || Overdue(now_ns)) return LinkAction::kCancel;
  if (!stream_->hello_sent) return LinkAction::kSend;
  if (stream_->finished || !state_.online()) return LinkAction::kNone;
  if (stream_->reconnect_delay_ms || stream_->goodbye_sent) return LinkAction::kFinish;
  const bool goodbye_is_due = goodbye_deadline_ns_ && queue_empty;
  if (goodbye_is_due && !std::exchange(taken_all_, true)) intake_.Flush();
  const bool has_evidence = state_.Next() != nullptr;
  next_is_view_ = next_is_view_ && !has_evidence;
  return goodbye_is_due || has_evidence || next_is_view_ ? LinkAction::kSend : LinkAction::kNone;
}

bool SessionLink::Overdue(uint64_t now_ns) {
  const bool waiting = !state_.online() || stream_->finished;
  if (!waiting || now_ns < stream_->deadline_ns) return false;
  stream_->fault = stream_->finished ? "did not end the connection" : "has not answered";
  return true;
}

// Returns the next message to send. REQUIRES: there is one.
std::string SessionLink::NextMessage() {
  if (!stream_->hello_sent) {
    return protocol::Encode(state_.Connect({.active_arm = adaptive_.active_arm(),
                                            .switch_epoch = adaptive_.switch_epoch(),
                                            .mode = adaptive_.mode()}));
  }
  if (next_is_view_) return std::string(boxes_.message());
  const ResendBuffer::Entry* next = state_.Next();
  return next != nullptr ? protocol::Numbered(next->sequence, next->evidence.message)
                         : protocol::Encode(protocol::Goodbye{});
}

std::string SessionLink::Take(uint64_t now_ns) {
  assert(next_ == LinkAction::kSend || next_ == LinkAction::kFinish);
  if (std::exchange(next_, LinkAction::kNone) == LinkAction::kFinish) {
    stream_->finished = true;
    stream_->deadline_ns = now_ns + kAnswerTimeoutNs;
    return "";
  }
  if (!stream_->hello_sent) {
    stream_->hello_sent = true;
  } else if (next_is_view_) {
    boxes_.MarkSent();
  } else if (state_.Next() != nullptr) {
    state_.MarkSent();
  } else {
    stream_->goodbye_sent = true;
  }
  return std::move(next_message_);
}

Status SessionLink::OnMessage(std::string_view bytes, uint64_t now_ns) {
  if (!stream_) {
    return {StatusCode::kFailedPrecondition,
            "a message arrived, but no connection was reported; report the connection first"};
  }
  if (stream_->IsBeingCancelled()) return {};
  const std::optional<protocol::Response> response = protocol::DecodeResponse(bytes);
  if (!response) {
    stream_->fault = "sent a message that cannot be read";
    return {StatusCode::kDataLoss, daemon_ + " " + stream_->fault};
  }
  if (response->welcome) OnWelcome(*response->welcome, now_ns);
  if (!state_.online()) return {};  // Messages before Welcome are ignored.
  if (response->switch_command) OnCommand(*response->switch_command, now_ns);
  if (response->acknowledgement) OnAcknowledgement(*response->acknowledgement);
  if (response->posterior_snapshot) {
    TakeBeliefs(response->posterior_snapshot->arms);
    TakeStandings(response->posterior_snapshot->standings);
    TakeVerdict(response->posterior_snapshot->verdict);
    TakeSaving(response->posterior_snapshot->saved_us);
  }
  if (response->reconnect) stream_->reconnect_delay_ms = response->reconnect->delay_ms;
  if (response->operator_order) OnOrder(*response->operator_order);
  if (response->box_request && shows_boxes_) boxes_.OnRequest(*response->box_request, now_ns);
  if (response->has_unknown) ++unknown_message_count_;
  return {};
}

void SessionLink::OnWelcome(const protocol::Welcome& welcome, uint64_t now_ns) {
  if (state_.online()) return;  // A second Welcome on one connection is ignored.
  if (welcome.session_id.empty()) {
    stream_->fault = "sent a welcome without a session id";
    return;
  }
  state_.OnWelcome(welcome);
  stream_->online_since_ns = now_ns;
  last_error_.clear();
  refusal_.clear();
  takes_orders_ =
      options_.allow_operator_orders && Has(welcome, protocol::Capability::kOperatorOrders);
  shows_boxes_ = options_.allow_box_view && Has(welcome, protocol::Capability::kBoxView);
  welcome_ = welcome;
  intake_.SetLimits(LimitsOf(options_, welcome));
  TakeBeliefs(welcome.priors);
  adaptive_.SetSettling(welcome.settling_ms * kNsPerMs);
  adaptive_.SetLaneUse(UsesShadow(welcome.policy));
  adaptive_.SetBailOutLimit(welcome.bail_out_ms * kNsPerMs);
  adaptive_.SetDeciderPresent(true);
}

void SessionLink::OnAcknowledgement(const protocol::Acknowledgement& message) {
  state_.OnAcknowledgement(message.sequence);
  if (message.batch_interval_ms == 0) return;
  welcome_.batch_interval_ms = message.batch_interval_ms;
  intake_.SetLimits(LimitsOf(options_, welcome_));
}

void SessionLink::OnCommand(const SwitchCommand& command, uint64_t now_ns) {
  // An unknown reason comes from a newer protocol. The SwitchOutcome would have to repeat that
  // reason, so the command is ignored.
  if (!IsKnown(command.reason)) {
    ++unknown_message_count_;
    return;
  }
  ++command_count_;
  if (command.arm < adaptive_.arms().size()) {
    last_decision_ = {.time_ns = now_ns,
                      .active_arm = adaptive_.active_arm(),
                      .outcome = DecisionOutcome::kSwitched,
                      .candidate_arm = command.arm,
                      .command = command,
                      .verdict = verdict_};
    adaptive_.SetLastDecision(last_decision_);
    return adaptive_.mailbox().Post(command);
  }
  Answer(protocol::Encode(SwitchOutcome{.command_id = command.command_id,
                                        .arm = adaptive_.active_arm(),
                                        .switch_epoch = adaptive_.switch_epoch(),
                                        .reason = command.reason}));
}

void SessionLink::OnOrder(const OperatorOrder& order) {
  const bool known = (order.mode == Mode::kManual || order.mode == Mode::kAi) &&
                     (!order.arm || *order.arm < adaptive_.arms().size());
  if (takes_orders_ && known && adaptive_.Obey(order)) return;
  const auto reason = takes_orders_ && !known ? protocol::OrderRefusalReason::kUnknown
                                              : protocol::OrderRefusalReason::kNotAllowed;
  Answer(protocol::Encode(protocol::OrderRefusal{.order_id = order.order_id, .reason = reason}));
}

// Adds an answer to the messages to send. If the buffer is full, ends the stream instead. That
// limits the memory if a daemon keeps sending commands but never acknowledges the answers.
void SessionLink::Answer(std::string message) {
  if (state_.full()) {
    stream_->fault = "did not acknowledge the game's refusals of orders and commands";
    return;
  }
  state_.Append({std::move(message)});
}

// Stores the beliefs if there is one per arm and all are valid.
void SessionLink::TakeBeliefs(const std::vector<decision::BetaPosterior>& posteriors) {
  const std::span<const std::string> arms = adaptive_.arms();
  if (posteriors.size() != arms.size()) return;
  if (!std::all_of(posteriors.begin(), posteriors.end(), IsBeta)) return;
  beliefs_.clear();
  for (const decision::BetaPosterior& posterior : posteriors)
    beliefs_.push_back({arms[beliefs_.size()], posterior.alpha, posterior.beta});
  SetPosteriorMeans(beliefs_, adaptive_);
}

// Stores the standings if there is one per belief and all are valid.
void SessionLink::TakeStandings(const std::vector<ArmStanding>& standings) {
  if (standings.size() != beliefs_.size()) return;
  if (!std::all_of(standings.begin(), standings.end(), IsStanding)) return;
  for (size_t arm = 0; arm < standings.size(); ++arm) beliefs_[arm].standing = standings[arm];
}

// Stores the verdict. Ignores a verdict that only a newer protocol defines, or that has values out
// of range.
void SessionLink::TakeVerdict(const SceneVerdict& verdict) {
  if (verdict.verdict > Verdict::kDegraded) {
    ++unknown_message_count_;
    return;
  }
  const double probability = verdict.leader_probability;
  if (verdict.leader_arm >= adaptive_.arms().size() || !(probability >= 0 && probability <= 1))
    return;
  verdict_ = verdict;
  adaptive_.SetVerdict(verdict_);
  if (!last_decision_.command) return;
  last_decision_.verdict = verdict_;
  adaptive_.SetLastDecision(last_decision_);
}

// Stores the saving unless it is not a finite number.
void SessionLink::TakeSaving(std::optional<double> saved_us) {
  if (!saved_us || std::isfinite(*saved_us)) saved_us_ = saved_us;
}

std::optional<uint32_t> SessionLink::Disconnected(const StreamEnd& given, uint64_t now_ns) {
  if (finished()) {
    stream_.reset();
    return std::nullopt;
  }
  std::optional<protocol::DaemonStatus> status = protocol::StatusIn(given.details);
  StreamEnd end = given;
  if (status) {
    end.code = status->code;
    end.message = std::move(status->message);
  }
  end = Readable(std::move(end));
  if (!stream_) {
    const uint32_t delay_ms = backoff_.LongMs();
    last_error_ = (end.message.empty() ? "no stream to " + daemon_ : end.message);
    last_error_ += TryingAgain(delay_ms);
    return delay_ms;
  }
  const LinkStream stream = *std::exchange(stream_, std::nullopt);
  const std::string reason = status ? status->reason : "";
  adaptive_.SetDeciderPresent(false);
  if (reason == "FOREIGN_SESSION") state_.ForgetSession();
  state_.Disconnect(end.code == kGrpcNotFound, end.code == kGrpcInvalidArgument);
  const bool went_wrong = Explain(end, reason, stream);
  const uint32_t delay_ms = DelayMs(end, reason, stream, now_ns);
  if (finished() || reason == "SESSION_KICKED") return std::nullopt;
  if (went_wrong) last_error_ += TryingAgain(delay_ms);
  return delay_ms;
}

// Sets last_error_ and refusal_ from the end of the stream. Returns false if the stream ended as
// intended.
bool SessionLink::Explain(const StreamEnd& end, const std::string& reason,
                          const LinkStream& stream) {
  const bool refused = end.code == kGrpcInvalidArgument || IsTokenRefused(end.code, reason) ||
                       reason == "NOT_ALLOWED" || reason == "PROTOCOL_VERSION";
  refusal_ = refused ? WithReason(end.message, reason) : "";
  if (!stream.fault.empty()) {
    last_error_ = daemon_ + " " + stream.fault;
  } else if (end.code == kGrpcOk && (stream.finished || stream.goodbye_sent)) {
    return false;
  } else if (stream.goodbye_sent) {
    last_error_ =
        daemon_ + " did not confirm the session's end: " + WithReason(end.message, reason);
  } else {
    last_error_ = Describe(end, reason, daemon_);
  }
  return true;
}

uint32_t SessionLink::DelayMs(const StreamEnd& end, const std::string& reason,
                              const LinkStream& stream, uint64_t now_ns) {
  if (stream.online_since_ns && now_ns - *stream.online_since_ns >= kGoodConnectionNs)
    backoff_.Reset();
  if (IsTokenRefused(end.code, reason)) return kTokenDelayFactor * backoff_.LongMs();
  if (reason == "FOREIGN_SESSION") return backoff_.NextMs();
  if (IsLasting(end.code)) return backoff_.LongMs();
  if (!stream.reconnect_delay_ms) return backoff_.NextMs();
  // A daemon that shuts down sends each client its own delay, to spread their reconnections. This
  // delay may exceed backoff_max_ms.
  const uint64_t max_ms = uint64_t{4} * options_.backoff_max_ms;
  const auto delay_ms =
      static_cast<uint32_t>(std::min<uint64_t>(*stream.reconnect_delay_ms, max_ms));
  return delay_ms +
         backoff_.JitterMs(std::clamp(delay_ms, options_.backoff_min_ms, options_.backoff_max_ms));
}

void SessionLink::Goodbye(uint64_t deadline_ns) {
  goodbye_deadline_ns_ = std::min(goodbye_deadline_ns_.value_or(deadline_ns), deadline_ns);
}

// Gives up the stream because the deadline of Goodbye has passed. Reports which messages are
// unacknowledged.
void SessionLink::GiveUp() {
  if (std::exchange(stream_->given_up, true)) return;
  adaptive_.SetDeciderPresent(false);
  if (!state_.online()) {
    if (last_error_.empty()) last_error_ = daemon_ + " has not answered";
    return;
  }
  const uint64_t unacknowledged_count =
      state_.counts().sent_sequence - state_.counts().acknowledged_sequence;
  last_error_ = daemon_ + " did not confirm the session's end in time";
  if (unacknowledged_count == 0) return;
  last_error_ += ": it has not acknowledged the last " + std::to_string(unacknowledged_count) +
                 " messages; its log and /readyz may say why";
}

SessionStats SessionLink::stats() const {
  SessionStats stats = state_.counts();
  stats.state = !stream_ || stream_->given_up ? ConnectionState::kOffline
                : state_.online()             ? ConnectionState::kOnline
                                              : ConnectionState::kConnecting;
  stats.last_error = last_error_;
  stats.refusal = refusal_;
  stats.session_id = state_.session_id();
  stats.awaits_acknowledgement = stats.state == ConnectionState::kOnline && state_.full();
  stats.command_count = command_count_;
  stats.unknown_message_count = unknown_message_count_;
  stats.prior_source_count = welcome_.prior_source_count;
  stats.priors_unavailable = welcome_.priors_unavailable;
  stats.daemon_version = welcome_.daemon_version;
  stats.policy = welcome_.policy;
  stats.seed = welcome_.seed;
  stats.rules = RulesOf(welcome_);
  stats.beliefs = beliefs_;
  stats.verdict = verdict_;
  stats.saved_us = saved_us_;
  return stats;
}

}  // namespace sweepstake
