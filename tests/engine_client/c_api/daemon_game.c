#include "tests/engine_client/c_api/daemon_game.h"

#include <stdio.h>
#include <stdlib.h>
#include <string.h>

enum { BOXES = 500 };

static void require(swp_result result) {
  if (result == SWP_OK) return;
  fprintf(stderr, "%s\n", swp_last_error());
  abort();
}

swp_result daemon_game_start(daemon_game* game, const swp_daemon_options* options) {
  swp_session_options session = {.struct_size = sizeof session};
  swp_link_options link = {.struct_size = sizeof link};
  swp_daemon_options daemon = *options;
  memset(game, 0, sizeof *game);
  require(swp_session_options_init(&session));
  session.shadow = SWP_SHADOW_OFF; /* so that the evidence depends on the frames alone */
  session.arms = "BruteForce,Grid,SAP";
  session.initial_arm = "BruteForce"; /* slow, so that the daemon soon commands a switch */
  require(swp_session_create(&session, &game->session));
  require(swp_link_options_init(&link));
  link.scene = "c daemon";
  link.policy = "paper"; /* with this policy each window is one observation */
  link.seed = 7;
  link.time_scale = 200;
  link.batch_frames = 10;
  link.backoff_min_ms = 1;
  link.backoff_max_ms = 20;
  daemon.link = &link;
  return swp_session_connect(game->session, &daemon, &game->daemon);
}

void daemon_game_frame(daemon_game* game) {
  static swp_aabb boxes[BOXES]; /* in a row, no two of which touch */
  for (int k = 0; k < BOXES; ++k) {
    boxes[k] = (swp_aabb){{(float)(2 * k), 0, 0}, {(float)(2 * k + 1), 1, 1}};
  }
  require(swp_session_begin_frame(game->session));
  require(swp_session_find_pairs(game->session, boxes, BOXES));
  require(swp_session_end_frame(game->session, 16000000, 0));
  ++game->frame_count;
}

swp_link_stats daemon_game_stats(const daemon_game* game) {
  swp_link_stats stats = {.struct_size = sizeof stats};
  require(swp_link_status(swp_daemon_link(game->daemon), &stats));
  return stats;
}

const char* daemon_game_text(const daemon_game* game, swp_link_text which) {
  static char text[2048];
  uint64_t size = 0;
  require(swp_link_copy_text(swp_daemon_link(game->daemon), which, text, sizeof text, &size));
  return text;
}

void daemon_game_end(daemon_game* game, uint32_t deadline_ms) {
  swp_daemon_destroy(game->daemon, deadline_ms);
  swp_session_destroy(game->session);
  memset(game, 0, sizeof *game);
}
