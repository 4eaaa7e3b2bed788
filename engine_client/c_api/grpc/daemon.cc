// Connects a session of the C ABI to a daemon. It uses only the public functions of the C ABI, so a
// process has one copy of the ABI's state.
#include <chrono>
#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "engine_client/broad_phase/host/polling_thread.h"
#include "engine_client/c_api/boundary.h"
#include "engine_client/c_api/sized_struct.h"
#include "engine_client/telemetry/daemon_transport.h"
#include "sweepstake/c_daemon.h"

using namespace sweepstake;         // NOLINT(google-build-using-namespace)
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

namespace {

constexpr std::chrono::milliseconds kLinkPollInterval{5};

struct DestroyLink {
  void operator()(swp_link* link) const { swp_link_destroy(link); }
};
using OwnedLink = std::unique_ptr<swp_link, DestroyLink>;

// A link behind the C ABI, with the functions that DaemonTransport calls.
class PublicLink {
 public:
  explicit PublicLink(OwnedLink link) : link_(std::move(link)) {}

  swp_link* get() const { return link_.get(); }

  void Connected(uint64_t now_ns) { Note(swp_link_connected(link_.get(), now_ns)); }

  LinkAction Advance(uint64_t now_ns) {
    // The ABI returns SWP_LINK_FINISH once; SessionLink returns it until Take.
    if (finish_waits_) return LinkAction::kFinish;
    swp_link_action action = SWP_LINK_NONE;
    const swp_result result =
        swp_link_next_message(link_.get(), now_ns, nullptr, 0, &message_bytes_, &action);
    if (action != SWP_LINK_SEND) Note(result);
    finish_waits_ = action == SWP_LINK_FINISH;
    return static_cast<LinkAction>(action);
  }

  std::string Take(uint64_t now_ns) {
    if (std::exchange(finish_waits_, false)) return "";
    std::string message(message_bytes_, '\0');
    swp_link_action action = SWP_LINK_NONE;
    Note(swp_link_next_message(link_.get(), now_ns, message.data(), message.size(), &message_bytes_,
                               &action));
    message.resize(message_bytes_);
    return message;
  }

  swp_result OnMessage(const std::string& message, uint64_t now_ns) {
    return Note(swp_link_on_message(link_.get(), message.data(), message.size(), now_ns));
  }

  std::optional<uint32_t> Disconnected(const StreamEnd& end, uint64_t now_ns) {
    finish_waits_ = false;
    // The advice comes first, because the link keeps only the beginning of the message.
    const std::string message = end.advice.empty() ? end.message : end.advice + ": " + end.message;
    uint32_t delay_ms = SWP_LINK_NEVER;
    Note(swp_link_disconnected(link_.get(), end.code, message.c_str(), end.details.data(),
                               end.details.size(), now_ns, &delay_ms));
    return delay_ms == SWP_LINK_NEVER ? std::nullopt : std::optional(delay_ms);
  }

  void Goodbye(uint64_t deadline_ns) {
    Note(swp_link_goodbye(link_.get(), deadline_ns));
    said_goodbye_ = true;
  }

  // Returns whether nothing is left to do, also because the session has ended.
  bool finished() {
    if (has_ended_ || !said_goodbye_) return has_ended_;
    swp_link_stats stats = {};
    stats.struct_size = sizeof stats;
    Note(swp_link_status(link_.get(), &stats));
    return has_ended_ || stats.state == SWP_LINK_CLOSED;
  }

 private:
  swp_result Note(swp_result result) {
    has_ended_ = has_ended_ || result == SWP_FAILED_PRECONDITION;
    return result;
  }

  const OwnedLink link_;
  uint64_t message_bytes_ = 0;  // of the message that Take will return
  bool finish_waits_ = false;   // the link returned SWP_LINK_FINISH, and Take was not called
  bool said_goodbye_ = false;
  bool has_ended_ = false;  // every call of the link fails from now on
};

}  // namespace

struct swp_daemon {
  swp_daemon(OwnedLink made, DaemonTarget target)
      : link(std::move(made)), transport(std::move(target), [this] { thread.Wake(); }) {}

