#include "engine_client/cli/daemon/daemon_client.h"

#include <algorithm>
#include <chrono>

#include "engine_client/telemetry/daemon_channel.h"

namespace sweepstake::cli {
namespace {

using std::chrono::milliseconds;

// The delay before a new attempt to watch. It doubles with each attempt, from kMinDelay to
// kMaxDelay.
constexpr milliseconds kMinDelay{250};
constexpr milliseconds kMaxDelay{8000};

StatusCode ToCode(grpc::StatusCode code) {
  switch (code) {
    case grpc::StatusCode::UNAVAILABLE:
    case grpc::StatusCode::DEADLINE_EXCEEDED:
      return StatusCode::kUnavailable;
    case grpc::StatusCode::NOT_FOUND:
      return StatusCode::kNotFound;
    case grpc::StatusCode::RESOURCE_EXHAUSTED:
      return StatusCode::kResourceExhausted;
    case grpc::StatusCode::UNAUTHENTICATED:
    case grpc::StatusCode::PERMISSION_DENIED:
    case grpc::StatusCode::FAILED_PRECONDITION:
      return StatusCode::kFailedPrecondition;
    case grpc::StatusCode::INVALID_ARGUMENT:
      return StatusCode::kInvalidArgument;
    default:
      return StatusCode::kInternal;
  }
}

}  // namespace

TlsNames TlsOptionNames() {
  return {"--tls", "--tls-ca", "--tls-cert", "--tls-key", "--tls-server-name"};
}

Result<std::shared_ptr<grpc::Channel>> OpenChannel(const DaemonOptions& daemon,
                                                   bool own_connection) {
  grpc::ChannelArguments arguments;
  arguments.SetInt(GRPC_ARG_USE_LOCAL_SUBCHANNEL_POOL, own_connection ? 1 : 0);
  return MakeDaemonChannel(daemon.address, daemon.tls, daemon.token, TlsOptionNames(),
                           std::move(arguments));
}

void SetDeadline(grpc::ClientContext& context, std::chrono::seconds patience) {
  context.set_deadline(std::chrono::system_clock::now() + patience);
}

bool WasConnected(grpc::Channel& channel) {
  const grpc_connectivity_state state = channel.GetState(/*try_to_connect=*/false);
  return state == GRPC_CHANNEL_READY || state == GRPC_CHANNEL_IDLE;
}

Status ToStatus(const grpc::Status& given, const DaemonOptions& daemon, bool was_connected,
                const std::string& look) {
  if (given.ok()) return {};
  const grpc::Status status = WithReason(given);
  const StatusCode code = ToCode(status.error_code());
  // A status with details was made by the daemon, so in that case the daemon was reached.
  if (code != StatusCode::kUnavailable || !status.error_details().empty())
    return {code, status.error_message()};
  if (was_connected) {
    return {code, "the call to " + daemon.address + " broke off (" + status.error_message() + ")" +
                      (look.empty() ? ""
                                    : "; the change may have been made, and `" + look +
                                          "` shows whether it was")};
  }
  const std::string advice =
      ConnectionAdvice(status.error_message(), daemon.tls.has_value(), TlsOptionNames());
  if (!advice.empty()) {
    return {code,
            "no connection to " + daemon.address + " (" + status.error_message() + "); " + advice};
  }
  return {code, "no daemon answered at " + daemon.address + " (" + status.error_message() +
                    "); start one with sweepstaked --listen HOST:PORT"};
}

Canceller::Canceller(grpc::ClientContext& context, const std::function<bool()>& is_stopped)
    : thread_([this, &context, &is_stopped] {
        while (!ended_) {
          if (is_stopped()) return context.TryCancel();
          std::this_thread::sleep_for(std::chrono::milliseconds(50));
        }
      }) {}

Canceller::~Canceller() {
  ended_ = true;
  thread_.join();
}

Status KeepWatching(const DaemonOptions& daemon, const std::function<bool()>& is_stopped,
                    const std::function<void(const Status&)>& on_connection, const Watch& watch) {
  bool was_reached = false;
  milliseconds delay = kMinDelay;
  while (true) {
    const auto channel = OpenChannel(daemon, /*own_connection=*/true);
    if (!channel.ok()) return channel.status();
    std::atomic<bool> is_reached = false;
    const auto look = [&] {
      if ((*channel)->GetState(false) != GRPC_CHANNEL_READY || is_reached.exchange(true)) return;
      if (was_reached) on_connection({});
    };
    const Status status = watch(*channel, [&] {
      look();
      return is_stopped();
    });
    // `look` polls the connection. The connection may have become ready and ended between two calls
    // of it, so look once more.
    if (status.code() == StatusCode::kUnavailable) look();
    if (is_reached) delay = kMinDelay;
    was_reached = was_reached || is_reached;
    if (status.ok() || status.code() != StatusCode::kUnavailable || !was_reached) return status;
    on_connection(status);
    const auto end = std::chrono::steady_clock::now() + delay;
    while (std::chrono::steady_clock::now() < end) {
      if (is_stopped()) return {};
      std::this_thread::sleep_for(kMinDelay / 5);
    }
    delay = std::min(2 * delay, kMaxDelay);
  }
}

}  // namespace sweepstake::cli
