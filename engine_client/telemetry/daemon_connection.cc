#include "engine_client/telemetry/daemon_connection.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace sweepstake {
namespace {

constexpr int kKeepAliveIntervalMs = 20'000;
constexpr int kKeepAliveTimeoutMs = 10'000;
constexpr int kMaxMessageBytes = 256 * 1024;

}  // namespace

Result<std::shared_ptr<grpc::Channel>> DaemonConnection::MakeChannel(
    const std::string& address, const std::optional<TlsOptions>& tls, const ClientToken& token,
    const TlsNames& names) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepAliveIntervalMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepAliveTimeoutMs);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetMaxReceiveMessageSize(kMaxMessageBytes);
  return MakeDaemonChannel(address, tls, token, names, std::move(arguments));
}

DaemonConnection::DaemonConnection(std::shared_ptr<grpc::Channel> channel,
                                   std::function<void()> wake)
    : wake_(std::move(wake)),
      channel_(std::move(channel)),
      stub_(v1::TelemetryService::NewStub(channel_)) {
  stub_->async()->StreamTelemetry(&context_, this);
  // Writes start outside of gRPC's reactions. The hold keeps the stream alive in between.
  AddHold();
  StartRead(&reading_response_);
  StartCall();
}

DaemonConnection::~DaemonConnection() {
  Cancel();
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return status_.has_value(); });
}

bool DaemonConnection::writable() {
  const std::lock_guard lock(mutex_);
  return !writing_ && !broken_ && held_;
}

void DaemonConnection::Write(const v1::StreamTelemetryRequest& request) {
  writing_request_ = request;
  {
    const std::lock_guard lock(mutex_);
    writing_ = true;
  }
  StartWrite(&writing_request_);
}

void DaemonConnection::HalfClose() { StartWritesDone(); }

void DaemonConnection::Cancel() {
  context_.TryCancel();
  LetGo();
}

void DaemonConnection::LetGo() {
  if (std::exchange(held_, false)) RemoveHold();
}

std::optional<v1::StreamTelemetryResponse> DaemonConnection::TakeResponse() {
  std::optional<v1::StreamTelemetryResponse> response;
  bool resume_reading = false;
  {
    const std::lock_guard lock(mutex_);
    if (inbox_.empty()) return std::nullopt;
    response = std::move(inbox_.front());
    inbox_.pop_front();
    resume_reading = !reading_ && !broken_ && held_;
    reading_ = reading_ || resume_reading;
  }
  if (resume_reading) StartRead(&reading_response_);
  return response;
}

std::optional<grpc::Status> DaemonConnection::closed() {
  bool broken = false;
  {
    const std::lock_guard lock(mutex_);
    broken = broken_;
    if (status_ && inbox_.empty()) return status_;
  }
  if (broken) LetGo();
  return std::nullopt;
}

void DaemonConnection::OnReadDone(bool ok) {
  bool read_on = false;
  {
    const std::lock_guard lock(mutex_);
    if (ok) inbox_.push_back(std::move(reading_response_));
    broken_ = broken_ || !ok;
    read_on = ok && inbox_.size() < kMaxInboxMessages;
    reading_ = read_on;
  }
  if (read_on) StartRead(&reading_response_);
  wake_();
}

void DaemonConnection::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    writing_ = false;
    broken_ = broken_ || !ok;
  }
  wake_();
}

void DaemonConnection::OnDone(const grpc::Status& status) {
  // All of this happens under the lock: once it is free, the destructor may return.
  const std::lock_guard lock(mutex_);
  status_ = status;
  wake_();
  done_.notify_all();
}

Backoff::Backoff(uint32_t min_ms, uint32_t max_ms, uint64_t seed)
    : min_ms_(min_ms), max_ms_(max_ms), bound_ms_(min_ms), random_{seed} {
  assert(min_ms >= 1 && min_ms <= max_ms);
}

uint32_t Backoff::NextMs() {
  const uint32_t delay_ms = JitterMs(bound_ms_);
  bound_ms_ = static_cast<uint32_t>(std::min<uint64_t>(uint64_t{bound_ms_} * 2, max_ms_));
  return delay_ms;
}

uint32_t Backoff::LongMs() {
  bound_ms_ = max_ms_;
  const uint32_t half_ms = max_ms_ / 2;
  return max_ms_ - JitterMs(half_ms);
}

uint32_t Backoff::JitterMs(uint32_t bound_ms) {
  // The upper 32 bits, scaled: even enough for a delay.
  return static_cast<uint32_t>(((random_.Next() >> 32) * (uint64_t{bound_ms} + 1)) >> 32);
}

}  // namespace sweepstake
