// The session with a daemon. Its sender thread moves bytes between a SessionLink, which implements
// the protocol, and a gRPC stream. The thread polls, because the frame thread never wakes it.
// gRPC's threads and Stop do wake it.
#include "engine_client/telemetry/daemon_session.h"

#include <chrono>
#include <random>
#include <utility>

#include "engine_client/broad_phase/host/thread_owned.h"
#include "engine_client/telemetry/common/session_base.h"
#include "engine_client/telemetry/daemon_transport.h"
#include "engine_client/telemetry/protocol/session_link.h"

namespace sweepstake {
namespace {

constexpr std::chrono::milliseconds kPollInterval{5};

uint64_t NowNs() { return SteadyClock().NowNs(); }

// Returns a random seed for the delays before reconnections, so that sessions of one process
// differ. Decisions do not depend on this seed.
uint64_t JitterSeed() { return uint64_t{std::random_device()()} << 32 ^ NowNs(); }

class DaemonSession final : public SessionBase {
 public:
  DaemonSession(std::string address, const SessionOptions& options, TlsNames names)
      : SessionBase(options),
        target_{std::move(address), options.tls, options.token, std::move(names)},
        options_(options) {}
  ~DaemonSession() override { Stop(0); }

 private:
  Status Prepare(AdaptiveBroadPhase& adaptive) override;
  bool Step(bool stopping) override;
  std::chrono::milliseconds poll_interval() const override { return kPollInterval; }

  const DaemonTarget target_;
  const SessionOptions options_;

  // Used only by the sender thread, after Prepare.
  ThreadOwned<SessionLink> link_;
  ThreadOwned<DaemonTransport<SessionLink>> transport_;
};

Status DaemonSession::Prepare(AdaptiveBroadPhase& adaptive) {
  link_ = MakeThreadOwned<SessionLink>(options_, "the daemon at " + target_.address, JitterSeed(),
                                       queue(), adaptive);
  transport_ = MakeThreadOwned<DaemonTransport<SessionLink>>(target_, [this] { Wake(); });
  return {};
}

bool DaemonSession::Step(bool stopping) {
  if (stopping) link_->Goodbye(stop_deadline_ns());
  transport_->Step(*link_, NowNs(), stopping);
  UpdateStats([this](SessionStats& stats) { stats = link_->stats(); });
  return !link_->finished();
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
