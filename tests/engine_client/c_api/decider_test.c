/* Tests the embedded decider on a scripted clock: it explores every arm once, then decides, and
 * bails out after a long frame. */
#include <stdlib.h>
#include <string.h>

#include "tests/engine_client/c_api/check.h"

enum { kObjects = 100 };
static const uint64_t kFrameNs = 16000000;
static const uint64_t kStartNs = 1000000000;
static const uint64_t kSettlingNs = 2000000000;

typedef struct game {
  swp_session* session;
  swp_scene* scene;
  uint64_t now_ns;
  uint32_t command_count;
  swp_switch_command last_command;
} game;

static void play_frame(game* played, uint64_t frame_ns) {
  const swp_aabb* boxes = NULL;
  uint32_t count = 0;
  CHECK_OK(swp_scene_boxes(played->scene, &boxes, &count));
  CHECK_OK(swp_session_begin_frame(played->session));
  CHECK_OK(swp_session_find_pairs(played->session, boxes, count));
  CHECK_OK(swp_session_end_frame(played->session, frame_ns, 0));
  played->now_ns += frame_ns;
  CHECK_OK(swp_scene_step(played->scene));
}

static void run_frame(game* played, uint64_t frame_ns) {
  uint32_t commanded = 99;
  play_frame(played, frame_ns);
  CHECK_OK(
      swp_session_poll_decider(played->session, played->now_ns, &played->last_command, &commanded));
  CHECK(commanded <= 1);
  played->command_count += commanded;
}

static int has_text(const char* text, uint64_t bytes, const char* wanted) {
  const size_t length = strlen(wanted);
  for (uint64_t at = 0; at + length <= bytes; ++at) {
    if (memcmp(text + at, wanted, length) == 0) return 1;
  }
  return 0;
}

/* Without a lane, whose visits depend on the machine, a decision depends on the frames alone. */
static swp_session* make_session(uint64_t settling_ns) {
  swp_session_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  CHECK_OK(swp_session_options_init(&options));
  options.shadow = SWP_SHADOW_OFF;
  options.settling_ns = settling_ns;
  CHECK_OK(swp_session_create(&options, &session));
  return session;
}

static game start_game(void) {
  swp_decider_options options = {.struct_size = sizeof options};
  game played = {
      make_session(kSettlingNs), make_scene("suite-b", kObjects), kStartNs, 0, {0, 0, 0}};
  CHECK_OK(swp_decider_options_init(&options));
  options.policy = "paper";
  options.project = "c test";
  options.scene = "suite";
  options.machine_class = "any";
  options.build = "1.1";
  options.source_id = "player";
  options.seed = 11;
  options.time_scale = 4;
  CHECK_OK(swp_session_attach_decider(played.session, &options, played.now_ns));
  CHECK(swp_session_attach_decider(played.session, &options, played.now_ns) ==
        SWP_FAILED_PRECONDITION);
  return played;
}

/* The exploration gives each arm 6 s (1.5 s at this time scale of 4) and the time until the next
 * decision. */
static void check_exploration(game* played) {
  uint32_t visited = 0;
  uint32_t epoch = 99;
  for (int frame = 0; frame < 20 * 60; ++frame) {
    uint32_t arm = 99;
    run_frame(played, kFrameNs);
    CHECK_OK(swp_session_active_arm(played->session, &arm));
    visited |= 1U << arm;
  }
  CHECK(visited == (1U << swp_backend_count()) - 1);
  CHECK_OK(swp_session_switch_epoch(played->session, &epoch));
  CHECK(epoch + 1 >= swp_backend_count());
  CHECK(played->command_count + 1 >= swp_backend_count());
}

