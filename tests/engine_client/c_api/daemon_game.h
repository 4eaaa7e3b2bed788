/* A game in C11 that plays against a daemon with swp_session_connect. */
#ifndef SWEEPSTAKE_TESTS_C_API_DAEMON_GAME_H_
#define SWEEPSTAKE_TESTS_C_API_DAEMON_GAME_H_

#include "sweepstake/c_daemon.h"

#ifdef __cplusplus
extern "C" {
#endif

typedef struct daemon_game {  // NOLINT(modernize-use-using): C has none.
  swp_session* session;
  swp_daemon* daemon;
  uint64_t frame_count;
} daemon_game;

/* Starts a game with three arms, of which the first is slow, and short intervals. `options` has the
 * address, TLS and token. Returns the result of swp_session_connect; the game must be ended in any
 * case. */
swp_result daemon_game_start(daemon_game* game, const swp_daemon_options* options);
/* Runs one frame of 16 ms. Ends the program if a call fails. */
void daemon_game_frame(daemon_game* game);
/* Returns the statistics of the link. Ends the program if the call fails. */
swp_link_stats daemon_game_stats(const daemon_game* game);
/* Returns a text of the link, which is valid until the next call on any thread. */
const char* daemon_game_text(const daemon_game* game, swp_link_text which);
/* Ends connection and session. */
void daemon_game_end(daemon_game* game, uint32_t deadline_ms);

#ifdef __cplusplus
}
#endif

#endif
