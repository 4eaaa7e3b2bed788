/* Tests a link with a daemon. Each test writes the daemon's messages byte by byte. */
#include <string.h>

#include "tests/engine_client/c_api/check.h"

enum { kMs = 1000000, kHello = 2, kFrameBatch = 3, kSwitchOutcome = 4, kGoodbye = 7 };

/* A message of the daemon: encoded fields of protocol buffers. */
typedef struct bytes {
  unsigned char data[512];
  uint64_t size;
} bytes;

static void put_varint(bytes* out, uint64_t value) {
  for (; value >= 128; value >>= 7) out->data[out->size++] = (unsigned char)(value | 128);
  out->data[out->size++] = (unsigned char)value;
}

static void put_number(bytes* out, unsigned field, uint64_t value) {
  put_varint(out, field << 3);
  put_varint(out, value);
}

static void put_bytes(bytes* out, unsigned field, const void* data, uint64_t size) {
  put_varint(out, field << 3 | 2);
  put_varint(out, size);
  memcpy(out->data + out->size, data, size);
  out->size += size;
}

static void put_text(bytes* out, unsigned field, const char* text) {
  put_bytes(out, field, text, strlen(text));
}

static void put_double(bytes* out, unsigned field, double value) {
  put_varint(out, field << 3 | 1);
  memcpy(out->data + out->size, &value, sizeof value);
  out->size += sizeof value;
}

static bytes response_with(unsigned field, const bytes* part) {
  bytes response = {.size = 0};
  put_bytes(&response, field, part->data, part->size);
  return response;
}

static bytes welcome(const char* session, int resumed, uint64_t acknowledged) {
  bytes part = {.size = 0};
  put_text(&part, 1, session);
  put_number(&part, 2, (uint64_t)resumed);
  put_number(&part, 3, acknowledged);
  put_number(&part, 9, 4000); /* bail_out_ms */
  put_text(&part, 10, "1.2.3");
  put_text(&part, 15, "token");
  return response_with(1, &part);
}

static bytes switch_command(uint64_t id, uint32_t arm) {
  bytes part = {.size = 0};
  put_number(&part, 1, id);
  put_number(&part, 2, arm);
  put_number(&part, 3, SWP_SWITCH_POLICY);
  return response_with(2, &part);
}

static bytes snapshot(uint32_t arm_count) {
  bytes part = {.size = 0};
  for (uint32_t i = 0; i < arm_count; ++i) {
    bytes posterior = {.size = 0};
    put_double(&posterior, 1, i + 1);
    put_double(&posterior, 2, 4);
    put_bytes(&part, 1, posterior.data, posterior.size);
  }
  put_number(&part, 2, SWP_VERDICT_TIE);
  put_number(&part, 3, 1);
  put_double(&part, 4, 0.5);
  return response_with(4, &part);
}

/* Returns a google.rpc.Status with an ErrorInfo. */
static bytes details_with(uint32_t code, const char* reason) {
  bytes info = {.size = 0};
  bytes any = {.size = 0};
  bytes status = {.size = 0};
  put_text(&info, 1, reason);
  put_text(&info, 2, "sweepstake");
  put_text(&any, 1, "type.googleapis.com/google.rpc.ErrorInfo");
  put_bytes(&any, 2, info.data, info.size);
  put_number(&status, 1, code);
  put_text(&status, 2, "why");
  put_bytes(&status, 3, any.data, any.size);
  return status;
}

typedef struct game {
  swp_session* session;
  swp_link* link;
  uint64_t now_ns;
} game;

static game make_game(void) {
  const char* const arms = "BruteForce,Grid";
  swp_session_options session = {.struct_size = sizeof session};
  swp_link_options options = {.struct_size = sizeof options};
  game made = {NULL, NULL, 1000 * (uint64_t)kMs};
  CHECK_OK(swp_session_options_init(&session));
  session.arms = arms;
  session.settling_ns = 1;
  session.shadow = SWP_SHADOW_OFF;
  CHECK_OK(swp_session_create(&session, &made.session));
  CHECK_OK(swp_link_options_init(&options));
  options.batch_frames = 1;
  options.daemon = "host:1";
  CHECK_OK(swp_link_create(made.session, &options, &made.link));
  return made;
}

static void end_game(const game* played) {
  swp_link_destroy(played->link);
  swp_session_destroy(played->session);
}

static void run_frames(const game* played, int count) {
  const swp_aabb boxes[2] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {1, 1, 1}}};
  for (int i = 0; i < count; ++i) {
    CHECK_OK(swp_session_begin_frame(played->session));
    CHECK_OK(swp_session_find_pairs(played->session, boxes, 2));
    CHECK_OK(swp_session_end_frame(played->session, 10 * kMs, 0));
  }
}

