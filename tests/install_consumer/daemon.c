/* A C program that connects to a daemon that does not exist, plays on, and ends the connection. */
#include <stdio.h>

#include "sweepstake/c_daemon.h"

int main(void) {
  const swp_aabb boxes[2] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {2, 2, 2}}};
  swp_daemon_options options = {.struct_size = sizeof options, .address = "127.0.0.1:1"};
  swp_link_stats stats = {.struct_size = sizeof stats};
  swp_session* session = NULL;
  swp_daemon* daemon = NULL;
  if (swp_abi_version() != SWP_ABI_VERSION || swp_session_create(NULL, &session) != SWP_OK ||
      swp_session_connect(session, &options, &daemon) != SWP_OK ||
      swp_session_begin_frame(session) != SWP_OK ||
      swp_session_find_pairs(session, boxes, 2) != SWP_OK ||
      swp_session_end_frame(session, 16666667, 0) != SWP_OK ||
      swp_link_status(swp_daemon_link(daemon), &stats) != SWP_OK) {
    fprintf(stderr, "%s\n", swp_last_error());
    return 1;
  }
  swp_daemon_destroy(daemon, 500);
  swp_session_destroy(session);
  return stats.connection_count == 0 && stats.state != SWP_LINK_ONLINE ? 0 : 1;
}
