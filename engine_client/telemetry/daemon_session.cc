// The session with a daemon. Its sender thread moves bytes between a SessionLink, which implements
// the protocol, and a gRPC stream.
//
// Each step of the sender thread reads the daemon's responses, sends the link's messages, and
// connects or disconnects if the link requires it. The thread polls, because the frame thread never
// wakes it. gRPC's threads and Stop do wake it.
#include "engine_client/telemetry/daemon_session.h"

#include <chrono>
#include <optional>
#include <random>
#include <utility>

#include "engine_client/broad_phase/host/thread_owned.h"
#include "engine_client/telemetry/common/session_base.h"
#include "engine_client/telemetry/daemon_connection.h"
#include "engine_client/telemetry/protocol/session_link.h"

namespace sweepstake {
namespace {

constexpr std::chrono::milliseconds kPollInterval{5};
constexpr uint64_t kNever = UINT64_MAX;

uint64_t NowNs() { return SteadyClock().NowNs(); }

// Returns a random seed for the delays before reconnections, so that sessions of one process
// differ. Decisions do not depend on this seed.
uint64_t JitterSeed() { return uint64_t{std::random_device()()} << 32 ^ NowNs(); }

class DaemonSession final : public SessionBase {
 public:
  DaemonSession(std::string address, const SessionOptions& options, TlsNames names)
      : SessionBase(options),
        address_(std::move(address)),
        options_(options),
        names_(std::move(names)) {}
  ~DaemonSession() override { Stop(0); }

 private:
  Status Prepare(AdaptiveBroadPhase& adaptive) override;
  bool Step(bool stopping) override;
  std::chrono::milliseconds poll_interval() const override { return kPollInterval; }

  void Connect(uint64_t now_ns);
  void Receive(uint64_t now_ns);
  void Send(uint64_t now_ns);
  void OnClosed(const StreamEnd& end, uint64_t now_ns);

  const std::string address_;
  const SessionOptions options_;
  const TlsNames names_;

  // Used only by the sender thread, after Prepare.
  ThreadOwned<std::optional<SessionLink>> owned_link_;
  std::optional<SessionLink>& link_ = *owned_link_;
  ThreadOwned<std::unique_ptr<DaemonConnection>> owned_connection_;
  std::unique_ptr<DaemonConnection>& connection_ = *owned_connection_;  // null: none
  uint64_t next_attempt_ns_ = 0;
};

Status DaemonSession::Prepare(AdaptiveBroadPhase& adaptive) {
  link_.emplace(options_, "the daemon at " + address_, JitterSeed(), queue(), adaptive);
  return {};
}

bool DaemonSession::Step(bool stopping) {
  const uint64_t now_ns = NowNs();
  if (stopping) link_->Goodbye(stop_deadline_ns());
  if (connection_) Receive(now_ns);
  Send(now_ns);
  if (!connection_ && !stopping && now_ns >= next_attempt_ns_) Connect(now_ns);
  UpdateStats([this](SessionStats& stats) { stats = link_->stats(); });
  return !link_->finished();
}

void DaemonSession::Connect(uint64_t now_ns) {
  auto channel = DaemonConnection::MakeChannel(address_, options_.tls, options_.token, names_);
  // The certificate and token files were valid when the session was made, so a failure to read them
  // now may be temporary.
  if (!channel.ok())
    return OnClosed({.code = 0, .message = channel.status().message(), .details = ""}, now_ns);
  connection_ = std::make_unique<DaemonConnection>(*std::move(channel), [this] { Wake(); });
  link_->Connected(now_ns);
  Send(now_ns);
}

void DaemonSession::Receive(uint64_t now_ns) {
  // After a message that cannot be parsed, the link cancels the stream and reports why.
  while (const auto response = connection_->TakeResponse())
    (void)link_->OnMessage(*response, now_ns);
  const std::optional<grpc::Status> status = connection_->closed();
  if (!status) return;
  connection_.reset();
  const std::string& message = status->error_message();
  OnClosed({.code = static_cast<uint32_t>(status->error_code()),
            .message = message,
            .details = status->error_details(),
            .advice = ConnectionAdvice(message, options_.tls.has_value(), names_)},
           now_ns);
}

void DaemonSession::OnClosed(const StreamEnd& end, uint64_t now_ns) {
  const std::optional<uint32_t> delay_ms = link_->Disconnected(end, now_ns);
  next_attempt_ns_ = delay_ms ? now_ns + *delay_ms * kNsPerMs : kNever;
}

// Sends the link's messages until a write is in flight or nothing is left, then performs its
// action.
void DaemonSession::Send(uint64_t now_ns) {
  LinkAction action = link_->Advance(now_ns);
  for (; action == LinkAction::kSend && connection_->writable(); action = link_->Advance(now_ns))
    connection_->Write(link_->Take(now_ns));
  if (action == LinkAction::kFinish && connection_->writable()) {
    link_->Take(now_ns);
    connection_->HalfClose();
  }
  if (action == LinkAction::kCancel) connection_->Cancel();
  if (link_->finished()) connection_.reset();
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
