// The embedded decider of a session, which decides in the game process without a daemon.
#include <algorithm>
#include <utility>

#include "engine_client/c_api/session.h"
#include "engine_client/c_api/sized_struct.h"

using sweepstake::AdaptiveBroadPhase;
using sweepstake::DeciderLoop;
using sweepstake::EmbeddedDecider;
using sweepstake::EmbeddedOptions;
using sweepstake::Status;
using sweepstake::SwitchCommand;
using sweepstake::SwitchOutcome;
using sweepstake::SwitchReason;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

namespace {

EmbeddedOptions ToEmbeddedOptions(const swp_decider_options& given) {
  EmbeddedOptions options;
  options.policy = TextOr(given.policy, options.policy);
  options.project = TextOr(given.project, options.project);
  options.scene = TextOr(given.scene, options.scene);
  options.machine_class = TextOr(given.machine_class, options.machine_class);
  options.build = TextOr(given.build, "");
  options.source_id = TextOr(given.source_id, "");
  options.priors_file = TextOr(given.priors_file, "");
  if (given.priors_data != nullptr) {
    options.priors_data.assign(given.priors_data, given.priors_data_bytes);
  }
  options.seed = given.seed;
  options.time_scale = given.time_scale;
  options.decision_interval_ns = given.decision_interval_ns;
  options.cooldown_ns = given.cooldown_ns;
  options.fps_floor = given.fps_floor;
  options.weights = ToWeights(given.weights);
  return options;
}

swp_decider_options DefaultDeciderOptions() {
  const EmbeddedOptions defaults;
  swp_decider_options options{};
  options.struct_size = sizeof options;
  options.seed = defaults.seed;
  options.time_scale = defaults.time_scale;
  options.decision_interval_ns = defaults.decision_interval_ns;
  options.cooldown_ns = defaults.cooldown_ns;
  options.fps_floor = defaults.fps_floor;
  options.weights = {defaults.weights.fps, defaults.weights.detection, defaults.weights.memory,
                     defaults.weights.checks};
  return options;
}

swp_result Take(const swp_decider_options* given, EmbeddedOptions& options) {
  swp_decider_options known = DefaultDeciderOptions();
  if (swp_result wrong = TakeOptions("swp_decider_options", given, known); wrong != SWP_OK)
    return wrong;
  if (known.time_scale == 0)
    return Fail(SWP_INVALID_ARGUMENT,
                "time_scale is 0: call swp_decider_options_init before you set members");
  if (known.reserved != 0) return Fail(SWP_INVALID_ARGUMENT, "reserved must be 0");
  if (known.priors_data == nullptr && known.priors_data_bytes > 0)
    return NullArgument("if priors_data_bytes is over 0, priors_data");
  options = ToEmbeddedOptions(known);
  return SWP_OK;
}

// Passes the session's active arm and switch epoch to a new decider, which otherwise assumes the
// first arm and epoch 0.
void TellActiveArm(const AdaptiveBroadPhase& adaptive, EmbeddedDecider& decider, uint64_t now_ns) {
  const uint32_t arm = adaptive.active_arm();
  const uint32_t epoch = adaptive.switch_epoch();
  decider.SetMode(adaptive.mode(), arm, now_ns);
  if (epoch == 0) return;
  decider.Observe(
      SwitchOutcome{
          .arm = arm, .switch_epoch = epoch, .reason = SwitchReason::kManual, .executed = 1},
      now_ns);
}

swp_result Attach(LiveSession& session, EmbeddedOptions options, uint64_t now_ns) {
  AdaptiveBroadPhase& adaptive = *session.adaptive;
  options.mode = adaptive.mode();
  options.initial_arm = adaptive.initial_arm();
  options.settling_ns = session.settling_ns;
  auto decider = EmbeddedDecider::Create(options, adaptive.arms(), adaptive.arm_versions(), now_ns);
  if (!decider.ok()) return ToResult(decider.status());
  TellActiveArm(adaptive, **decider, now_ns);
  session.decider_loop.emplace(session.queue, adaptive, std::move(*decider));
  session.decider_loop->PublishBeliefs();
  return SWP_OK;
}

std::optional<SwitchCommand> Poll(DeciderLoop& loop, uint64_t now_ns) {
  loop.TakeQueue(now_ns);
  const std::optional<SwitchCommand> command = loop.Decide(now_ns);
  if (loop.has_news()) loop.PublishBeliefs();
  return command;
}

swp_result NoDecider() {
  return Fail(SWP_FAILED_PRECONDITION,
              "no decider is attached: call swp_session_attach_decider first");
}

}  // namespace

