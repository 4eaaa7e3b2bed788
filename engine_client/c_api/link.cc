// The session with a daemon over the caller's transport: a SessionLink that is protected by a lock.
#include <cstring>
#include <mutex>
#include <string>

#include "engine_client/c_api/live.h"
#include "engine_client/c_api/session.h"
#include "engine_client/c_api/sized_struct.h"
#include "engine_client/math/hash.h"
#include "engine_client/telemetry/common/validation.h"
#include "engine_client/telemetry/protocol/session_link.h"
#include "engine_client/text/names.h"

using sweepstake::ConnectionState;
using sweepstake::DecisionRules;
using sweepstake::LinkAction;
using sweepstake::RewardWeights;
using sweepstake::SessionLink;
using sweepstake::SessionOptions;
using sweepstake::SessionStats;
using sweepstake::StreamEnd;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

static_assert(SWP_LINK_SEND == static_cast<int>(LinkAction::kSend));
static_assert(SWP_LINK_FINISH == static_cast<int>(LinkAction::kFinish));
static_assert(SWP_LINK_CANCEL == static_cast<int>(LinkAction::kCancel));
static_assert(static_cast<int>(SWP_LINK_OFFLINE) == static_cast<int>(ConnectionState::kOffline));
static_assert(SWP_LINK_CONNECTING == static_cast<int>(ConnectionState::kConnecting));
static_assert(SWP_LINK_ONLINE == static_cast<int>(ConnectionState::kOnline));
static_assert(SWP_LINK_CLOSED == static_cast<int>(ConnectionState::kClosed));

namespace sweepstake::c_api {

struct Link : LinkedSession {
  static constexpr swp_kind kKind = SWP_KIND_LINK;
  static constexpr std::string_view kName = "link";

  Link(swp_session& owner, const SessionOptions& options, std::string daemon, uint64_t jitter_seed)
      : protocol(options, std::move(daemon), jitter_seed, owner.content->queue,
                 *owner.content->adaptive) {
    session = &owner;
    owner.content->link = this;
  }
  ~Link() {
    swp_session* const owner = session;
    if (owner == nullptr) return;
    owner->content->adaptive->SetDeciderPresent(false);
    owner->content->adaptive->SetSettling(owner->content->settling_ns);
    owner->content->adaptive->SetLaneUse(true);
    owner->content->adaptive->SetBailOutLimit(owner->content->bail_out_ns);
    owner->content->link = nullptr;  // last: from now on a decider may be attached
  }

  SessionLink protocol;  // guarded by `mutex`
};

}  // namespace sweepstake::c_api

struct swp_link final : Handle<Link> {
  using Handle::Handle;
};

