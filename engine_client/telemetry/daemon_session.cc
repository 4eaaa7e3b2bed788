// The session with a daemon: the sender thread connects the frame path's queue with a gRPC stream.
//
// Each step empties the queue, reads the daemon's responses, sends the messages that are due, and
// connects or disconnects if necessary. The frame thread never wakes it, so it polls; gRPC's
// threads and Stop wake it.
#include "engine_client/telemetry/daemon_session.h"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <optional>
#include <random>
#include <utility>

#include "engine_client/telemetry/common/session_base.h"
#include "engine_client/telemetry/daemon_connection.h"
#include "engine_client/telemetry/embedded/decider_loop.h"
#include "engine_client/telemetry/error_reason.h"
#include "engine_client/telemetry/evidence_intake.h"
#include "engine_client/telemetry/proto_conversion.h"

namespace sweepstake {
namespace {

// The versions of the protocol that a game speaks.
constexpr uint32_t kMinProtocolVersion = 1;
constexpr uint32_t kMaxProtocolVersion = 2;
constexpr uint64_t kNsPerMs = 1'000'000;
constexpr std::chrono::milliseconds kPollInterval{5};
// A daemon that neither answers Hello nor ends a stream that we ended within this time is given up.
constexpr uint64_t kAnswerTimeoutNs = 10'000 * kNsPerMs;
// After a connection that lasted this long, the next back-off starts from its minimum.
constexpr uint64_t kGoodConnectionNs = 1'000 * kNsPerMs;
constexpr uint32_t kMaxBatchFrames = 240;
constexpr uint64_t kNever = UINT64_MAX;
// A refused token is tried again after the longest back-off times this.
constexpr uint32_t kTokenDelayFactor = 6;

v1::Hello MakeHello(const SessionOptions& options, const AdaptiveBroadPhase& adaptive) {
  v1::Hello hello;
  hello.set_min_protocol_version(kMinProtocolVersion);
  hello.set_protocol_version(kMaxProtocolVersion);
  if (options.allow_operator_orders) hello.add_capabilities(v1::CAPABILITY_OPERATOR_ORDERS);
  hello.set_project(options.project);
  hello.set_scene(options.scene);
  hello.set_build(options.build);
  hello.set_machine_class(options.machine_class);
  for (size_t arm = 0; arm < adaptive.arms().size(); ++arm) {
    v1::Arm& announced = *hello.add_arms();
    announced.set_name(adaptive.arms()[arm]);
    announced.set_backend_version(adaptive.arm_versions()[arm]);
  }
  hello.set_time_scale(options.time_scale);
  hello.set_ignore_priors(options.ignore_priors);
  hello.set_seed(options.seed);
  hello.set_policy(options.policy);
  return hello;
}

BatchLimits LimitsOf(const SessionOptions& options) {
  return {.interval_ns = options.batch_interval_ms * kNsPerMs,
          .frames = options.batch_frames,
          .bytes = options.batch_bytes};
}

// Returns the limits of a batch. The daemon may ask for smaller batches. If the decision interval
// is scaled down, batches are sent more often, since there would be decisions without frames
// otherwise.
BatchLimits LimitsOf(const SessionOptions& options, const v1::Welcome& welcome) {
  uint64_t interval_ms = options.batch_interval_ms;
  if (welcome.batch_interval_ms() > 0) interval_ms = welcome.batch_interval_ms();
  if (welcome.decision_interval_ms() > 0) {
    interval_ms = std::min<uint64_t>(interval_ms, welcome.decision_interval_ms() / 2 + 1);
  }
  BatchLimits limits = LimitsOf(options);
  limits.interval_ns = interval_ms * kNsPerMs;
  if (welcome.max_batch_frames() > 0) {
    limits.frames = std::min({limits.frames, welcome.max_batch_frames(), kMaxBatchFrames});
  }
  if (welcome.max_message_bytes() > 0) {
    limits.bytes = std::min(limits.bytes, welcome.max_message_bytes());
  }
  return limits;
}

// Returns why no session is possible with a daemon that speaks this version; empty if one is.
std::string VersionMismatch(const v1::Welcome& welcome) {
  const uint32_t version = std::max(welcome.protocol_version(), 1u);
  if (version >= kMinProtocolVersion && version <= kMaxProtocolVersion) return "";
  return "speaks version " + std::to_string(version) + " of the protocol, this game speaks " +
         std::to_string(kMinProtocolVersion) + " to " + std::to_string(kMaxProtocolVersion) +
         "; update the older one";
}

bool Has(const v1::Welcome& welcome, v1::Capability capability) {
  const auto& chosen = welcome.capabilities();
  return std::find(chosen.begin(), chosen.end(), capability) != chosen.end();
}

// Returns whether the error is likely to persist, so that trying again soon does not help.
bool IsLasting(grpc::StatusCode code) {
  return code == grpc::StatusCode::INVALID_ARGUMENT ||
         code == grpc::StatusCode::FAILED_PRECONDITION ||
         code == grpc::StatusCode::UNAUTHENTICATED || code == grpc::StatusCode::PERMISSION_DENIED ||
         code == grpc::StatusCode::UNIMPLEMENTED;
}

// Returns whether the daemon refuses the token. Another one needs a person, so that it is tried
// rarely.
bool IsTokenRefused(const grpc::Status& status) {
  return status.error_code() == grpc::StatusCode::UNAUTHENTICATED ||
         ReasonOf(status) == v1::ERROR_REASON_TOO_MANY_FAILURES;
}

std::string TryingAgain(uint32_t delay_ms) {
  return "; trying again in " + std::to_string(delay_ms) + " ms";
}

std::string Describe(const grpc::Status& status, const std::string& address, bool with_tls,
                     const TlsNames& names) {
  std::string what = "the daemon at " + address + " ended the connection";
  // With a reason it is the daemon that says so.
  if (status.error_code() == grpc::StatusCode::UNAVAILABLE && status.error_details().empty())
    what = "no connection to " + address;
  if (IsLasting(status.error_code())) what = "the daemon at " + address + " refuses the session";
  if (!status.error_message().empty()) what += ": " + MessageWithReason(status);
  const std::string advice = ConnectionAdvice(status.error_message(), with_tls, names);
  return advice.empty() ? what : what + "; " + advice;
}

uint64_t NowNs() { return SteadyClock().NowNs(); }

// Returns a seed that differs between the sessions of one process, so that their jitter differs
// too. No decision depends on it.
uint64_t JitterSeed() { return uint64_t{std::random_device()()} << 32 ^ NowNs(); }

// The connection that is being opened or is open.
struct Link {
  std::unique_ptr<DaemonConnection> stream;
  uint64_t deadline_ns = 0;  // the daemon's next answer must come before it
  std::optional<uint64_t> online_since_ns;
  v1::Welcome welcome;                         // with the batch interval of now
  std::string version_mismatch;                // why the welcome cannot be accepted; empty: it can
  std::optional<uint32_t> reconnect_delay_ms;  // the daemon wants the client to come back after it
  bool goodbye_sent = false;
  bool half_closed = false;
};

class DaemonSession final : public SessionBase {
 public:
  DaemonSession(std::string address, const SessionOptions& options, TlsNames names)
      : SessionBase(options.queue_frames),
        address_(std::move(address)),
        options_(options),
        names_(std::move(names)),
        backoff_(options.backoff_min_ms, options.backoff_max_ms, JitterSeed()) {}
  ~DaemonSession() override { Stop(0); }