static swp_link_action next(const game* played, bytes* message) {
  swp_link_action action = 99;
  CHECK_OK(swp_link_next_message(played->link, played->now_ns, message->data, sizeof message->data,
                                 &message->size, &action));
  return action;
}

static uint64_t take_varint(const bytes* in, uint64_t* at) {
  uint64_t value = 0;
  for (unsigned shift = 0; *at < in->size; shift += 7) {
    const unsigned char part = in->data[(*at)++];
    value |= (uint64_t)(part & 127) << shift;
    if (part < 128) break;
  }
  return value;
}

/* Returns the kind of the next message, or 0 if none is due, and sets its sequence number. Checks
 * the size of the message. */
static unsigned next_kind(const game* played, unsigned* sequence) {
  bytes message;
  uint64_t at = 0;
  *sequence = 0;
  if (next(played, &message) != SWP_LINK_SEND) return 0;
  uint64_t key = take_varint(&message, &at);
  if (key == 1 << 3) {
    *sequence = (unsigned)take_varint(&message, &at);
    key = take_varint(&message, &at);
  }
  const uint64_t size = take_varint(&message, &at);
  CHECK(at + size == message.size);
  return (unsigned)(key >> 3);
}

static swp_result receive(const game* played, bytes message) {
  return swp_link_on_message(played->link, message.data, message.size, played->now_ns);
}

static uint32_t disconnect(const game* played, uint32_t code, const char* reason) {
  const bytes details = details_with(code, reason);
  uint32_t delay_ms = 99;
  CHECK_OK(swp_link_disconnected(played->link, code, "why", details.data, details.size,
                                 played->now_ns, &delay_ms));
  return delay_ms;
}

static void go_online(const game* played) {
  unsigned sequence = 99;
  CHECK_OK(swp_link_connected(played->link, played->now_ns));
  CHECK(next_kind(played, &sequence) == kHello && sequence == 0);
  CHECK(next_kind(played, &sequence) == 0);
  CHECK_OK(receive(played, welcome("a", 0, 0)));
}

static int has_text(const game* played, swp_link_text which, const char* part) {
  char text[1024];
  uint64_t size = 0;
  CHECK_OK(swp_link_copy_text(played->link, which, text, sizeof text, &size));
  CHECK(strlen(text) == size);
  return strstr(text, part) != NULL;
}

static swp_link_stats stats_of(const game* played) {
  swp_link_stats stats = {.struct_size = sizeof stats};
  CHECK_OK(swp_link_status(played->link, &stats));
  return stats;
}

static void check_options(void) {
  swp_link_options options = {.struct_size = sizeof options};
  swp_link* link = NULL;
  game played = make_game();
  CHECK(swp_link_create(played.session, NULL, &link) == SWP_FAILED_PRECONDITION);
  CHECK(swp_session_attach_decider(played.session, NULL, 0) == SWP_FAILED_PRECONDITION);
  swp_link_destroy(played.link);
  CHECK_OK(swp_link_options_init(&options));
  options.batch_frames = 241;
  CHECK(swp_link_create(played.session, &options, &link) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "batch_frames") != NULL);
  options.batch_frames = 240;
  options.ignore_priors = 2;
  CHECK(swp_link_create(played.session, &options, &link) == SWP_INVALID_ARGUMENT);
  options.ignore_priors = 0;
  options.weights.fps = 0.5;
  CHECK(swp_link_create(played.session, &options, &link) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "the reward weights sum to 0.5") != NULL);
  options.weights.fps = 0;
  options.cooldown_ns = SWP_DAEMON_VALUE - 1;
  CHECK(swp_link_create(played.session, &options, &link) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "cooldown_ns") != NULL);
  options.cooldown_ns = SWP_DAEMON_VALUE;
  options.daemon = "host\nname";
  CHECK(swp_link_create(played.session, &options, &link) == SWP_INVALID_ARGUMENT);
  CHECK(strstr(swp_last_error(), "daemon must be") != NULL);
  CHECK_OK(swp_session_attach_decider(played.session, NULL, 0));
  CHECK(swp_link_create(played.session, NULL, &link) == SWP_FAILED_PRECONDITION);
  CHECK_OK(swp_session_detach_decider(played.session));
  CHECK_OK(swp_link_create(played.session, NULL, &link));
  CHECK(swp_live_count(SWP_KIND_LINK) == 1);
  swp_link_destroy(link);
  CHECK(swp_live_count(SWP_KIND_LINK) == 0);
  swp_session_destroy(played.session);
}