namespace {

constexpr uint64_t kMaxTextBytes = 1 << 20;

swp_link_options DefaultLinkOptions() {
  const SessionOptions defaults;
  swp_link_options options{};
  options.struct_size = sizeof options;
  options.time_scale = defaults.time_scale;
  options.batch_interval_ms = defaults.batch_interval_ms;
  options.batch_frames = defaults.batch_frames;
  options.batch_bytes = defaults.batch_bytes;
  options.unacknowledged_messages = defaults.unacknowledged_messages;
  options.backoff_min_ms = defaults.backoff_min_ms;
  options.backoff_max_ms = defaults.backoff_max_ms;
  options.decision_interval_ns = SWP_DAEMON_VALUE;
  options.cooldown_ns = SWP_DAEMON_VALUE;
  options.settling_ns = SWP_DAEMON_VALUE;
  return options;
}

DecisionRules RulesOf(const swp_link_options& given) {
  const auto chosen = [](uint64_t interval_ns) {
    return interval_ns == SWP_DAEMON_VALUE ? std::nullopt : std::optional(interval_ns);
  };
  DecisionRules rules = {.decision_interval_ns = chosen(given.decision_interval_ns),
                         .cooldown_ns = chosen(given.cooldown_ns),
                         .settling_ns = chosen(given.settling_ns)};
  constexpr RewardWeights kDaemons = {.fps = 0, .detection = 0, .memory = 0, .checks = 0};
  if (ToWeights(given.weights) != kDaemons) rules.weights = ToWeights(given.weights);
  return rules;
}

SessionOptions ToSessionOptions(const swp_link_options& given) {
  SessionOptions options;
  options.project = TextOr(given.project, options.project);
  options.scene = TextOr(given.scene, options.scene);
  options.build = TextOr(given.build, "");
  options.machine_class = TextOr(given.machine_class, "");
  options.policy = TextOr(given.policy, "");
  options.time_scale = given.time_scale;
  options.ignore_priors = given.ignore_priors == 1;
  options.seed = given.seed;
  options.allow_operator_orders = given.allow_operator_orders == 1;
  options.batch_interval_ms = given.batch_interval_ms;
  options.batch_frames = given.batch_frames;
  options.batch_bytes = given.batch_bytes;
  options.unacknowledged_messages = given.unacknowledged_messages;
  options.backoff_min_ms = given.backoff_min_ms;
  options.backoff_max_ms = given.backoff_max_ms;
  options.rules = RulesOf(given);
  return options;
}

swp_result CheckOptions(const swp_link_options& given) {
  if (given.allow_operator_orders > 1 || given.ignore_priors > 1) {
    return Fail(SWP_INVALID_ARGUMENT, "allow_operator_orders and ignore_priors must be 0 or 1");
  }
  if (given.reserved != 0) return Fail(SWP_INVALID_ARGUMENT, "reserved must be 0");
  if (!sweepstake::text::IsOptionalName(TextOr(given.daemon, ""))) {
    return Fail(SWP_INVALID_ARGUMENT,
                "daemon must be at most 128 bytes of UTF-8 without control characters");
  }
  return ToResult(sweepstake::ValidateSessionOptions(ToSessionOptions(given)));
}

uint64_t JitterSeed(const swp_link_options& given, const swp_session& session) {
  if (given.jitter_seed != 0) return given.jitter_seed;
  return sweepstake::math::Mix64(sweepstake::SteadyClock().NowNs() ^
                                 reinterpret_cast<uintptr_t>(&session));
}

swp_result CreateLink(swp_session& session, const swp_link_options& given, swp_link** link) {
  if (session.content->decider_loop || session.content->link != nullptr) {
    return Fail(SWP_FAILED_PRECONDITION,
                "the session already has a decider or a link: detach the decider or destroy the "
                "link first");
  }
  const std::string_view address = TextOr(given.daemon, "");
  std::string daemon = "the daemon";
  if (!address.empty()) daemon.append(" at ").append(address);
  Publish(std::make_unique<Link>(session, ToSessionOptions(given), std::move(daemon),
                                 JitterSeed(given, session)),
          link);
  return SWP_OK;
}

// Runs `body` with the link while its lock is held; the session cannot be freed during that time. A
// failure is stored as the link's error only. The session has its own errors.
template <typename Body>
swp_result UseLink(swp_link* link, const Body& body) noexcept {
  return Use(link, [&](Link& live) {
    const std::lock_guard lock(live.mutex);
    swp_session* const session = live.session;
    if (session == nullptr) {
      return Fail(SWP_FAILED_PRECONDITION, "the session of this link has ended: destroy the link");
    }
    if (!session->Enter()) return Ended(*link, LiveSession::kName);
    const auto leave = [](swp_session* entered) { entered->Leave(); };
    const std::unique_ptr<swp_session, decltype(leave)> stay(session, leave);
    return swp_result{body(live)};
  });
}

swp_result TakeMessage(Link& live, uint64_t now_ns, void* buffer, uint64_t capacity, uint64_t* size,
                       swp_link_action* action) {
  const LinkAction next = live.protocol.Advance(now_ns);
  *action = static_cast<swp_link_action>(next);
  *size = 0;
  if (next == LinkAction::kFinish) live.protocol.Take(now_ns);
  if (next != LinkAction::kSend) return SWP_OK;
  *size = live.protocol.next_message_bytes();
  if (capacity == 0) return SWP_RESOURCE_EXHAUSTED;  // no buffer, as during a write
  if (*size > capacity) {
    return Fail(
        SWP_RESOURCE_EXHAUSTED,
        "the buffer is too small for the message: `size` is the number of bytes that it needs");
  }
  const std::string message = live.protocol.Take(now_ns);
  std::memcpy(buffer, message.data(), message.size());
  return SWP_OK;
}

swp_link_stats ToStats(const SessionStats& stats, bool closed) {
  return {sizeof(swp_link_stats),
          static_cast<swp_link_state>(closed ? ConnectionState::kClosed : stats.state),
          stats.sent_frame_count,
          stats.dropped_frame_count,
          stats.sent_sequence,
          stats.acknowledged_sequence,
          stats.connection_count,
          stats.resumed_count,
          stats.resent_message_count,
          stats.command_count,
          stats.unknown_message_count,
          stats.prior_source_count,
          stats.seed,
          stats.priors_unavailable ? 1U : 0U,
          stats.awaits_acknowledgement ? 1U : 0U};
}

// Returns the text that `which` selects, or null if `which` is unknown.
const std::string* TextOf(const SessionStats& stats, swp_link_text which) {
  switch (which) {
    case SWP_LINK_LAST_ERROR:
      return &stats.last_error;
    case SWP_LINK_REFUSAL:
      return &stats.refusal;
    case SWP_LINK_SESSION_ID:
      return &stats.session_id;
    case SWP_LINK_DAEMON_VERSION:
      return &stats.daemon_version;
    case SWP_LINK_POLICY:
      return &stats.policy;
    default:
      return nullptr;
  }
}

}  // namespace