 private:
  Status Prepare(AdaptiveBroadPhase& adaptive) override;
  bool Step(bool stopping) override;
  std::chrono::milliseconds poll_interval() const override { return kPollInterval; }

  void Connect(uint64_t now_ns);
  void OnUnusableFiles(const Status& status, uint64_t now_ns);
  void Converse(uint64_t now_ns);
  void Send();
  void OnResponse(const v1::StreamTelemetryResponse& response, uint64_t now_ns);
  void OnWelcome(const v1::Welcome& welcome, uint64_t now_ns);
  void OnAcknowledgement(const v1::Acknowledgement& message);
  void OnCommand(const v1::SwitchCommand& message);
  void OnOrder(const v1::OperatorOrder& message);
  void TakeBeliefs(const google::protobuf::RepeatedPtrField<v1::BetaPosterior>& posteriors);
  void TakeVerdict(const v1::PosteriorSnapshot& snapshot);
  void OnClosed(const grpc::Status& status, uint64_t now_ns);
  uint32_t DelayMs(const grpc::Status& status, const Link& link, uint64_t now_ns);
  bool Disconnect(uint64_t now_ns, bool queue_empty);
  void HalfClose(uint64_t now_ns);
  void GiveUp();
  void Publish();

  const std::string address_;
  const SessionOptions options_;
  const TlsNames names_;

