#include "engine_client/telemetry/daemon_connection.h"

#include <algorithm>
#include <cassert>
#include <utility>

#include "engine_client/decider/client_reports.h"

namespace sweepstake {
namespace {

constexpr int kKeepAliveIntervalMs = 20'000;
constexpr int kKeepAliveTimeoutMs = 10'000;
constexpr char kMethod[] = "/sweepstake.v1.TelemetryService/StreamTelemetry";

std::string TextOf(const grpc::ByteBuffer& buffer) {
  grpc::Slice slice;
  if (!buffer.DumpToSingleSlice(&slice).ok()) return "";
  return {reinterpret_cast<const char*>(slice.begin()), slice.size()};
}

}  // namespace

Result<std::shared_ptr<grpc::Channel>> DaemonConnection::MakeChannel(
    const std::string& address, const std::optional<TlsOptions>& tls, const ClientToken& token,
    const TlsNames& names) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIME_MS, kKeepAliveIntervalMs);
  arguments.SetInt(GRPC_ARG_KEEPALIVE_TIMEOUT_MS, kKeepAliveTimeoutMs);
  arguments.SetInt(GRPC_ARG_HTTP2_MAX_PINGS_WITHOUT_DATA, 0);
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, 1);
  arguments.SetMaxReceiveMessageSize(protocol::kMaxMessageBytes);
  return MakeDaemonChannel(address, tls, token, names, std::move(arguments));
}

DaemonConnection::DaemonConnection(std::shared_ptr<grpc::Channel> channel,
                                   std::function<void()> wake)
    : wake_(std::move(wake)), channel_(std::move(channel)), stub_(channel_) {
  stub_.PrepareBidiStreamingCall(&context_, kMethod, {}, this);
  // Write is called later and from outside of gRPC's callbacks, so gRPC could end the stream before
  // it. The hold keeps the stream alive until LetGo.
  AddHold();
  StartRead(&read_);
  StartCall();
}

DaemonConnection::~DaemonConnection() {
  Cancel();
  std::unique_lock lock(mutex_);
  done_.wait(lock, [this] { return status_.has_value(); });
}

bool DaemonConnection::writable() {
  const std::lock_guard lock(mutex_);
  return !write_in_flight_ && !broken_ && held_;
}

void DaemonConnection::Write(const std::string& message) {
  const grpc::Slice slice(message);
  writing_ = grpc::ByteBuffer(&slice, 1);
  {
    const std::lock_guard lock(mutex_);
    write_in_flight_ = true;
  }
  StartWrite(&writing_);
}

void DaemonConnection::HalfClose() { StartWritesDone(); }

void DaemonConnection::Cancel() {
  context_.TryCancel();
  LetGo();
}

void DaemonConnection::LetGo() {
  if (std::exchange(held_, false)) RemoveHold();
}

std::optional<std::string> DaemonConnection::TakeResponse() {
  std::optional<std::string> response;
  bool resume_reading = false;
  {
    const std::lock_guard lock(mutex_);
    if (inbox_.empty()) return std::nullopt;
    response = std::move(inbox_.front());
    inbox_.pop_front();
    resume_reading = !read_in_flight_ && !broken_ && held_;
    read_in_flight_ = read_in_flight_ || resume_reading;
  }
  if (resume_reading) StartRead(&read_);
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
    if (ok) inbox_.push_back(TextOf(read_));
    broken_ = broken_ || !ok;
    read_on = ok && inbox_.size() < kMaxInboxMessages;
    read_in_flight_ = read_on;
  }
  if (read_on) StartRead(&read_);
  wake_();
}

void DaemonConnection::OnWriteDone(bool ok) {
  {
    const std::lock_guard lock(mutex_);
    write_in_flight_ = false;
    broken_ = broken_ || !ok;
  }
  wake_();
}

void DaemonConnection::OnDone(const grpc::Status& status) {
  // Hold the lock until the end of this function. As soon as it is released, the destructor may
  // destroy the object.
  const std::lock_guard lock(mutex_);
  status_ = status;
  wake_();
  done_.notify_all();
}

}  // namespace sweepstake