swp_result swp_link_options_init(swp_link_options* options) {
  return Guard([&] { return Give("swp_link_options", DefaultLinkOptions(), options); });
}

swp_result swp_link_create(swp_session* session, const swp_link_options* options, swp_link** link) {
  return Use(session, [&](LiveSession& /*live*/) {
    if (link == nullptr) return NullArgument("link");
    swp_link_options known = DefaultLinkOptions();
    swp_result wrong = TakeOptions("swp_link_options", options, known);
    if (wrong == SWP_OK) wrong = CheckOptions(known);
    return wrong != SWP_OK ? wrong : CreateLink(*session, known, link);
  });
}

void swp_link_destroy(swp_link* link) { Destroy(link); }

swp_result swp_link_connected(swp_link* link, uint64_t now_ns) {
  return UseLink(link, [&](Link& live) {
    if (live.protocol.finished()) {
      return Fail(SWP_FAILED_PRECONDITION, "the link is closed: destroy it and make another");
    }
    if (live.protocol.connected()) {
      return Fail(SWP_FAILED_PRECONDITION, "a stream is open: call swp_link_disconnected first");
    }
    live.protocol.Connected(now_ns);
    return kOk;
  });
}

swp_result swp_link_next_message(swp_link* link, uint64_t now_ns, void* buffer, uint64_t capacity,
                                 uint64_t* size, swp_link_action* action) {
  return UseLink(link, [&](Link& live) {
    if (size == nullptr || action == nullptr) return NullArgument("size and action");
    if (buffer == nullptr && capacity > 0) return NullArgument("buffer");
    return TakeMessage(live, now_ns, buffer, capacity, size, action);
  });
}

swp_result swp_link_on_message(swp_link* link, const void* bytes, uint64_t size, uint64_t now_ns) {
  return UseLink(link, [&](Link& live) {
    if (bytes == nullptr && size > 0) return NullArgument("bytes");
    const std::string_view message(static_cast<const char*>(bytes), size);
    return ToResult(live.protocol.OnMessage(message, now_ns));
  });
}

swp_result swp_link_disconnected(swp_link* link, uint32_t grpc_status_code, const char* message,
                                 const void* details, uint64_t details_size, uint64_t now_ns,
                                 uint32_t* delay_ms) {
  return UseLink(link, [&](Link& live) {
    if (delay_ms == nullptr) return NullArgument("delay_ms");
    if (details == nullptr && details_size > 0) return NullArgument("details");
    if (details_size > kMaxTextBytes) {
      return Fail(SWP_INVALID_ARGUMENT, "details_size must be at most 1048576");
    }
    const StreamEnd end = {.code = grpc_status_code,
                           .message = std::string(TextOr(message, "")),
                           .details = std::string(static_cast<const char*>(details), details_size)};
    *delay_ms = live.protocol.Disconnected(end, now_ns).value_or(SWP_LINK_NEVER);
    return kOk;
  });
}

swp_result swp_link_goodbye(swp_link* link, uint64_t deadline_ns) {
  return UseLink(link, [&](Link& live) {
    live.protocol.Goodbye(deadline_ns);
    return kOk;
  });
}

swp_result swp_link_status(swp_link* link, swp_link_stats* stats) {
  return UseLink(link, [&](Link& live) {
    return Give("swp_link_stats", ToStats(live.protocol.stats(), live.protocol.finished()), stats);
  });
}

swp_result swp_link_copy_text(swp_link* link, swp_link_text which, char* text, uint64_t capacity,
                              uint64_t* size) {
  return UseLink(link, [&](Link& live) {
    if (size == nullptr) return NullArgument("size");
    if (text == nullptr && capacity > 0) return NullArgument("text");
    const SessionStats stats = live.protocol.stats();
    const std::string* const chosen = TextOf(stats, which);
    if (chosen == nullptr) {
      return Fail(
          SWP_INVALID_ARGUMENT,
          "the parameter `which` must be from SWP_LINK_LAST_ERROR (0) to SWP_LINK_POLICY (4)");
    }
    *size = chosen->size();
    if (chosen->size() >= capacity) {
      return Fail(
          SWP_RESOURCE_EXHAUSTED,
          "the buffer is too small for the text and its NUL: give it more than `size` bytes");
    }
    std::memcpy(text, chosen->c_str(), chosen->size() + 1);
    return kOk;
  });
}

swp_result swp_link_beliefs(swp_link* link, swp_belief* beliefs, uint32_t capacity,
                            uint32_t* count) {
  return UseLink(link, [&](Link& live) {
    if (count == nullptr) return NullArgument("count");
    if (beliefs == nullptr && capacity > 0) return NullArgument("beliefs");
    return GiveBeliefs(live.protocol.stats().beliefs, beliefs, capacity, count);
  });
}