static void check_beliefs(const game* played) {
  swp_belief beliefs[32];
  uint32_t count = swp_backend_count();
  uint64_t decision_count = 0;
  uint64_t source_count = 99;
  CHECK(swp_session_beliefs(played->session, beliefs, count - 1, &count) == SWP_RESOURCE_EXHAUSTED);
  CHECK(count == swp_backend_count());
  CHECK_OK(swp_session_beliefs(played->session, beliefs, count, &count));
  for (uint32_t i = 0; i < count; ++i) {
    CHECK(beliefs[i].alpha > 1 && beliefs[i].beta >= 1);
  }
  CHECK_OK(swp_session_decision_count(played->session, &decision_count));
  CHECK(decision_count > 7);
  CHECK_OK(swp_session_prior_source_count(played->session, &source_count));
  CHECK(source_count == 0);
}

/* The exploration has learnt something, so there is a leader. */
static void check_verdict(const game* played) {
  swp_verdict verdict = {SWP_VERDICT_UNKNOWN, 99, -1};
  CHECK_OK(swp_session_verdict(played->session, &verdict));
  CHECK(verdict.kind > SWP_VERDICT_UNKNOWN && verdict.kind <= SWP_VERDICT_AMBIGUOUS);
  CHECK(verdict.leader_arm < swp_backend_count());
  CHECK(verdict.leader_probability > 1.0 / swp_backend_count() && verdict.leader_probability <= 1);
}

static void check_no_decision(swp_session* session) {
  swp_decision decision = {.struct_size = sizeof decision, .outcome = 99};
  swp_switch_outcome outcome = {.command_id = 99, .reason = 99};
  CHECK_OK(swp_session_last_decision(session, &decision));
  CHECK(decision.outcome == SWP_DECISION_NONE && decision.decision_id == 0);
  CHECK_OK(swp_session_last_outcome(session, &outcome));
  CHECK(outcome.command_id == 0 && outcome.reason == 0);
}

/* Checks the latest decision with a command and its reasons, and the outcome of an earlier
 * decision's switch. */
static void check_last_decision(game* played) {
  const uint32_t arm_count = swp_backend_count();
  const uint32_t before = played->command_count;
  swp_decision decision = {.struct_size = sizeof decision};
  swp_switch_outcome outcome;
  uint64_t decision_count = 0;
  double sum = 0;
  for (int i = 0; i < 400 * 60 && played->command_count == before; ++i) run_frame(played, kFrameNs);
  CHECK_OK(swp_session_last_decision(played->session, &decision));
  CHECK_OK(swp_session_decision_count(played->session, &decision_count));
  CHECK(decision.decision_id == decision_count && decision.time_ns == played->now_ns);
  CHECK(decision.outcome == SWP_DECISION_SWITCHED);
  CHECK(decision.candidate_arm == played->last_command.arm);
  CHECK(decision.command_arm == played->last_command.arm);
  CHECK(decision.command_id == played->last_command.command_id);
  CHECK(decision.command_reason == SWP_SWITCH_POLICY);
  CHECK(decision.active_arm != decision.candidate_arm);
  for (uint32_t i = 0; i < SWP_MAX_ARMS; ++i) sum += decision.best_probability[i];
  CHECK(sum > 0.999 && sum < 1.001 && decision.best_probability[arm_count] == 0);
  CHECK(decision.best_probability[decision.verdict.leader_arm] ==
        decision.verdict.leader_probability);
  CHECK_OK(swp_session_last_outcome(played->session, &outcome));
  CHECK(outcome.command_id > 0 && outcome.command_id < decision.command_id);
  CHECK(outcome.executed == 1 && outcome.switch_epoch > 0);
}

/* Frames just above 1/30 s are below the floor of 30 frames/s with every arm, and would reach it
 * without the broad phase. The verdict becomes `degraded` after some such frames of the leading
 * arm. Which arm leads depends on the search times of this machine. */
static const uint64_t kJustTooLongNs = 33333400;

static void check_degraded(game* played) {
  swp_verdict verdict = {SWP_VERDICT_UNKNOWN, 0, 0};
  for (int frame = 0; frame < 60 * 400 && verdict.kind != SWP_VERDICT_DEGRADED; ++frame) {
    run_frame(played, kJustTooLongNs);
    CHECK_OK(swp_session_verdict(played->session, &verdict));
  }
  CHECK(verdict.kind == SWP_VERDICT_DEGRADED);
}