  void Start() {
    thread.Start(kLinkPollInterval,
                 [this](bool stopping) -> std::optional<std::chrono::microseconds> {
                   if (stopping) link.Goodbye(stop_deadline_ns);
                   transport.Step(link, SteadyClock().NowNs(), stopping);
                   if (link.finished()) return std::nullopt;
                   return kLinkPollInterval;
                 });
  }

  PublicLink link;
  uint64_t stop_deadline_ns = 0;  // written before RequestStop, read by the thread after it
  // Outlives the transport, whose streams wake it until they are destroyed.
  PollingThread thread{"swp daemon"};
  DaemonTransport<PublicLink> transport;
};

namespace {

swp_result CheckFlag(const swp_daemon_options& given) {
  if (given.tls > 1) return Fail(SWP_INVALID_ARGUMENT, "tls must be 0 or 1");
  const bool has_tls_text = given.ca_file != nullptr || given.cert_file != nullptr ||
                            given.key_file != nullptr || given.server_name != nullptr;
  if (given.tls == 1 || !has_tls_text) return SWP_OK;
  return Fail(SWP_INVALID_ARGUMENT,
              "ca_file, cert_file, key_file and server_name need TLS: set tls to 1");
}

DaemonTarget TargetOf(const swp_daemon_options& given) {
  DaemonTarget target;
  target.address = TextOr(given.address, "");
  if (given.tls == 1) {
    target.tls = TlsOptions{.ca_file = std::string(TextOr(given.ca_file, "")),
                            .cert_file = std::string(TextOr(given.cert_file, "")),
                            .key_file = std::string(TextOr(given.key_file, "")),
                            .server_name = std::string(TextOr(given.server_name, ""))};
  }
  target.token = {.file = std::string(TextOr(given.token_file, "")),
                  .text = std::string(TextOr(given.token, ""))};
  return target;
}

swp_result CreateNamedLink(swp_session* session, const swp_daemon_options& given, OwnedLink& link) {
  swp_link_options options = {};
  options.struct_size = sizeof options;
  swp_result wrong = swp_link_options_init(&options);
  if (wrong == SWP_OK) wrong = TakeOptions("swp_link_options", given.link, options);
  if (wrong != SWP_OK) return wrong;
  if (options.daemon == nullptr) options.daemon = given.address;
  swp_link* made = nullptr;
  wrong = swp_link_create(session, &options, &made);
  link.reset(made);
  return wrong;
}

swp_result Connect(swp_session* session, const swp_daemon_options& given, swp_daemon** daemon) {
  if (const swp_result wrong = CheckFlag(given); wrong != SWP_OK) return wrong;
  DaemonTarget target = TargetOf(given);
  const auto channel =
      DaemonConnection::MakeChannel(target.address, target.tls, target.token, target.names);
  if (!channel.ok()) return ToResult(channel.status());
  OwnedLink link;
  const swp_result wrong = CreateNamedLink(session, given, link);
  if (wrong != SWP_OK) return wrong;
  auto made = std::make_unique<swp_daemon>(std::move(link), std::move(target));
  const swp_result started = CatchFailure(
      [&]() -> swp_result {
        made->Start();
        return SWP_OK;
      },
      [](const char*) {
        return Fail(SWP_RESOURCE_EXHAUSTED,
                    "the system cannot start a thread for the connection: end other threads");
      });
  if (started == SWP_OK) *daemon = made.release();
  return started;
}

}  // namespace

swp_result swp_session_connect(swp_session* session, const swp_daemon_options* options,
                               swp_daemon** daemon) {
  return Guard([&] {
    if (options == nullptr || daemon == nullptr) return NullArgument("options and daemon");
    swp_daemon_options known = {};
    const swp_result wrong = TakeOptions("swp_daemon_options", options, known);
    return wrong != SWP_OK ? wrong : Connect(session, known, daemon);
  });
}

swp_link* swp_daemon_link(const swp_daemon* daemon) {
  return daemon == nullptr ? nullptr : daemon->link.get();
}

void swp_daemon_destroy(swp_daemon* daemon, uint32_t deadline_ms) {
  // A forked child has neither the thread nor gRPC's threads, so nothing of it can be ended there.
  if (daemon == nullptr || daemon->thread.is_in_child()) return;
  daemon->stop_deadline_ns = SteadyClock().NowNs() + deadline_ms * kNsPerMs;
  daemon->thread.RequestStop();
  daemon->thread.Join();
  delete daemon;
}
