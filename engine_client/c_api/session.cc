// Creates and destroys sessions. Also contains the functions that the frame thread calls.
#include "engine_client/c_api/session.h"

#include <bit>
#include <string>
#include <vector>

#include "engine_client/c_api/executor.h"
#include "engine_client/c_api/sized_struct.h"
#include "sweepstake/session.h"

using sweepstake::AdaptiveBroadPhase;
using sweepstake::AdaptiveOptions;
using sweepstake::Mode;
using sweepstake::SampleQueue;
using sweepstake::SessionOptions;
using sweepstake::ShadowMode;
using namespace sweepstake::c_api;  // NOLINT(google-build-using-namespace)

namespace {

bool IsMode(swp_mode mode) { return mode == SWP_MODE_MANUAL || mode == SWP_MODE_AI; }

swp_result WrongMode() {
  return Fail(SWP_INVALID_ARGUMENT, "mode must be SWP_MODE_MANUAL (1) or SWP_MODE_AI (2)");
}

swp_session_options DefaultSessionOptions() {
  const AdaptiveOptions defaults;
  swp_session_options options{};
  options.struct_size = sizeof options;
  options.mode = static_cast<swp_mode>(defaults.mode);
  options.bail_out_ns = defaults.bail_out_ns;
  options.settling_ns = defaults.settling_ns;
  options.queue_frames = SessionOptions().queue_frames;
  options.shadow = static_cast<swp_shadow_mode>(defaults.shadow.enabled);
  options.shadow_duty_ratio = defaults.shadow.duty_ratio;
  options.shadow_memory_bytes = defaults.shadow.memory_cap_bytes;
  return options;
}

// Splits a list of names at its commas. Returns nothing for NULL and "".
std::vector<std::string> Names(const char* list) {
  std::vector<std::string> names;
  std::string_view rest = TextOr(list, "");
  while (!rest.empty()) {
    const size_t comma = rest.find(',');
    names.emplace_back(rest.substr(0, comma));
    // After a comma at the end there is an empty name. It will be rejected as an unknown arm.
    if (comma + 1 == rest.size()) names.emplace_back();
    rest = comma == std::string_view::npos ? "" : rest.substr(comma + 1);
  }
  return names;
}

swp_result CheckOptions(const swp_session_options& options) {
  if (options.mode == 0)
    return Fail(SWP_INVALID_ARGUMENT,
                "mode is 0: call swp_session_options_init before you set members");
  if (!IsMode(options.mode)) return WrongMode();
  if (!std::has_single_bit(options.queue_frames) || options.queue_frames < 2 ||
      options.queue_frames > SampleQueue::kMaxFrameCapacity) {
    return Fail(SWP_INVALID_ARGUMENT, "queue_frames must be a power of two from 2 to 1048576");
  }
  if (options.shadow > SWP_SHADOW_ON) {
    return Fail(SWP_INVALID_ARGUMENT,
                "shadow must be SWP_SHADOW_OFF (0), SWP_SHADOW_AUTO (1) or SWP_SHADOW_ON (2)");
  }
  if (options.sorted_pairs > 1) return Fail(SWP_INVALID_ARGUMENT, "sorted_pairs must be 0 or 1");
  if (!(options.shadow_duty_ratio > 0 && options.shadow_duty_ratio <= 1)) {
    return Fail(SWP_INVALID_ARGUMENT, "shadow_duty_ratio must be over 0 and at most 1");
  }
  return SWP_OK;
}

AdaptiveOptions ToAdaptiveOptions(const swp_session_options& given) {
  AdaptiveOptions options;
  options.arms = Names(given.arms);
  options.initial_arm = TextOr(given.initial_arm, "");
  options.mode = static_cast<Mode>(given.mode);
  options.bail_out_ns = given.bail_out_ns;
  options.settling_ns = given.settling_ns;
  options.shadow.enabled = static_cast<ShadowMode>(given.shadow);
  options.shadow.duty_ratio = given.shadow_duty_ratio;
  options.shadow.memory_cap_bytes = given.shadow_memory_bytes;
  options.memory_budget_bytes = given.memory_budget_bytes;
  options.sorted_pairs = given.sorted_pairs != 0;
  options.max_pairs = given.max_pairs;
  return options;
}

swp_result CreateSession(const swp_session_options& options, swp_session** session) {
  auto created = std::make_unique<LiveSession>(options.queue_frames);
  const swp_result wrong = MakeExecutor(options.thread_count, options.executor, created->executor);
  if (wrong != SWP_OK) return wrong;
  AdaptiveOptions chosen = ToAdaptiveOptions(options);
  chosen.executor = created->executor.get();
  auto adaptive = AdaptiveBroadPhase::Create(chosen, &created->queue);
  if (!adaptive.ok()) return ToResult(adaptive.status());
  created->adaptive = std::move(*adaptive);
  created->settling_ns = options.settling_ns;
  created->bail_out_ns = options.bail_out_ns;
  Publish(std::move(created), session);
  return SWP_OK;
}

}  // namespace