swp_result swp_decider_options_init(swp_decider_options* options) {
  return Guard([&] { return Give("swp_decider_options", DefaultDeciderOptions(), options); });
}

swp_result swp_session_attach_decider(swp_session* session, const swp_decider_options* options,
                                      uint64_t now_ns) {
  return Use(session, [&](LiveSession& live) {
    if (live.decider_loop || live.link != nullptr) {
      return Fail(SWP_FAILED_PRECONDITION,
                  "the session already has a decider or a link: detach the decider or destroy the "
                  "link first");
    }
    EmbeddedOptions taken;
    const swp_result wrong = Take(options, taken);
    return wrong != SWP_OK ? wrong : Attach(live, std::move(taken), now_ns);
  });
}

swp_result swp_session_freeze(swp_session* session, const swp_decider_options* options) {
  return Use(session, [&](LiveSession& live) {
    AdaptiveBroadPhase& adaptive = *live.adaptive;
    EmbeddedOptions priors;
    if (const swp_result wrong = Take(options, priors); wrong != SWP_OK) return wrong;
    if (options != nullptr) {
      const auto arm =
          EmbeddedDecider::ArmOfPriors(priors, adaptive.arms(), adaptive.arm_versions());
      if (!arm.ok()) return ToResult(arm.status());
      if (const Status selected = adaptive.SelectArm(*arm); !selected.ok())
        return ToResult(selected);
    }
    adaptive.Freeze();
    return kOk;
  });
}

swp_result swp_session_detach_decider(swp_session* session) {
  return Use(session, [](LiveSession& live) {
    if (!live.decider_loop) return NoDecider();
    live.adaptive->SetDeciderPresent(false);
    live.adaptive->SetSettling(live.settling_ns);
    live.adaptive->SetLaneUse(true);
    live.decider_loop.reset();
    return kOk;
  });
}

swp_result swp_session_poll_decider(swp_session* session, uint64_t now_ns,
                                    swp_switch_command* command, uint32_t* commanded) {
  return Use(session, [&](LiveSession& live) {
    if (!live.decider_loop) return NoDecider();
    const std::optional<SwitchCommand> posted = Poll(*live.decider_loop, now_ns);
    if (commanded != nullptr) *commanded = posted ? 1 : 0;
    if (posted && command != nullptr) {
      *command = {posted->command_id, posted->arm, static_cast<swp_switch_reason>(posted->reason)};
    }
    return kOk;
  });
}

swp_result swp_session_beliefs(const swp_session* session, swp_belief* beliefs, uint32_t capacity,
                               uint32_t* count) {
  return Use(session, [&](const LiveSession& live) {
    if (count == nullptr) return NullArgument("count");
    if (beliefs == nullptr && capacity > 0) return NullArgument("beliefs");
    if (!live.decider_loop) return NoDecider();
    return GiveBeliefs(live.decider_loop->decider().beliefs(), beliefs, capacity, count);
  });
}

swp_result swp_session_decision_count(const swp_session* session, uint64_t* count) {
  return Use(session, [&](const LiveSession& live) {
    if (count == nullptr) return NullArgument("count");
    if (!live.decider_loop) return NoDecider();
    *count = live.decider_loop->decider().decision_count();
    return kOk;
  });
}

swp_result swp_session_prior_source_count(const swp_session* session, uint64_t* count) {
  return Use(session, [&](const LiveSession& live) {
    if (count == nullptr) return NullArgument("count");
    if (!live.decider_loop) return NoDecider();
    *count = live.decider_loop->decider().prior_source_count();
    return kOk;
  });
}

swp_result swp_session_export_priors(const swp_session* session, char* data, uint64_t capacity,
                                     uint64_t* bytes) {
  return Use(session, [&](const LiveSession& live) {
    if (bytes == nullptr) return NullArgument("bytes");
    if (data == nullptr && capacity > 0) return NullArgument("data");
    if (!live.decider_loop) return NoDecider();
    const std::string priors = live.decider_loop->decider().ExportPriors();
    *bytes = priors.size();
    if (priors.size() > capacity) return TooFewPlaces();
    std::copy(priors.begin(), priors.end(), data);
    return kOk;
  });
}