  // On the sender thread, from Prepare on.
  std::optional<SessionState> state_;
  std::optional<EvidenceIntake> intake_;
  Backoff backoff_;
  std::optional<Link> link_;
  uint64_t next_attempt_ns_ = 0;
  std::string last_error_;
  std::string refusal_;
  std::vector<ArmBelief> beliefs_;
  SceneVerdict verdict_;
  uint64_t command_count_ = 0;
  uint64_t unknown_message_count_ = 0;
  uint64_t prior_source_count_ = 0;
  bool priors_unavailable_ = false;
  std::string daemon_version_;
  std::string policy_;
  uint64_t seed_ = 0;
  bool takes_orders_ = false;  // from this daemon
};

Status DaemonSession::Prepare(AdaptiveBroadPhase& adaptive) {
  state_.emplace(MakeHello(options_, adaptive), options_.unacknowledged_messages);
  intake_.emplace(queue(), *state_, LimitsOf(options_));
  return {};
}

bool DaemonSession::Step(bool stopping) {
  const uint64_t now_ns = NowNs();
  const bool queue_empty = intake_->Pump(now_ns);
  if (link_) Converse(now_ns);
  bool go_on = true;
  if (stopping) {
    go_on = Disconnect(now_ns, queue_empty);
  } else if (!link_ && now_ns >= next_attempt_ns_) {
    Connect(now_ns);
  }
  Publish();
  return go_on;
}

void DaemonSession::Connect(uint64_t now_ns) {
  auto channel = DaemonConnection::MakeChannel(address_, options_.tls, options_.token, names_);
  if (!channel.ok()) return OnUnusableFiles(channel.status(), now_ns);
  link_.emplace();
  link_->deadline_ns = now_ns + kAnswerTimeoutNs;
  link_->stream = std::make_unique<DaemonConnection>(*std::move(channel), [this] { Wake(); });
  link_->stream->Write(state_->Connect({.active_arm = adaptive().active_arm(),
                                        .switch_epoch = adaptive().switch_epoch(),
                                        .mode = ToProto(adaptive().mode())}));
}

// They could be used when the session was made, so that they may be again.
void DaemonSession::OnUnusableFiles(const Status& status, uint64_t now_ns) {
  const uint32_t delay_ms = backoff_.LongMs();
  next_attempt_ns_ = now_ns + delay_ms * kNsPerMs;
  last_error_ = status.message() + TryingAgain(delay_ms);
}

void DaemonSession::Converse(uint64_t now_ns) {
  while (const auto response = link_->stream->TakeResponse()) OnResponse(*response, now_ns);
  if (const std::optional<grpc::Status> status = link_->stream->closed()) {
    return OnClosed(*status, now_ns);
  }
  const bool waiting = !state_->online() || link_->half_closed;
  if (waiting && now_ns >= link_->deadline_ns) return link_->stream->Cancel();
  if (link_->reconnect_delay_ms && !link_->half_closed) {
    if (link_->stream->writable()) HalfClose(now_ns);
    return;
  }
  Send();
}

void DaemonSession::Send() {
  if (link_->goodbye_sent || link_->half_closed) return;
  while (const v1::StreamTelemetryRequest* next = state_->Next()) {
    if (!link_->stream->writable()) return;
    link_->stream->Write(*next);
    state_->MarkSent();
  }
}

void DaemonSession::OnResponse(const v1::StreamTelemetryResponse& response, uint64_t now_ns) {
  if (response.has_welcome()) OnWelcome(response.welcome(), now_ns);
  if (!link_->version_mismatch.empty()) return;
  if (response.has_switch_command()) OnCommand(response.switch_command());
  if (response.has_acknowledgement()) OnAcknowledgement(response.acknowledgement());
  if (response.has_posterior_snapshot()) {
    TakeBeliefs(response.posterior_snapshot().arms());
    TakeVerdict(response.posterior_snapshot());
  }
  if (response.has_reconnect()) link_->reconnect_delay_ms = response.reconnect().delay_ms();
  if (response.has_operator_order()) OnOrder(response.operator_order());
  if (!response.GetReflection()->GetUnknownFields(response).empty()) ++unknown_message_count_;
}

void DaemonSession::OnWelcome(const v1::Welcome& welcome, uint64_t now_ns) {
  if (state_->online()) return;  // A second welcome of a connection is ignored.
  link_->version_mismatch = VersionMismatch(welcome);
  if (!link_->version_mismatch.empty()) return link_->stream->Cancel();
  state_->OnWelcome(welcome);
  link_->online_since_ns = now_ns;
  last_error_.clear();
  refusal_.clear();
  prior_source_count_ = welcome.prior_source_count();
  priors_unavailable_ = welcome.priors_unavailable();
  daemon_version_ = welcome.daemon_version();
  policy_ = welcome.policy();
  seed_ = welcome.seed();
  takes_orders_ = options_.allow_operator_orders && Has(welcome, v1::CAPABILITY_OPERATOR_ORDERS);
  link_->welcome = welcome;
  intake_->SetLimits(LimitsOf(options_, welcome));
  TakeBeliefs(welcome.priors());
  adaptive().SetSettling(welcome.settling_ms() * kNsPerMs);
  adaptive().SetBailOutLimit(welcome.bail_out_ms() * kNsPerMs);
  adaptive().SetDeciderPresent(true);
}

void DaemonSession::OnAcknowledgement(const v1::Acknowledgement& message) {
  state_->OnAcknowledgement(message.sequence());
  if (message.batch_interval_ms() == 0) return;
  link_->welcome.set_batch_interval_ms(message.batch_interval_ms());
  intake_->SetLimits(LimitsOf(options_, link_->welcome));
}

void DaemonSession::OnCommand(const v1::SwitchCommand& message) {
  const std::optional<SwitchCommand> command = FromProto(message);
  // An unknown reason is one of a newer protocol, and could not be answered within this one.
  if (!command) {
    ++unknown_message_count_;
    return;
  }
  ++command_count_;
  if (command->arm >= adaptive().arms().size()) {
    return state_->Append(
        RefusalToProto(message, adaptive().active_arm(), adaptive().switch_epoch()));
  }
  adaptive().mailbox().Post(*command);
}

void DaemonSession::OnOrder(const v1::OperatorOrder& message) {
  if (!takes_orders_) {
    return state_->Append(RefusalToProto(message, v1::ORDER_REFUSAL_REASON_NOT_ALLOWED));
  }
  const std::optional<OperatorOrder> order = FromProto(message, adaptive().arms().size());
  if (!order) return state_->Append(RefusalToProto(message, v1::ORDER_REFUSAL_REASON_UNKNOWN));
  adaptive().Obey(*order);
}

void DaemonSession::TakeBeliefs(
    const google::protobuf::RepeatedPtrField<v1::BetaPosterior>& posteriors) {
  std::optional<std::vector<ArmBelief>> beliefs = FromProto(posteriors, adaptive().arms());
  if (!beliefs) return;
  beliefs_ = *std::move(beliefs);
  SetPosteriorMeans(beliefs_, adaptive());
}

void DaemonSession::TakeVerdict(const v1::PosteriorSnapshot& snapshot) {
  if (!v1::Verdict_IsValid(snapshot.verdict())) ++unknown_message_count_;
  const std::optional<SceneVerdict> verdict = FromProto(snapshot, adaptive().arms().size());
  if (!verdict) return;
  verdict_ = *verdict;
  adaptive().SetVerdict(verdict_);
}

void DaemonSession::HalfClose(uint64_t now_ns) {
  link_->stream->HalfClose();
  link_->half_closed = true;
  link_->deadline_ns = now_ns + kAnswerTimeoutNs;
}

void DaemonSession::OnClosed(const grpc::Status& status, uint64_t now_ns) {
  const Link link = std::move(*link_);
  link_.reset();
  adaptive().SetDeciderPresent(false);
  if (ReasonOf(status) == v1::ERROR_REASON_FOREIGN_SESSION) state_->ForgetSession();
  state_->Disconnect(status.error_code() == grpc::StatusCode::NOT_FOUND,
                     status.error_code() == grpc::StatusCode::INVALID_ARGUMENT);
  const uint32_t delay_ms = DelayMs(status, link, now_ns);
  const bool kicked = ReasonOf(status) == v1::ERROR_REASON_SESSION_KICKED;
  next_attempt_ns_ = kicked ? kNever : now_ns + delay_ms * kNsPerMs;
  const bool asked_for = status.ok() && (link.half_closed || link.goodbye_sent);
  const bool refused = status.error_code() == grpc::StatusCode::INVALID_ARGUMENT ||
                       IsTokenRefused(status) || ReasonOf(status) == v1::ERROR_REASON_NOT_ALLOWED;
  refusal_ = refused ? MessageWithReason(status) : "";
  if (!link.version_mismatch.empty()) {
    refusal_ = "the daemon at " + address_ + " " + link.version_mismatch;
    last_error_ = refusal_ + TryingAgain(delay_ms);
    return;
  }
  if (asked_for) return;
  if (link.goodbye_sent) {
    last_error_ = "the daemon at " + address_ +
                  " did not confirm the session's end: " + MessageWithReason(status);
  } else {
    last_error_ = Describe(status, address_, options_.tls.has_value(), names_);
    if (!kicked) last_error_ += TryingAgain(delay_ms);
  }
}

uint32_t DaemonSession::DelayMs(const grpc::Status& status, const Link& link, uint64_t now_ns) {
  if (link.online_since_ns && now_ns - *link.online_since_ns >= kGoodConnectionNs) {
    backoff_.Reset();
  }
  if (!link.version_mismatch.empty()) return backoff_.LongMs();
  if (IsTokenRefused(status)) return kTokenDelayFactor * backoff_.LongMs();
  if (ReasonOf(status) == v1::ERROR_REASON_FOREIGN_SESSION) return backoff_.NextMs();
  if (IsLasting(status.error_code())) return backoff_.LongMs();
  if (!link.reconnect_delay_ms) return backoff_.NextMs();
  // A daemon that drains spreads its clients by the delay, over more than the longest back-off.
  const uint64_t max_ms = uint64_t{4} * options_.backoff_max_ms;
  const auto delay_ms = static_cast<uint32_t>(std::min<uint64_t>(*link.reconnect_delay_ms, max_ms));
  return delay_ms +
         backoff_.JitterMs(std::clamp(delay_ms, options_.backoff_min_ms, options_.backoff_max_ms));
}

// Says goodbye once everything is sent. Returns false when that is done or the time is over.
bool DaemonSession::Disconnect(uint64_t now_ns, bool queue_empty) {
  if (!link_) return false;
  if (now_ns >= stop_deadline_ns()) {
    GiveUp();
    return false;
  }
  if (queue_empty && !intake_->batch_empty()) {
    intake_->Flush();
    Send();
  }
  const bool all_sent = state_->online() && queue_empty && state_->Next() == nullptr;
  if (!all_sent || link_->half_closed || !link_->stream->writable()) return true;
  if (link_->goodbye_sent) {
    HalfClose(now_ns);
  } else {
    v1::StreamTelemetryRequest request;
    request.mutable_goodbye();
    link_->stream->Write(request);
    link_->goodbye_sent = true;
  }
  return true;
}

// Ends the connection at the deadline of Stop, and says what the daemon owes until then.
void DaemonSession::GiveUp() {
  link_->stream->Cancel();
  link_.reset();
  const std::string daemon = "the daemon at " + address_;
  if (!state_->online()) {
    if (last_error_.empty()) last_error_ = daemon + " has not answered";
    return;
  }
  const uint64_t unacknowledged_count =
      state_->counts().sent_sequence - state_->counts().acknowledged_sequence;
  last_error_ = daemon + " did not confirm the session's end in time";
  if (unacknowledged_count == 0) return;
  last_error_ += ": it has not acknowledged the last " + std::to_string(unacknowledged_count) +
                 " messages; its log and /readyz may say why";
}

void DaemonSession::Publish() {
  const SessionState::Counts& counts = state_->counts();
  UpdateStats([&](SessionStats& stats) {
    stats.state = !link_             ? ConnectionState::kOffline
                  : state_->online() ? ConnectionState::kOnline
                                     : ConnectionState::kConnecting;
    stats.last_error = last_error_;
    stats.refusal = refusal_;
    stats.session_id = state_->session_id();
    stats.sent_frame_count = counts.sent_frame_count;
    stats.dropped_frame_count = counts.discarded_frame_count;
    stats.acknowledged_sequence = counts.acknowledged_sequence;
    stats.sent_sequence = counts.sent_sequence;
    stats.awaits_acknowledgement = state_->online() && state_->full();
    stats.connection_count = counts.connection_count;
    stats.resumed_count = counts.resumed_count;
    stats.resent_message_count = counts.resent_message_count;
    stats.command_count = command_count_;
    stats.unknown_message_count = unknown_message_count_;
    stats.prior_source_count = prior_source_count_;
    stats.priors_unavailable = priors_unavailable_;
    stats.daemon_version = daemon_version_;
    stats.policy = policy_;
    stats.seed = seed_;
    stats.beliefs = beliefs_;
    stats.verdict = verdict_;
  });
}

}  // namespace

Result<std::unique_ptr<Session>> MakeDaemonSession(std::string address,
                                                   const SessionOptions& options,
                                                   const TlsNames& names) {
  if (Status status = ValidateSessionOptions(options, names); !status.ok()) return status;
  const auto channel = DaemonConnection::MakeChannel(address, options.tls, options.token, names);
  if (!channel.ok()) return channel.status();
  return std::unique_ptr<Session>(
      std::make_unique<DaemonSession>(std::move(address), options, names));
}

Result<std::unique_ptr<Session>> MakeDaemonSession(std::string address,
                                                   const SessionOptions& options) {
  return MakeDaemonSession(std::move(address), options, {});
}

}  // namespace sweepstake
