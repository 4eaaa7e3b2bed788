// The embedded decider of a session: it takes the place of a transport.
#include <algorithm>
#include <variant>

#include "engine_client/c_api/session.h"

using sweepstake::ArmBelief;
using sweepstake::EmbeddedDecider;
using sweepstake::EmbeddedOptions;
using sweepstake::FrameSample;
using sweepstake::ModeNote;
using sweepstake::QueuedItem;
using sweepstake::SceneDescriptor;
using sweepstake::ShadowSample;
using sweepstake::SwitchCommand;
using sweepstake::SwitchOutcome;
using sweepstake::SwitchReason;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

namespace {

// Frames are handed on in runs of this many, so that a long queue needs little memory.
constexpr size_t kFrameRun = 256;

EmbeddedOptions ToEmbeddedOptions(const swp_decider_options& given) {
  EmbeddedOptions options;
  options.policy = TextOr(given.policy, options.policy);
  options.project = TextOr(given.project, options.project);
  options.scene = TextOr(given.scene, options.scene);
  options.machine_class = TextOr(given.machine_class, options.machine_class);
  // The path comes as UTF-8 on every platform.
  const std::string_view priors = TextOr(given.priors_file, "");
  options.priors_file = std::filesystem::path(std::u8string(priors.begin(), priors.end()));
  options.seed = given.seed;
  options.time_scale = given.time_scale;
  return options;
}

swp_decider_options DefaultOptions() {
  const EmbeddedOptions defaults;
  swp_decider_options options{};
  options.struct_size = sizeof options;
  options.seed = defaults.seed;
  options.time_scale = defaults.time_scale;
  return options;
}

void TellBeliefs(swp_session& session) {
  std::vector<double> means;
  for (const ArmBelief& belief : session.decider->beliefs()) {
    means.push_back(belief.alpha / (belief.alpha + belief.beta));
  }
  session.adaptive->SetPosteriorMeans(means);
  session.adaptive->SetVerdict(session.decider->verdict());
}

// The decider believes the first arm and epoch 0 until it hears otherwise.
void TellActiveArm(swp_session& session, uint64_t now_ns) {
  const uint32_t arm = session.adaptive->active_arm();
  const uint32_t epoch = session.adaptive->switch_epoch();
  session.decider->SetMode(session.adaptive->mode(), arm, now_ns);
  if (epoch == 0) return;
  session.decider->Observe(
      SwitchOutcome{
          .arm = arm, .switch_epoch = epoch, .reason = SwitchReason::kManual, .executed = 1},
      now_ns);
}

// The largest durations are cut to 2^63 ns, 292 years: a double near 2^64 fits no integer.
uint64_t Scaled(uint64_t duration_ns, double time_scale) {
  return static_cast<uint64_t>(std::min(static_cast<double>(duration_ns) / time_scale, 0x1p63));
}

swp_result Attach(swp_session& session, EmbeddedOptions options, uint64_t now_ns) {
  options.mode = session.adaptive->mode();
  auto decider = EmbeddedDecider::Create(options, session.adaptive->arms(),
                                         session.adaptive->arm_versions(), now_ns);
  if (!decider.ok()) return ToResult(decider.status());
  session.decider_frames.reserve(kFrameRun);
  session.decider = std::move(*decider);
  TellActiveArm(session, now_ns);
  session.adaptive->SetDeciderPresent(true);
  session.adaptive->SetSettling(Scaled(session.settling_ns, options.time_scale));
  TellBeliefs(session);
  return SWP_OK;
}

void FlushFrames(swp_session& session, uint64_t now_ns) {
  if (!session.decider_frames.empty()) session.decider->Observe(session.decider_frames, now_ns);
  session.decider_frames.clear();
}

void Observe(swp_session& session, const QueuedItem& item, uint64_t now_ns) {
  if (const auto* sample = std::get_if<FrameSample>(&item)) {
    session.decider_frames.push_back(*sample);
    if (session.decider_frames.size() == kFrameRun) FlushFrames(session, now_ns);
    return;
  }
  FlushFrames(session, now_ns);
  if (const auto* outcome = std::get_if<SwitchOutcome>(&item)) {
    session.decider->Observe(*outcome, now_ns);
  } else if (const auto* change = std::get_if<ModeNote>(&item)) {
    session.decider->SetMode(change->mode, change->active_arm, now_ns);
  } else if (const auto* seen = std::get_if<SceneDescriptor>(&item)) {
    session.decider->Observe(*seen);
  }
}

// What the frame thread produced meanwhile goes to the decider, in the order it happened.
std::optional<SwitchCommand> Poll(swp_session& session, uint64_t now_ns) {
  while (const std::optional<QueuedItem> item = session.queue.Pop()) {
    Observe(session, *item, now_ns);
  }
  FlushFrames(session, now_ns);
  while (const std::optional<ShadowSample> sample = session.queue.PopShadow()) {
    session.decider->Observe({&*sample, 1});
  }
  const uint64_t decision_count = session.decider->decision_count();
  const std::optional<SwitchCommand> command = session.decider->Poll(now_ns);
  if (command) session.adaptive->mailbox().Post(*command);
  if (session.decider->decision_count() != decision_count) TellBeliefs(session);
  return command;
}

swp_result NoDecider() {
  return Fail(SWP_FAILED_PRECONDITION,
              "no decider is attached: call swp_session_attach_decider first");
}

}  // namespace

