/* Tests the arguments of swp_session_connect. No daemon runs. */
#include <string.h>

#include "sweepstake/c_daemon.h"
#include "tests/engine_client/c_api/check.h"

static swp_session* session;

/* Checks that the call is refused with a message that contains `text`, and attaches no link. */
static void refuse(const swp_daemon_options* options, const char* text) {
  swp_daemon* daemon = NULL;
  REFUSED(swp_session_connect(session, options, &daemon));
  CHECK(strstr(swp_last_error(), text) != NULL);
  CHECK(daemon == NULL);
  CHECK(swp_live_count(SWP_KIND_LINK) == 0);
}

static swp_daemon_options with_address(const char* address) {
  swp_daemon_options options = {.struct_size = sizeof options, .address = address};
  return options;
}

static void check_null(void) {
  const swp_daemon_options options = with_address("127.0.0.1:1");
  swp_daemon* daemon = NULL;
  REFUSED(swp_session_connect(session, NULL, &daemon));
  REFUSED(swp_session_connect(session, &options, NULL));
  REFUSED(swp_session_connect(NULL, &options, &daemon));
  CHECK(swp_daemon_link(NULL) == NULL);
  swp_daemon_destroy(NULL, 0);
}

static void check_addresses(void) {
  swp_daemon_options options = with_address(NULL);
  refuse(&options, "HOST:PORT");
  options = with_address("127.0.0.1");
  refuse(&options, "HOST:PORT");
}

static void check_tls(void) {
  swp_daemon_options options = with_address("127.0.0.1:1");
  options.tls = 2;
  refuse(&options, "tls must be 0 or 1");
  options.tls = 0;
  options.ca_file = "ca.pem";
  refuse(&options, "set tls to 1");
  options.tls = 1;
  options.ca_file = "/nowhere/ca.pem";
  refuse(&options, "/nowhere/ca.pem");
  options.ca_file = NULL;
  options.cert_file = "cert.pem";
  refuse(&options, "key_file");
}

static void check_tokens(void) {
  swp_daemon_options options = with_address("127.0.0.1:1");
  options.token_file = "/nowhere/token";
  refuse(&options, "cannot read a token from /nowhere/token");
  options.token = "secret";
  refuse(&options, "not both");
  options.token_file = NULL;
  options.address = "192.0.2.1:7433";
  refuse(&options, "in plain text");
  CHECK(strstr(swp_last_error(), "secret") == NULL);
}

static void check_link_options(void) {
  swp_link_options link = {.struct_size = sizeof link};
  swp_daemon_options options = with_address("127.0.0.1:1");
  CHECK_OK(swp_link_options_init(&link));
  options.link = &link;
  link.batch_frames = 0;
  refuse(&options, "batch_frames");
  link.struct_size = 5;
  refuse(&options, "struct_size of swp_link_options");
}

static void check_only_one_link(void) {
  const swp_daemon_options options = with_address("127.0.0.1:1");
  swp_daemon* daemon = NULL;
  swp_daemon* second = NULL;
  CHECK_OK(swp_session_connect(session, &options, &daemon));
  CHECK(swp_session_connect(session, &options, &second) == SWP_FAILED_PRECONDITION);
  CHECK(swp_session_attach_decider(session, NULL, 0) == SWP_FAILED_PRECONDITION);
  swp_daemon_destroy(daemon, 0);
  CHECK_OK(swp_session_attach_decider(session, NULL, 0));
  CHECK_OK(swp_session_detach_decider(session));
}

static swp_result set_address(void* options) {
  ((swp_daemon_options*)options)->address = "127.0.0.1:1";
  return SWP_OK;
}

static swp_result take_options(void* options) {
  swp_daemon* daemon = NULL;
  const swp_result result = swp_session_connect(session, options, &daemon);
  swp_daemon_destroy(daemon, 0);
  return result;
}

static const options_struct kOptions = {sizeof(swp_daemon_options), set_address, take_options};

void test_daemon(void) {
  CHECK(swp_struct_size(SWP_STRUCT_DAEMON_OPTIONS) == sizeof(swp_daemon_options));
  CHECK_OK(swp_session_create(NULL, &session));
  check_null();
  check_addresses();
  check_tls();
  check_tokens();
  check_link_options();
  check_only_one_link();
  check_taken(&kOptions);
  swp_session_destroy(session);
}