/* In manual mode nothing is decided. */
static void check_manual(game* played) {
  uint32_t before = 99;
  uint32_t after = 98;
  CHECK_OK(swp_session_set_mode(played->session, SWP_MODE_MANUAL));
  run_frame(played, kFrameNs);
  CHECK_OK(swp_session_switch_epoch(played->session, &before));
  for (int frame = 0; frame < 30 * 60; ++frame) run_frame(played, kFrameNs);
  CHECK_OK(swp_session_switch_epoch(played->session, &after));
  CHECK(before == after);
}

/* These frames are too slow for the default floor, but not for a lower one. The interval of 0.5 s
 * gives 120 decisions in 60 s. */
static void check_intervals_and_floor(void) {
  for (int is_low = 0; is_low <= 1; ++is_low) {
    swp_decider_options options = {.struct_size = sizeof options};
    swp_verdict verdict = {99, 99, 99};
    uint64_t decision_count = 0;
    game played = {make_session(kSettlingNs), make_scene("suite-b", kObjects), 0, 0, {0, 0, 0}};
    CHECK_OK(swp_decider_options_init(&options));
    CHECK(options.decision_interval_ns == 2000000000 && options.cooldown_ns == 40000000000);
    CHECK(options.fps_floor == 30);
    options.policy = "paper";
    options.decision_interval_ns = 500000000;
    options.fps_floor = is_low ? 10 : 30;
    CHECK_OK(swp_session_attach_decider(played.session, &options, played.now_ns));
    for (int frame = 0; frame < 30 * 60; ++frame) run_frame(&played, kJustTooLongNs);
    CHECK_OK(swp_session_verdict(played.session, &verdict));
    CHECK((verdict.kind == SWP_VERDICT_DEGRADED) == !is_low);
    CHECK_OK(swp_session_decision_count(played.session, &decision_count));
    CHECK(decision_count >= 119 && decision_count <= 121);
    swp_session_destroy(played.session);
    swp_scene_destroy(played.scene);
  }
}

/* The outcome of a switch is reported when the session has settled. */
static void check_settled_frames(game* played, uint64_t settling_ns) {
  uint32_t arm = 99;
  uint32_t epoch = 99;
  swp_switch_outcome outcome;
  CHECK_OK(swp_session_set_mode(played->session, SWP_MODE_MANUAL));
  CHECK_OK(swp_session_active_arm(played->session, &arm));
  CHECK_OK(swp_session_switch_epoch(played->session, &epoch));
  CHECK_OK(swp_session_select_arm(played->session, swp_backend_name(arm == 0)));
  for (uint64_t ns = 0; ns < settling_ns; ns += 20000000) {
    play_frame(played, 20000000);
    CHECK_OK(swp_session_last_outcome(played->session, &outcome));
    CHECK((outcome.switch_epoch == epoch + 1) == (ns + 20000000 >= settling_ns));
  }
}

/* The decider uses the settling time that the game sets, divided by its time scale. */
static void check_settling(void) {
  enum { kTimeScale = 2 };
  swp_decider_options decider = {.struct_size = sizeof decider};
  swp_decision decision = {.struct_size = sizeof decision};
  game played = {make_session(800000000), make_scene("suite-b", kObjects), 0, 0, {0, 0, 0}};
  CHECK_OK(swp_decider_options_init(&decider));
  decider.time_scale = kTimeScale;
  decider.decision_interval_ns = 200000000;
  CHECK_OK(swp_session_attach_decider(played.session, &decider, played.now_ns));
  for (int frame = 0; frame < 19; ++frame) {
    run_frame(&played, 20000000);
    CHECK_OK(swp_session_last_decision(played.session, &decision));
    CHECK(decision.decision_id == 0 || decision.outcome == SWP_DECISION_HELD_SETTLING);
  }
  CHECK(decision.decision_id > 1);
  int settled = 0; /* a decision after that may begin another trial, which settles again */
  for (int frame = 0; frame < 12; ++frame) {
    run_frame(&played, 20000000);
    CHECK_OK(swp_session_last_decision(played.session, &decision));
    settled |= decision.outcome != SWP_DECISION_HELD_SETTLING;
  }
  CHECK(settled);
  check_settled_frames(&played, 800000000 / kTimeScale);
  CHECK_OK(swp_session_detach_decider(played.session));
  check_settled_frames(&played, 800000000);
  swp_session_destroy(played.session);

  played.session = make_session(UINT64_MAX);
  CHECK(swp_session_attach_decider(played.session, NULL, 0) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "settling_ns") != NULL);
  swp_session_destroy(played.session);
  swp_scene_destroy(played.scene);
}