static int contains(const bytes* all, const bytes* part) {
  for (uint64_t at = 0; at + part->size <= all->size; ++at) {
    if (memcmp(all->data + at, part->data, part->size) == 0) return 1;
  }
  return 0;
}

/* The Hello has the rules that the game sets, and no others. */
static void check_rules(void) {
  bytes weights = {.size = 0};
  bytes intervals = {.size = 0};
  bytes part = {.size = 0};
  put_double(&part, 1, 0.25);
  put_double(&part, 2, 0.25);
  put_double(&part, 3, 0.5);
  put_bytes(&weights, 17, part.data, part.size);
  put_number(&intervals, 18, 500 * kMs);
  put_number(&intervals, 19, 0);
  put_number(&intervals, 20, 3);
  for (int is_set = 0; is_set <= 1; ++is_set) {
    swp_link_options options = {.struct_size = sizeof options};
    bytes hello = {.size = 0};
    game played = make_game();
    swp_link_destroy(played.link);
    CHECK_OK(swp_link_options_init(&options));
    if (is_set) {
      options.weights = (swp_reward_weights){0.25, 0.25, 0.5, 0};
      options.decision_interval_ns = 500 * kMs;
      options.cooldown_ns = 0;
      options.settling_ns = 3;
    }
    CHECK_OK(swp_link_create(played.session, &options, &played.link));
    CHECK_OK(swp_link_connected(played.link, played.now_ns));
    CHECK(next(&played, &hello) == SWP_LINK_SEND);
    CHECK(contains(&hello, &weights) == is_set);
    CHECK(contains(&hello, &intervals) == is_set);
    end_game(&played);
  }
}

/* A command is passed to the frame thread, and its outcome is sent in order with the frames. */
static void check_session(void) {
  game played = make_game();
  unsigned sequence = 0;
  unsigned kind = 0;
  uint32_t arm = 99;
  swp_verdict verdict = {99, 99, 99};
  swp_belief beliefs[2] = {{0, 0}, {0, 0}};
  uint32_t count = 99;
  CHECK_OK(swp_link_beliefs(played.link, NULL, 0, &count));
  CHECK(count == 0);
  CHECK(stats_of(&played).state == SWP_LINK_OFFLINE);
  go_online(&played);
  CHECK(stats_of(&played).state == SWP_LINK_ONLINE);
  CHECK(has_text(&played, SWP_LINK_SESSION_ID, "a"));
  CHECK(has_text(&played, SWP_LINK_DAEMON_VERSION, "1.2.3"));
  CHECK_OK(receive(&played, switch_command(7, 1)));
  CHECK_OK(receive(&played, snapshot(2)));
  run_frames(&played, 4);
  CHECK_OK(swp_session_active_arm(played.session, &arm));
  CHECK(arm == 1);
  for (unsigned i = 1; kind != kSwitchOutcome && i < 10; ++i) {
    kind = next_kind(&played, &sequence);
    CHECK((kind == kFrameBatch || kind == kSwitchOutcome) && sequence == i);
  }
  CHECK(kind == kSwitchOutcome);
  CHECK_OK(swp_session_verdict(played.session, &verdict));
  CHECK(verdict.kind == SWP_VERDICT_TIE && verdict.leader_probability == 0.5);
  CHECK(swp_link_beliefs(played.link, beliefs, 1, &count) == SWP_RESOURCE_EXHAUSTED && count == 2);
  CHECK_OK(swp_link_beliefs(played.link, beliefs, 2, &count));
  CHECK(beliefs[1].alpha == 2 && beliefs[1].beta == 4);
  end_game(&played);
}

/* A message that does not fit in the buffer stays the next one, so that nothing is lost. */
static void check_small_buffer(void) {
  game played = make_game();
  bytes message;
  uint64_t size = 0;
  unsigned sequence = 0;
  swp_link_action action = 99;
  go_online(&played);
  run_frames(&played, 1);
  CHECK(swp_link_next_message(played.link, played.now_ns, NULL, 0, &size, &action) ==
        SWP_RESOURCE_EXHAUSTED);
  CHECK(strstr(swp_last_error(), "too small for the message") == NULL); /* not an error for NULL */
  CHECK(size > 10 && size < 100 && action == SWP_LINK_SEND);
  CHECK(swp_link_next_message(played.link, played.now_ns, message.data, size - 1, &message.size,
                              &action) == SWP_RESOURCE_EXHAUSTED);
  CHECK(strstr(swp_last_error(), "too small for the message") != NULL);
  CHECK(stats_of(&played).sent_sequence == 0);
  CHECK_OK(swp_link_next_message(played.link, played.now_ns, message.data, size, &message.size,
                                 &action));
  CHECK(action == SWP_LINK_SEND && message.size == size);
  CHECK(next_kind(&played, &sequence) == 0);
  end_game(&played);
}

