#include "tests/laboratory/load/load_stream.h"

#include <algorithm>
#include <chrono>
#include <utility>

namespace sweepstake::cli {
int64_t NowNs() {
  return std::chrono::duration_cast<std::chrono::nanoseconds>(
             std::chrono::steady_clock::now().time_since_epoch())
      .count();
}

// One connection. It deletes itself when gRPC has finished the call. A hold keeps the call alive
// until the last read, so that the timer thread may write until then.
class LoadStream::Call final
    : public grpc::ClientBidiReactor<v1::StreamTelemetryRequest, v1::StreamTelemetryResponse> {
 public:
  explicit Call(LoadStream& stream) : stream_(stream) {
    stream.stub_->async()->StreamTelemetry(&context_, this);
    AddHold();
  }

  void OnReadDone(bool ok) override {
    const std::lock_guard lock(stream_.mutex_);
    if (!ok) {
      stream_.call_ = nullptr;
      return RemoveHold();
    }
    stream_.OnResponse(response_);
    StartRead(&response_);
  }
  void OnWriteDone(bool ok) override {
    const std::lock_guard lock(stream_.mutex_);
    if (!ok || stream_.call_ != this) return;
    stream_.waiting_.pop_front();
    stream_.WriteNext();
  }
  void OnDone(const grpc::Status& status) override {
    LoadStream& stream = stream_;
    delete this;
    bool was_up = false;
    uint32_t delay_ms = 0;
    {
      const std::lock_guard lock(stream.mutex_);
      was_up = std::exchange(stream.up_, false);
      delay_ms = std::exchange(stream.reconnect_delay_ms_, 0);
      stream.waiting_.clear();
      stream.bail_out_sent_ns_ = 0;
      stream.timed_sent_ns_ = 0;
    }
    stream.events_.OnEnd(stream, status, was_up, delay_ms);
  }

  grpc::ClientContext context_;
  v1::StreamTelemetryResponse response_;  // the latest

 private:
  LoadStream& stream_;
};

LoadStream::LoadStream(const std::shared_ptr<grpc::Channel>& channel, std::string project,
                       std::string scene, LoadEvents& events)
    : stub_(v1::TelemetryService::NewStub(channel)),
      project_(std::move(project)),
      scene_(std::move(scene)),
      events_(events) {}

void LoadStream::Connect() {
  const std::lock_guard lock(mutex_);
  begun_ns_ = NowNs();
  call_ = new Call(*this);
  call_->StartRead(&call_->response_);
  Send(HelloRequest());
  call_->StartCall();
}

v1::StreamTelemetryRequest LoadStream::HelloRequest() const {
  v1::StreamTelemetryRequest request;
  v1::Hello& hello = *request.mutable_hello();
  hello.set_min_protocol_version(2);
  hello.set_protocol_version(2);
  hello.set_project(project_);
  hello.set_scene(scene_);
  for (uint32_t arm = 0; arm < kLoadArms; ++arm) {
    v1::Arm& added = *hello.add_arms();
    added.set_name("arm " + std::to_string(arm));
    added.set_backend_version(1);
  }
  hello.set_active_arm(arm_);
  hello.set_switch_epoch(switch_epoch_);
  hello.set_mode(v1::MODE_AI);
  hello.set_session_id(session_id_);
  hello.set_resume_token(resume_token_);
  return request;
}

bool LoadStream::SendBatch(const v1::FrameBatch& frames, bool with_bail_out) {
  const std::lock_guard lock(mutex_);
  if (call_ == nullptr || !up_ || waiting_.size() >= kMaxWaiting) return false;
  v1::StreamTelemetryRequest request;
  request.set_sequence(NextSequence());
  v1::FrameBatch& batch = *request.mutable_frame_batch();
  batch = frames;
  for (int i = 0; i < batch.arm_size(); ++i) {
    batch.set_arm(i, arm_);
    batch.set_switch_epoch(i, switch_epoch_);
  }
  frame_index_ += static_cast<uint64_t>(batch.arm_size());
  if (timed_sent_ns_ == 0) {
    timed_sequence_ = sequence_;
    timed_sent_ns_ = NowNs();
  }
  Send(std::move(request));
  if (with_bail_out) SendBailOut();
  return true;
}

void LoadStream::SendBailOut() {
  v1::StreamTelemetryRequest request;
  request.set_sequence(NextSequence());
  v1::BailOut& bail_out = *request.mutable_bail_out();
  bail_out.set_frame_index(frame_index_++);
  bail_out.set_arm(arm_);
  bail_out.set_switch_epoch(switch_epoch_);
  bail_out.set_frame_time_ns(2 * bail_out_ns_);
  bail_out.set_detection_time_ns(2 * bail_out_ns_);
  bail_out.set_flags(v1::FRAME_FLAG_BAIL_OUT);
  bail_out_sent_ns_ = NowNs();
  Send(std::move(request));
}

uint64_t LoadStream::NextSequence() {
  ++sequence_;
  if (measuring_) last_measured_ = sequence_;
  return sequence_;
}

bool LoadStream::IsMeasured(uint64_t sequence) const {
  return first_measured_ <= sequence && sequence <= last_measured_;
}

void LoadStream::BeginMeasuring() {
  const std::lock_guard lock(mutex_);
  measuring_ = true;
  first_measured_ = sequence_ + 1;
}

void LoadStream::EndMeasuring() {
  const std::lock_guard lock(mutex_);
  measuring_ = false;
}

bool LoadStream::AwaitsAcknowledgement() {
  const std::lock_guard lock(mutex_);
  return up_ && acknowledged_sequence_ < last_measured_;
}

void LoadStream::SayGoodbye() {
  const std::lock_guard lock(mutex_);
  if (call_ == nullptr) return;
  v1::StreamTelemetryRequest request;
  request.mutable_goodbye();
  Send(std::move(request));
  leaving_ = true;
}

void LoadStream::Cancel() {
  const std::lock_guard lock(mutex_);
  if (call_ != nullptr) call_->context_.TryCancel();
}

void LoadStream::Send(v1::StreamTelemetryRequest request) {
  waiting_.push_back(std::move(request));
  if (waiting_.size() == 1) WriteNext();
}

void LoadStream::WriteNext() {
  if (!waiting_.empty()) call_->StartWrite(&waiting_.front());
}

void LoadStream::OnResponse(const v1::StreamTelemetryResponse& response) {
  if (response.has_welcome()) OnWelcome(response.welcome());
  if (response.has_acknowledgement()) OnAcknowledgement(response.acknowledgement().sequence());
  if (response.has_switch_command()) OnSwitch(response.switch_command());
  if (response.has_reconnect()) reconnect_delay_ms_ = response.reconnect().delay_ms();
}

void LoadStream::OnWelcome(const v1::Welcome& welcome) {
  session_id_ = welcome.session_id();
  resume_token_ = welcome.resume_token();
  acknowledged_sequence_ = welcome.acknowledged_sequence();
  if (!welcome.resumed()) {
    sequence_ = 0;
    first_measured_ = 1;
    last_measured_ = 0;
  }
  bail_out_ns_ = uint64_t{1'000'000} * welcome.bail_out_ms();
  up_ = true;
  events_.OnWelcome(NowNs() - begun_ns_);
}

void LoadStream::OnAcknowledgement(uint64_t sequence) {
  const uint64_t before = std::exchange(acknowledged_sequence_, sequence);
  const uint64_t first = std::max(before + 1, first_measured_);
  const uint64_t last = std::min(sequence, last_measured_);
  std::optional<int64_t> lag_ns;
  if (timed_sent_ns_ != 0 && sequence >= timed_sequence_) {
    const int64_t sent_ns = std::exchange(timed_sent_ns_, 0);
    if (IsMeasured(timed_sequence_)) lag_ns = NowNs() - sent_ns;
  }
  events_.OnAcknowledged(last >= first ? last - first + 1 : 0, lag_ns);
}

void LoadStream::OnSwitch(const v1::SwitchCommand& command) {
  if (leaving_) return;
  std::optional<int64_t> latency_ns;
  if (command.reason() == v1::SWITCH_REASON_BAIL_OUT && bail_out_sent_ns_ != 0)
    latency_ns = NowNs() - std::exchange(bail_out_sent_ns_, 0);
  events_.OnSwitch(latency_ns);
  arm_ = command.arm();
  ++switch_epoch_;
  v1::StreamTelemetryRequest request;
  request.set_sequence(NextSequence());
  v1::SwitchOutcome& outcome = *request.mutable_switch_outcome();
  outcome.set_command_id(command.command_id());
  outcome.set_arm(arm_);
  outcome.set_switch_epoch(switch_epoch_);
  outcome.set_executed(true);
  outcome.set_reason(command.reason());
  Send(std::move(request));
}

}  // namespace sweepstake::cli
