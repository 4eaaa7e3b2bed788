/* The part of the C ABI that connects a session to a daemon over gRPC. It is the only part that the
 * library `sweepstake` does not contain. The library `sweepstake_grpc` contains it, and needs gRPC
 * and the shared library `sweepstake`. c_api.h does not include this header, and has the rules for
 * ownership, units and results.
 *
 *   swp_daemon_options options = {.struct_size = sizeof options, .address = "127.0.0.1:7433"};
 *   swp_daemon* daemon = NULL;
 *   swp_session_connect(session, &options, &daemon);
 *   ...                                             // the game's frames, as with a decider
 *   swp_daemon_destroy(daemon, 500);                // before swp_session_destroy
 *
 * A thread of the library moves the bytes of a link (c_link.h) to and from the daemon. The frame
 * thread never waits for it. The daemon may be absent, slow, killed or restarted: the thread
 * connects again with the link's back-off, and resumes the session. Hooks (c_hooks.h) do not cover
 * the thread and the memory of this library. */
#ifndef SWEEPSTAKE_C_DAEMON_H_
#define SWEEPSTAKE_C_DAEMON_H_

#include <stdint.h>

#include "sweepstake/c_api.h"
#include "sweepstake/c_link.h"
#include "sweepstake/c_sessions.h"

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

typedef struct swp_daemon swp_daemon;

/* Needs no _init function: every member except struct_size and address may be 0 or NULL. The files
 * are those of TlsOptions and ClientToken in session.h. They are read for every connection, so they
 * may be replaced while the game runs. */
typedef struct swp_daemon_options {
  uint32_t struct_size;
  uint32_t tls;                 /* 1: TLS 1.2 or newer; 0: plain text, without the next four */
  const char* ca_file;          /* authorities of the daemon's certificate; NULL: the system's */
  const char* cert_file;        /* the client's certificate, if the daemon requires one */
  const char* key_file;         /* its private key; with cert_file only */
  const char* server_name;      /* host in the daemon's certificate; NULL: that of the address */
  const char* address;          /* HOST:PORT */
  const char* token;            /* the token; NULL: none. Sent only with TLS or to this machine */
  const char* token_file;       /* a file with only the token, instead of `token`; NULL: none */
  const swp_link_options* link; /* names, seed, batches and back-off; NULL: the defaults. Its member
                                   `daemon` may be NULL: messages then use the address */
} swp_daemon_options;

/* Attaches a link to the session and connects it to the daemon in the background. The texts are
 * copied. SWP_INVALID_ARGUMENT: the address, an option, a file of TLS or the token cannot be used,
 * or the token would cross a network in plain text. SWP_FAILED_PRECONDITION: a decider or a link is
 * attached. SWP_RESOURCE_EXHAUSTED: the system cannot create a thread. The call does not wait for
 * the daemon. If the daemon cannot be reached or refuses the token, SWP_LINK_LAST_ERROR and
 * SWP_LINK_REFUSAL have the reason, and the thread tries again. */
SWP_API swp_result swp_session_connect(swp_session* session, const swp_daemon_options* options,
                                       swp_daemon** daemon);
/* The link, for swp_link_status, swp_link_copy_text and swp_link_beliefs on any thread. It belongs
 * to the connection: do not destroy it, and do not pass it to functions that move bytes. NULL for
 * NULL. */
SWP_API swp_link* swp_daemon_link(const swp_daemon* daemon);
/* Sends the session's samples and a goodbye, waits at most deadline_ms for the daemon's answer,
 * then ends the thread and destroys the link. An offline link sends nothing and ends at once. If
 * the session was destroyed before, or swp_shutdown_all has ended the link, nothing is sent and the
 * daemon keeps the session. In a forked child process the function does nothing. */
SWP_API void swp_daemon_destroy(swp_daemon* daemon, uint32_t deadline_ms);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_DAEMON_H_ */