/* A welcome message replaces the session's own bail-out limit while the link exists. */
static void check_limit(void) {
  game played = make_game();
  swp_frame_sample sample;
  go_online(&played);
  CHECK_OK(swp_session_begin_frame(played.session));
  CHECK_OK(swp_session_end_frame(played.session, 4500 * (uint64_t)kMs, 0));
  CHECK_OK(swp_session_last_sample(played.session, &sample));
  CHECK((sample.flags & SWP_FRAME_BAIL_OUT) != 0);
  swp_link_destroy(played.link);
  CHECK_OK(swp_session_begin_frame(played.session));
  CHECK_OK(swp_session_end_frame(played.session, 4500 * (uint64_t)kMs, 0));
  CHECK_OK(swp_session_last_sample(played.session, &sample));
  CHECK((sample.flags & SWP_FRAME_BAIL_OUT) == 0);
  swp_session_destroy(played.session);
}

/* The host reports that there is no stream, without an error message. */
static void check_no_stream(void) {
  game played = make_game();
  uint32_t delay_ms = 0;
  CHECK_OK(swp_link_disconnected(played.link, 14, NULL, NULL, 0, played.now_ns, &delay_ms));
  CHECK(delay_ms >= 5000 && delay_ms != SWP_LINK_NEVER);
  CHECK(has_text(&played, SWP_LINK_LAST_ERROR, "no stream to the daemon at host:1; trying again"));
  end_game(&played);
}

static void check_lost_connection(void) {
  const bytes broken = {.data = {0x0a, 0xff}, .size = 2};
  game played = make_game();
  bytes message;
  unsigned sequence = 0;
  CHECK(receive(&played, broken) == SWP_FAILED_PRECONDITION);
  go_online(&played);
  CHECK(swp_link_connected(played.link, played.now_ns) == SWP_FAILED_PRECONDITION);
  run_frames(&played, 3);
  for (unsigned i = 1; i <= 3; ++i) CHECK(next_kind(&played, &sequence) == kFrameBatch);
  CHECK(receive(&played, broken) == SWP_DATA_LOSS);
  CHECK(next(&played, &message) == SWP_LINK_CANCEL && message.size == 0);
  CHECK(disconnect(&played, 1, "") <= 100);
  CHECK(has_text(&played, SWP_LINK_LAST_ERROR, "the daemon at host:1 sent a message that cannot"));
  CHECK_OK(swp_link_connected(played.link, played.now_ns));
  CHECK(next_kind(&played, &sequence) == kHello);
  CHECK_OK(receive(&played, welcome("a", 1, 1)));
  for (unsigned i = 2; i <= 3; ++i) {
    CHECK(next_kind(&played, &sequence) == kFrameBatch && sequence == i);
  }
  CHECK(stats_of(&played).resumed_count == 1 && stats_of(&played).resent_message_count == 2);
  CHECK(disconnect(&played, 7, "SESSION_KICKED") == SWP_LINK_NEVER);
  CHECK(has_text(&played, SWP_LINK_LAST_ERROR, "why (SESSION_KICKED)"));
  end_game(&played);
}

static void check_goodbye(void) {
  game played = make_game();
  bytes message;
  unsigned sequence = 0;
  go_online(&played);
  run_frames(&played, 1);
  CHECK_OK(swp_link_goodbye(played.link, played.now_ns + 500 * (uint64_t)kMs));
  CHECK(next_kind(&played, &sequence) == kFrameBatch && sequence == 1);
  CHECK(next_kind(&played, &sequence) == kGoodbye);
  CHECK(next(&played, &message) == SWP_LINK_FINISH && message.size == 0);
  CHECK(next(&played, &message) == SWP_LINK_NONE);
  CHECK(disconnect(&played, 0, "") == SWP_LINK_NEVER);
  CHECK(stats_of(&played).state == SWP_LINK_CLOSED);
  CHECK(has_text(&played, SWP_LINK_LAST_ERROR, ""));
  end_game(&played);
}