swp_result swp_decider_options_init(swp_decider_options* options) {
  if (options == nullptr) return NullArgument("options");
  return Guard([&] {
    *options = DefaultOptions();
    return static_cast<swp_result>(SWP_OK);
  });
}

swp_result swp_session_attach_decider(swp_session* session, const swp_decider_options* options,
                                      uint64_t now_ns) {
  if (session == nullptr) return NullArgument("session");
  if (session->decider != nullptr) {
    return Fail(SWP_FAILED_PRECONDITION, "a decider is attached already: detach it first");
  }
  return Guard([&] {
    if (const swp_result wrong = CheckStruct("swp_decider_options", options); wrong != SWP_OK) {
      return wrong;
    }
    const swp_decider_options given = options == nullptr ? DefaultOptions() : *options;
    return Attach(*session, ToEmbeddedOptions(given), now_ns);
  });
}

swp_result swp_session_detach_decider(swp_session* session) {
  if (session == nullptr) return NullArgument("session");
  if (session->decider == nullptr) return NoDecider();
  return Guard([&] {
    session->decider.reset();
    session->decider_frames.clear();
    session->adaptive->SetDeciderPresent(false);
    return static_cast<swp_result>(SWP_OK);
  });
}

swp_result swp_session_poll_decider(swp_session* session, uint64_t now_ns,
                                    swp_switch_command* command, uint32_t* commanded) {
  if (session == nullptr) return NullArgument("session");
  if (session->decider == nullptr) return NoDecider();
  return Guard([&] {
    const std::optional<SwitchCommand> posted = Poll(*session, now_ns);
    if (commanded != nullptr) *commanded = posted ? 1 : 0;
    if (posted && command != nullptr) {
      *command = {posted->command_id, posted->arm, static_cast<swp_switch_reason>(posted->reason)};
    }
    return static_cast<swp_result>(SWP_OK);
  });
}

swp_result swp_session_beliefs(const swp_session* session, swp_belief* beliefs, uint32_t capacity,
                               uint32_t* count) {
  if (session == nullptr || count == nullptr) return NullArgument("session and count");
  if (beliefs == nullptr && capacity > 0) return NullArgument("beliefs");
  if (session->decider == nullptr) return NoDecider();
  return Guard([&] {
    const std::vector<ArmBelief> current = session->decider->beliefs();
    *count = static_cast<uint32_t>(current.size());
    if (current.size() > capacity) {
      return Fail(SWP_RESOURCE_EXHAUSTED, "the buffer holds fewer beliefs than there are arms");
    }
    for (size_t i = 0; i < current.size(); ++i) beliefs[i] = {current[i].alpha, current[i].beta};
    return static_cast<swp_result>(SWP_OK);
  });
}

swp_result swp_session_decision_count(const swp_session* session, uint64_t* count) {
  if (session == nullptr || count == nullptr) return NullArgument("session and count");
  if (session->decider == nullptr) return NoDecider();
  *count = session->decider->decision_count();
  return SWP_OK;
}

swp_result swp_session_prior_source_count(const swp_session* session, uint64_t* count) {
  if (session == nullptr || count == nullptr) return NullArgument("session and count");
  if (session->decider == nullptr) return NoDecider();
  *count = session->decider->prior_source_count();
  return SWP_OK;
}