swp_result swp_session_options_init(swp_session_options* options) {
  return Guard([&] { return Give("swp_session_options", DefaultSessionOptions(), options); });
}

swp_result swp_session_create(const swp_session_options* options, swp_session** session) {
  if (session == nullptr) return NullArgument("session");
  return Guard([&] {
    swp_session_options known = DefaultSessionOptions();
    swp_result wrong = TakeOptions("swp_session_options", options, known);
    if (wrong == SWP_OK) wrong = CheckOptions(known);
    return wrong != SWP_OK ? wrong : CreateSession(known, session);
  });
}

void swp_session_destroy(swp_session* session) { Destroy(session); }

swp_result swp_session_begin_frame(swp_session* session) {
  return Use(session, [](LiveSession& live) {
    if (live.in_frame) {
      return Fail(SWP_FAILED_PRECONDITION,
                  "a frame is already running: call swp_session_end_frame first");
    }
    live.pairs.reset();
    live.adaptive->BeginFrame();
    live.in_frame = true;
    return kOk;
  });
}

swp_result swp_session_find_pairs(swp_session* session, const swp_aabb* boxes, uint32_t box_count) {
  return Use(session, [&](LiveSession& live) {
    live.pairs.reset();
    if (const swp_result wrong = CheckBoxes(boxes, box_count); wrong != SWP_OK) return wrong;
    if (!live.in_frame) {
      return Fail(SWP_FAILED_PRECONDITION, "call swp_session_begin_frame first");
    }
    const auto pairs = live.adaptive->FindPairs(ToBoxes(boxes, box_count));
    if (live.adaptive->pairs_exceeded()) return TooManyPairs();
    live.pairs = pairs;
    return kOk;
  });
}

swp_result swp_session_pairs(const swp_session* session, const swp_pair** pairs, uint64_t* count) {
  return Use(session, [&](const LiveSession& live) {
    if (!live.pairs) return Fail(SWP_FAILED_PRECONDITION, "call swp_session_find_pairs first");
    return GivePairs(*live.pairs, pairs, count);
  });
}

swp_result swp_session_end_frame(swp_session* session, uint64_t frame_time_ns, uint32_t flags) {
  return Use(session, [&](LiveSession& live) {
    if ((flags & ~static_cast<uint32_t>(SWP_FRAME_PAUSED | SWP_FRAME_LOADING)) != 0) {
      return Fail(SWP_INVALID_ARGUMENT,
                  "flags may hold SWP_FRAME_PAUSED and SWP_FRAME_LOADING only");
    }
    if (!live.in_frame) {
      return Fail(SWP_FAILED_PRECONDITION, "call swp_session_begin_frame first");
    }
    live.adaptive->EndFrame({.frame_time_ns = frame_time_ns, .flags = flags});
    live.in_frame = false;
    return kOk;
  });
}

swp_result swp_session_trim(swp_session* session) {
  return Use(session, [](LiveSession& live) {
    if (live.in_frame) {
      return Fail(SWP_FAILED_PRECONDITION, "a frame is running: call swp_session_end_frame first");
    }
    live.pairs.reset();
    live.adaptive->Trim();
    return kOk;
  });
}

swp_result swp_session_select_arm(swp_session* session, const char* arm) {
  return Use(session, [&](LiveSession& live) {
    return arm == nullptr ? NullArgument("arm") : ToResult(live.adaptive->SelectArm(arm));
  });
}

swp_result swp_session_set_mode(swp_session* session, swp_mode mode) {
  return Use(session, [&](LiveSession& live) {
    if (!IsMode(mode)) return WrongMode();
    live.adaptive->SetMode(static_cast<Mode>(mode));
    return kOk;
  });
}

swp_result swp_session_mode(const swp_session* session, swp_mode* mode) {
  return Get(session, "mode", mode, [](const LiveSession& live) { return live.adaptive->mode(); });
}

swp_result swp_session_active_arm(const swp_session* session, uint32_t* arm) {
  return Get(session, "arm", arm,
             [](const LiveSession& live) { return live.adaptive->active_arm(); });
}

swp_result swp_session_switch_epoch(const swp_session* session, uint32_t* switch_epoch) {
  return Get(session, "switch_epoch", switch_epoch,
             [](const LiveSession& live) { return live.adaptive->switch_epoch(); });
}

swp_result swp_session_last_sample(const swp_session* session, swp_frame_sample* sample) {
  return Get(session, "sample", sample, [](const LiveSession& live) {
    return std::bit_cast<swp_frame_sample>(live.adaptive->last_sample());
  });
}