/* After the deadline of the goodbye the action is SWP_LINK_CANCEL until the stream has ended. */
static void check_goodbye_deadline(void) {
  game played = make_game();
  bytes message;
  go_online(&played);
  CHECK_OK(swp_link_goodbye(played.link, played.now_ns));
  for (int i = 0; i < 3; ++i) {
    CHECK(next(&played, &message) == SWP_LINK_CANCEL && message.size == 0);
    CHECK(stats_of(&played).state == SWP_LINK_CLOSED);
    CHECK(swp_link_connected(played.link, played.now_ns) == SWP_FAILED_PRECONDITION);
  }
  CHECK(disconnect(&played, 1, "") == SWP_LINK_NEVER);
  CHECK(next(&played, &message) == SWP_LINK_NONE);
  CHECK(swp_link_connected(played.link, played.now_ns) == SWP_FAILED_PRECONDITION);
  end_game(&played);
}

/* An error of the link does not replace the last error of its session, which the frame thread
 * reads. */
static void check_errors(void) {
  game played = make_game();
  char text[256];
  uint64_t size = 0;
  CHECK(swp_session_end_frame(played.session, 0, 0) == SWP_FAILED_PRECONDITION);
  REFUSED(swp_link_copy_text(played.link, 99, NULL, 0, &size));
  CHECK_OK(swp_last_error_of(played.session, text, sizeof text));
  CHECK(strstr(text, "swp_session_begin_frame") != NULL);
  CHECK_OK(swp_last_error_of(played.link, text, sizeof text));
  CHECK(strstr(text, "`which` must be") != NULL);
  end_game(&played);
}

/* NULL is refused if a pointer is required, and changes nothing. */
static void check_null(void) {
  game played = make_game();
  swp_link_stats stats = {.struct_size = sizeof stats};
  swp_link_action action = 99;
  uint64_t size = 99;
  uint32_t number = 99;
  REFUSED(swp_link_options_init(NULL));
  REFUSED(swp_link_create(NULL, NULL, &played.link));
  REFUSED(swp_link_create(played.session, NULL, NULL));
  REFUSED(swp_link_connected(NULL, 0));
  REFUSED(swp_link_next_message(NULL, 0, NULL, 0, &size, &action));
  REFUSED(swp_link_next_message(played.link, 0, NULL, 0, NULL, &action));
  REFUSED(swp_link_next_message(played.link, 0, NULL, 0, &size, NULL));
  REFUSED(swp_link_next_message(played.link, 0, NULL, 1, &size, &action));
  REFUSED(swp_link_on_message(played.link, NULL, 1, 0));
  REFUSED(swp_link_disconnected(played.link, 0, NULL, NULL, 0, 0, NULL));
  REFUSED(swp_link_disconnected(played.link, 0, NULL, NULL, 1, 0, &number));
  REFUSED(swp_link_goodbye(NULL, 0));
  REFUSED(swp_link_status(NULL, &stats));
  REFUSED(swp_link_status(played.link, NULL));
  REFUSED(swp_link_copy_text(played.link, 0, NULL, 0, NULL));
  REFUSED(swp_link_copy_text(played.link, 0, NULL, 1, &size));
  REFUSED(swp_link_copy_text(played.link, 5, NULL, 0, &size));
  REFUSED(swp_link_beliefs(played.link, NULL, 0, NULL));
  REFUSED(swp_link_beliefs(played.link, NULL, 1, &number));
  CHECK(size == 99 && number == 99 && action == 99);
  swp_link_destroy(NULL);
  end_game(&played);
}

/* A host's finalizers run in any order, so the session may end before its link. */
static void check_session_ends_first(void) {
  game played = make_game();
  bytes message;
  swp_link_action action = 99;
  go_online(&played);
  swp_session_destroy(played.session);
  CHECK(swp_link_next_message(played.link, played.now_ns, message.data, sizeof message.data,
                              &message.size, &action) == SWP_FAILED_PRECONDITION);
  CHECK(strstr(swp_last_error(), "session of this link has ended") != NULL);
  CHECK(receive(&played, switch_command(7, 1)) == SWP_FAILED_PRECONDITION);
  CHECK(action == 99);
  swp_link_destroy(played.link);
}

/* If the host shuts all objects down, the link ends with its session, and its calls fail
 * afterwards. */
static void check_shutdown(void) {
  game played = make_game();
  go_online(&played);
  CHECK_OK(swp_shutdown_all(60000));
  CHECK(swp_live_count(SWP_KIND_ANY) == 0);
  CHECK(swp_link_goodbye(played.link, 0) == SWP_FAILED_PRECONDITION);
  swp_session_destroy(played.session);
  swp_link_destroy(played.link);
}

void test_link(void) {
  check_options();
  check_rules();
  check_null();
  check_errors();
  check_session();
  check_small_buffer();
  check_limit();
  check_no_stream();
  check_lost_connection();
  check_goodbye();
  check_goodbye_deadline();
  check_session_ends_first();
  check_shutdown();
}