/* With the weight of the memory alone, the small scene's reward is nearly 1. Evidence of own
 * weights has a reward version of its own. */
static void check_weights(void) {
  swp_decider_options options = {.struct_size = sizeof options};
  swp_belief beliefs[32];
  uint32_t count = 0;
  static char priors[1 << 16];
  uint64_t bytes = 0;
  double alpha_sum = 0;
  double beta_sum = 0;
  game played = {make_session(0), make_scene("suite-b", kObjects), 0, 0, {0, 0, 0}};
  CHECK_OK(swp_decider_options_init(&options));
  options.policy = "paper";
  options.decision_interval_ns = 500000000;
  options.weights = (swp_reward_weights){0, 0, 1, 0};
  CHECK_OK(swp_session_attach_decider(played.session, &options, played.now_ns));
  for (int frame = 0; frame < 20 * 50; ++frame) run_frame(&played, 20000000);
  CHECK_OK(swp_session_beliefs(played.session, beliefs, 32, &count));
  for (uint32_t i = 0; i < count; ++i) {
    alpha_sum += beliefs[i].alpha - 1;
    beta_sum += beliefs[i].beta - 1;
  }
  CHECK(alpha_sum > 10 && beta_sum < 0.1 * alpha_sum);
  CHECK_OK(swp_session_export_priors(played.session, priors, sizeof priors, &bytes));
  CHECK(has_text(priors, bytes, "\"reward_version\":1") &&
        !has_text(priors, bytes, "\"reward_version\":1,"));
  swp_session_destroy(played.session);
  swp_scene_destroy(played.scene);
}

static void check_attach_errors(void) {
  swp_decider_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  CHECK_OK(swp_session_create(NULL, &session));
  CHECK(swp_session_detach_decider(session) == SWP_FAILED_PRECONDITION);
  CHECK(swp_session_poll_decider(session, 1, NULL, NULL) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_decider_options_init(&options));
  options.policy = "coin";
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_NOT_FOUND ||
        swp_session_attach_decider(session, &options, 0) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "paper") != NULL);
  CHECK_OK(swp_decider_options_init(&options));
  options.priors_file = "no/such/file.json";
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_NOT_FOUND);
  options.priors_file = NULL;
  options.time_scale = 0;
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "call swp_decider_options_init") != NULL);
  options.time_scale = 1;
  options.decision_interval_ns = 0;
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "decision_interval_ns") != NULL);
  options.decision_interval_ns = 1;
  options.cooldown_ns = UINT64_MAX;
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "cooldown_ns") != NULL);
  options.cooldown_ns = 0;
  options.fps_floor = -1;
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "fps_floor") != NULL);
  options.fps_floor = 0;
  options.weights.fps = 0.5;
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "the reward weights sum to 0.95") != NULL);
  options.weights.fps = -0.45;
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "use numbers from 0 to 1") != NULL);
  options.weights.fps = 0.55;
  options.reserved = 1;
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_INVALID_ARGUMENT);
  CHECK_OK(swp_session_attach_decider(session, NULL, 0));
  swp_session_destroy(session);
}

