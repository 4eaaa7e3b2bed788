// Moves bytes between a link, which implements the protocol of a session, and gRPC streams to the
// daemon: connects, reads the daemon's responses, writes the link's messages and disconnects, as
// the link requires.
//
// `Link` is SessionLink, or a class with the same Connected, Advance, Take, OnMessage, Disconnected
// and finished. Thread safety: the sender thread calls Step and the destructor.
#pragma once

#include <cstdint>
#include <functional>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine_client/telemetry/daemon_connection.h"
#include "engine_client/telemetry/protocol/session_link.h"

namespace sweepstake {

// The daemon of a session, and how to connect to it.
struct DaemonTarget {
  std::string address;
  std::optional<TlsOptions> tls;
  ClientToken token;
  TlsNames names;
};

template <typename Link>
class DaemonTransport {
 public:
  // `wake` makes the owner call Step soon. It is called on gRPC's threads and must not block.
  DaemonTransport(DaemonTarget target, std::function<void()> wake)
      : target_(std::move(target)), wake_(std::move(wake)) {}

  // Runs one step, without waiting for the daemon. If `stopping`, no further stream is opened.
  void Step(Link& link, uint64_t now_ns, bool stopping) {
    if (connection_) Receive(link, now_ns);
    Send(link, now_ns);
    if (!connection_ && !stopping && now_ns >= next_attempt_ns_) Connect(link, now_ns);
  }

 private:
  void Connect(Link& link, uint64_t now_ns) {
    auto channel =
        DaemonConnection::MakeChannel(target_.address, target_.tls, target_.token, target_.names);
    // The certificate and token files were valid when the session was made, so a failure to read
    // them now may be temporary.
    if (!channel.ok()) {
      const StreamEnd end = {.code = 0, .message = channel.status().message(), .details = ""};
      return OnClosed(link, end, now_ns);
    }
    connection_ = std::make_unique<DaemonConnection>(*std::move(channel), wake_);
    link.Connected(now_ns);
    Send(link, now_ns);
  }

  void Receive(Link& link, uint64_t now_ns) {
    // After a message that cannot be parsed, the link cancels the stream and reports why.
    while (const auto response = connection_->TakeResponse())
      (void)link.OnMessage(*response, now_ns);
    const std::optional<grpc::Status> status = connection_->closed();
    if (!status) return;
    connection_.reset();
    const std::string& message = status->error_message();
    OnClosed(link,
             {.code = static_cast<uint32_t>(status->error_code()),
              .message = message,
              .details = status->error_details(),
              .advice = ConnectionAdvice(message, target_.tls.has_value(), target_.names)},
             now_ns);
  }

  void OnClosed(Link& link, const StreamEnd& end, uint64_t now_ns) {
    const std::optional<uint32_t> delay_ms = link.Disconnected(end, now_ns);
    next_attempt_ns_ =
        delay_ms ? now_ns + *delay_ms * kNsPerMs : std::numeric_limits<uint64_t>::max();
  }

  // Sends the link's messages until a write is in flight or nothing is left, then performs its
  // action.
  void Send(Link& link, uint64_t now_ns) {
    LinkAction action = link.Advance(now_ns);
    for (; action == LinkAction::kSend && connection_->writable(); action = link.Advance(now_ns))
      connection_->Write(link.Take(now_ns));
    if (action == LinkAction::kFinish && connection_->writable()) {
      link.Take(now_ns);
      connection_->HalfClose();
    }
    if (action == LinkAction::kCancel) connection_->Cancel();
    if (link.finished()) connection_.reset();
  }

  const DaemonTarget target_;
  const std::function<void()> wake_;
  std::unique_ptr<DaemonConnection> connection_;  // null: none
  uint64_t next_attempt_ns_ = 0;
};

}  // namespace sweepstake
