#include "tests/server/simulation/simulated_game.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <utility>

#include "engine_client/telemetry/protocol/wire.h"

namespace sweepstake::simulation {
namespace {

constexpr size_t kMaxUnacknowledged = 256;
// Maximum number of bail-outs of a session that count as evidence at once (BailOutBudget).
constexpr uint64_t kMaxBailOuts = 16;
constexpr int64_t kWelcomePatienceNs = 10 * kSecondNs;
constexpr std::array<int64_t, 4> kArmCostNs = {8 * kMsNs, 3 * kMsNs, 5 * kMsNs, 12 * kMsNs};

SentMessage Describe(const v1::StreamTelemetryRequest& request) {
  if (request.has_bail_out())
    return {.first_frame = request.bail_out().frame_index(), .bail_out_count = 1};
  const v1::FrameBatch& batch = request.frame_batch();
  return {.first_frame = batch.aabb_check_count_size() > 0 ? batch.aabb_check_count(0) : 0,
          .frame_count = static_cast<uint64_t>(batch.arm_size())};
}

}  // namespace

SimulatedGame::SimulatedGame(World& world, v1::Hello hello, Network network,
                             std::function<void(const std::string&)> complain)
    : world_(world),
      hello_(std::move(hello)),
      network_(std::move(network)),
      complain_(std::move(complain)),
      state_({}, kMaxUnacknowledged),
      stubborn_(world.Happens(0.3)),
      interval_ns_(static_cast<int64_t>(static_cast<double>(kSecondNs) / hello_.time_scale())) {
  world_.After(world_.Draw(0, kSecondNs), [this] { Step(); });
}

SimulatedGame::~SimulatedGame() {
  if (connection_) connection_->Leave();
}

void SimulatedGame::Step() {
  if (gone_) return;
  if (!finishing_ && !state_.full()) {
    PlayFrames();
    if (bail_out_count_ < kMaxBailOuts && world_.Happens(0.05)) BailOut();
  }
  if (connection_ && !state_.online() && world_.NowNs() >= welcome_due_ns_) {
    BreakConnection();
  } else if (!connection_ && world_.NowNs() >= next_attempt_ns_) {
    Connect();
  }
  SendAll();
  world_.After(interval_ns_ + world_.Draw(0, interval_ns_ / 4), [this] { Step(); });
}

void SimulatedGame::Connect() {
  goodbye_sent_ = half_closed_ = false;
  welcome_due_ns_ = world_.NowNs() + kWelcomePatienceNs;
  connection_ = network_(*this);
  const protocol::Hello position =
      state_.Connect({.active_arm = arm_, .switch_epoch = switch_epoch_});
  v1::StreamTelemetryRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello = hello_;
  hello.set_session_id(position.session_id);
  hello.set_resume_token(position.resume_token);
  hello.set_mode(v1::MODE_AI);
  hello.set_active_arm(position.active_arm);
  hello.set_switch_epoch(position.switch_epoch);
  connection_->Send(request);
  if (state_.session_id().empty() || !world_.Happens(0.1)) return;
  world_.After(world_.Draw(0, 100 * kMsNs), [this] {
    if (!state_.online()) BreakConnection();
  });
}

void SimulatedGame::BreakConnection() {
  if (connection_) connection_->Break();
}

void SimulatedGame::PlayFrames() {
  v1::StreamTelemetryRequest request;
  v1::FrameBatch& batch = *request.mutable_frame_batch();
  const auto count = world_.Draw(4, 8);
  for (int64_t i = 0; i < count; ++i) {
    const int64_t detection_ns = kArmCostNs.at(arm_) * world_.Draw(80, 120) / 100;
    batch.add_frame_time_ns(
        static_cast<uint64_t>(std::max(interval_ns_ / count, 2 * detection_ns)));
    batch.add_detection_time_ns(static_cast<uint64_t>(detection_ns));
    batch.add_aabb_check_count(next_frame_++);  // makes the frames distinguishable
    batch.add_native_bytes(1 << 16);
    batch.add_object_count(100);
    batch.add_arm(arm_);
    batch.add_switch_epoch(switch_epoch_);
    batch.add_flags(0);
  }
  const bool rests = world_.NowNs() / (10 * kSecondNs) % 2 == 0;
  batch.mutable_scene_descriptor()->set_speed_mean(rests ? 0.001F : 0.1F);
  if (world_.Happens(0.3)) Sweep(batch);
  Append(request);
  if (command_) AnswerCommand();
}

void SimulatedGame::Sweep(v1::FrameBatch& batch) {
  for (uint32_t arm = 0; arm < static_cast<uint32_t>(hello_.arms_size()); ++arm) {
    v1::ShadowSample& sample = *batch.add_shadow_samples();
    sample.set_first_frame_index(next_frame_);
    sample.set_arm(arm);
    sample.set_detection_time_ns(
        static_cast<uint64_t>(kArmCostNs.at(arm) * world_.Draw(90, 110) / 100));
    sample.set_frame_count(5);
  }
}

void SimulatedGame::AnswerCommand() {
  const v1::SwitchCommand command = *std::exchange(command_, std::nullopt);
  v1::StreamTelemetryRequest request;
  v1::SwitchOutcome& outcome = *request.mutable_switch_outcome();
  outcome.set_command_id(command.command_id());
  outcome.set_reason(command.reason());
  if (!world_.Happens(0.1)) {
    arm_ = command.arm();
    ++switch_epoch_;
    outcome.set_executed(true);
  }
  outcome.set_arm(arm_);
  outcome.set_switch_epoch(switch_epoch_);
  Append(request);
}

void SimulatedGame::BailOut() {
  ++bail_out_count_;
  v1::StreamTelemetryRequest request;
  v1::BailOut& bail_out = *request.mutable_bail_out();
  bail_out.set_frame_index(next_frame_++);
  bail_out.set_arm(arm_);
  bail_out.set_switch_epoch(switch_epoch_);
  bail_out.set_frame_time_ns(6 * kSecondNs);
  bail_out.set_detection_time_ns(5 * kSecondNs);
  bail_out.set_flags(v1::FRAME_FLAG_BAIL_OUT);
  Append(request);
}

void SimulatedGame::Append(const v1::StreamTelemetryRequest& evidence) {
  const v1::FrameBatch& batch = evidence.frame_batch();
  const bool has_frames = batch.arm_size() > 0;
  state_.Append({.message = evidence.SerializeAsString(),
                 .frame_count = static_cast<uint32_t>(batch.arm_size()),
                 .active_arm = has_frames ? batch.arm(0) : 0,
                 .switch_epoch = has_frames ? batch.switch_epoch(0) : 0});
}

void SimulatedGame::SendAll() {
  if (!connection_ || !state_.online() || goodbye_sent_ || half_closed_) return;
  SentSession& session = sessions_[state_.session_id()];
  while (const ResendBuffer::Entry* const next = state_.Next()) {
    v1::StreamTelemetryRequest request;
    const bool parsed =
        request.ParseFromString(protocol::Numbered(next->sequence, next->evidence.message));
    if (!parsed) complain_("a message with evidence cannot be parsed");
    if (next->sequence > session.messages.size()) session.messages.push_back(Describe(request));
    connection_->Send(request);
    state_.MarkSent();
  }
  if (!finishing_) return;
  v1::StreamTelemetryRequest goodbye;
  goodbye.mutable_goodbye();
  connection_->Send(goodbye);
  goodbye_sent_ = true;
}

void SimulatedGame::OnResponse(const v1::StreamTelemetryResponse& response) {
  if (response.has_welcome()) OnWelcome(response.welcome());
  if (response.has_switch_command() && response.switch_command().command_id() > last_command_id_) {
    command_ = response.switch_command();
    last_command_id_ = command_->command_id();
  }
  if (response.has_acknowledgement() && world_.Happens(0.02)) {
    ++lost_acknowledgement_count_;
    return connection_->Cut();
  }
  if (response.has_acknowledgement()) {
    const uint64_t sequence = response.acknowledgement().sequence();
    state_.OnAcknowledgement(sequence);
    uint64_t& promised = sessions_[state_.session_id()].promised_sequence;
    promised = std::max(promised, sequence);
  }
  if (response.has_posterior_snapshot()) Check(response.posterior_snapshot().arms());
  if (response.has_reconnect()) {
    reconnect_delay_ns_ = response.reconnect().delay_ms() * kMsNs;
    half_closed_ = true;
    connection_->HalfClose();
  }
}

void SimulatedGame::OnWelcome(const v1::Welcome& welcome) {
  const bool resumed = welcome.resumed();
  protocol::Welcome heard;
  heard.session_id = welcome.session_id();
  heard.resume_token = welcome.resume_token();
  heard.resumed = resumed;
  heard.priors_unavailable = welcome.priors_unavailable();
  heard.acknowledged_sequence = stubborn_ && resumed ? state_.counts().acknowledged_sequence
                                                     : welcome.acknowledged_sequence();
  state_.OnWelcome(heard);
  resumption_ = hello_;
  resumption_->set_session_id(welcome.session_id());
  resumption_->set_resume_token(welcome.resume_token());
  Check(welcome.priors());
  if (!resumed) {
    last_command_id_ = 0;
    command_.reset();
    if (sessions_.contains(welcome.session_id())) complain_("a new session has the id of another");
  }
  SentSession& session = sessions_[welcome.session_id()];
  session.promised_sequence = std::max(session.promised_sequence, welcome.acknowledged_sequence());
}

template <typename Posteriors>
void SimulatedGame::Check(const Posteriors& posteriors) {
  const bool sane = std::all_of(posteriors.begin(), posteriors.end(), [](const auto& posterior) {
    return std::isfinite(posterior.alpha()) && std::isfinite(posterior.beta()) &&
           posterior.alpha() > 0 && posterior.beta() > 0;
  });
  if (!sane || posteriors.size() != hello_.arms_size()) complain_("a posterior is invalid");
}

void SimulatedGame::OnClosed(const absl::Status& status) {
  connection_.reset();
  if (absl::IsInvalidArgument(status) || absl::IsFailedPrecondition(status) ||
      absl::IsInternal(status))
    complain_("a stream was refused: " + status.ToString());
  if (goodbye_sent_) {
    gone_ = true;
    SentSession& session = sessions_[state_.session_id()];
    if (status.ok()) session.promised_sequence = session.messages.size();
    return;
  }
  // Like DaemonSession, forget a session that belongs to another token than the current one.
  if (absl::IsPermissionDenied(status)) state_.ForgetSession();
  state_.Disconnect(absl::IsNotFound(status), absl::IsInvalidArgument(status));
  next_attempt_ns_ =
      world_.NowNs() + world_.Draw(20 * kMsNs, kSecondNs) + std::exchange(reconnect_delay_ns_, 0);
}

}  // namespace sweepstake::simulation