/* A frozen session is in manual mode and measures no times. */
static void check_freeze(swp_session* session, swp_decider_options* options) {
  static const swp_aabb kBox = {{0, 0, 0}, {1, 1, 1}};
  swp_frame_sample sample;
  swp_mode mode = 99;
  const char* const project = options->project;
  options->project = "unknown";
  CHECK(swp_session_freeze(session, options) == SWP_NOT_FOUND);
  CHECK(strstr(swp_last_error(), "unknown") != NULL);
  CHECK_OK(swp_session_mode(session, &mode));
  CHECK(mode == SWP_MODE_AI);
  options->project = project;
  CHECK_OK(swp_session_freeze(session, options));
  CHECK_OK(swp_session_freeze(session, NULL));
  CHECK_OK(swp_session_mode(session, &mode));
  CHECK(mode == SWP_MODE_MANUAL);
  CHECK_OK(swp_session_begin_frame(session));
  CHECK_OK(swp_session_find_pairs(session, &kBox, 1));
  CHECK_OK(swp_session_end_frame(session, kFrameNs, 0));
  CHECK_OK(swp_session_last_sample(session, &sample));
  CHECK(sample.detection_time_ns == 0 && sample.object_count == 1);
  CHECK_OK(swp_session_set_mode(session, SWP_MODE_AI));
}

/* The next decider starts from the exported priors; importing them twice counts once. */
static void check_priors(const game* played) {
  swp_decider_options options = {.struct_size = sizeof options};
  swp_session* session = NULL;
  uint64_t bytes = 0;
  uint64_t again_bytes = 0;
  uint64_t source_count = 99;
  CHECK(swp_session_export_priors(played->session, NULL, 0, &bytes) == SWP_RESOURCE_EXHAUSTED);
  char* priors = malloc(bytes);
  char* again = malloc(bytes);
  CHECK(swp_session_export_priors(played->session, priors, bytes - 1, &bytes) ==
        SWP_RESOURCE_EXHAUSTED);
  CHECK_OK(swp_session_export_priors(played->session, priors, bytes, &bytes));
  CHECK(bytes > 100 && priors[0] == '{');
  CHECK(has_text(priors, bytes, "\"build\":\"1.1\""));
  CHECK_OK(swp_session_create(NULL, &session));
  CHECK_OK(swp_decider_options_init(&options));
  options.policy = "paper";
  options.project = "c test";
  options.scene = "suite";
  options.machine_class = "any";
  options.priors_data = priors;
  options.priors_data_bytes = bytes;
  CHECK_OK(swp_session_attach_decider(session, &options, 0));
  CHECK_OK(swp_session_prior_source_count(session, &source_count));
  CHECK(source_count == 1);
  CHECK_OK(swp_session_export_priors(session, again, bytes, &again_bytes));
  CHECK(again_bytes == bytes && memcmp(again, priors, bytes) == 0);
  CHECK_OK(swp_session_detach_decider(session));
  check_freeze(session, &options);
  CHECK(swp_session_export_priors(session, again, bytes, &again_bytes) == SWP_FAILED_PRECONDITION);
  priors[0] = '[';
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_DATA_LOSS);
  options.priors_data = NULL;
  CHECK(swp_session_attach_decider(session, &options, 0) == SWP_INVALID_ARGUMENT);
  swp_session_destroy(session);
  free(priors);
  free(again);
}

void test_decider(void) {
  game played = start_game();
  swp_verdict verdict = {99, 99, 99};
  CHECK_OK(swp_session_verdict(played.session, &verdict));
  CHECK(verdict.kind == SWP_VERDICT_UNKNOWN);
  check_no_decision(played.session);
  check_exploration(&played);
  check_beliefs(&played);
  check_priors(&played);
  check_verdict(&played);
  check_last_decision(&played);
  check_degraded(&played);
  check_manual(&played);
  CHECK_OK(swp_session_detach_decider(played.session));
  swp_session_destroy(played.session);
  swp_scene_destroy(played.scene);
  check_intervals_and_floor();
  check_settling();
  check_weights();
  check_attach_errors();
}
