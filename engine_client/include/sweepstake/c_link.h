/* The part of the C ABI for a session with a daemon over the caller's own transport; c_api.h
 * includes it and says what holds for all: ownership, units, results.
 *
 * A link is the whole protocol of a session, without network, clock or thread. The caller opens the
 * gRPC stream sweepstake.v1.TelemetryService/StreamTelemetry (or whatever carries its messages) and
 * moves bytes; batches, numbers, sending again, back-off, resuming, orders of operators and the
 * answers to the frame path are done here:
 *
 *   for (;;) {                                       // until the state is SWP_LINK_CLOSED,
 *                                                    // or delay_ms SWP_LINK_NEVER
 *     open a stream; swp_link_connected(link, now());
 *     while (it is open) {                           // every 5 ms, and when a message has come
 *       for each message that has come: swp_link_on_message(link, bytes, size, now());
 *       swp_link_next_message(link, now(), buffer, capacity, &size, &action);
 *       SWP_LINK_SEND: write it   SWP_LINK_FINISH: end writing   SWP_LINK_CANCEL: end the stream
 *     }
 *     swp_link_disconnected(link, code, message, details, details_size, now(), &delay_ms);
 *     wait for delay_ms, calling swp_link_next_message as before
 *   }
 *
 * Threads: any thread may call any function but create and destroy at any time, also beside the
 * frame thread's calls of the session. One lock inside makes them wait for one another; the frame
 * thread never meets it. Times are of the caller's steady clock, the same one in all calls, from
 * any origin and never going back.
 */
#ifndef SWEEPSTAKE_C_LINK_H_
#define SWEEPSTAKE_C_LINK_H_

#include <stdint.h>

#include "sweepstake/c_api.h"
#include "sweepstake/c_deciders.h"
#include "sweepstake/c_sessions.h"

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

typedef struct swp_link swp_link;

/* As SessionOptions in session.h. The texts are names of at most 128 bytes. */
typedef struct swp_link_options {
  uint32_t struct_size;
  uint32_t allow_operator_orders; /* 1: operators may choose mode and arm. Not for players. */
  const char* daemon;             /* what messages call the daemon, as its address; NULL or "":
                                     nothing */
  const char* project;            /* NULL: "default" */
  const char* scene;              /* NULL: "default" */
  const char* build;              /* NULL: unknown */
  const char* machine_class;      /* NULL: detected from processor, threads and memory */
  const char* policy;             /* NULL: the daemon's default */
  uint64_t seed;                  /* 0: the daemon chooses */
  double time_scale;          /* 1 to 1000; above 1 a daemon refuses unless it is set to allow it */
  uint64_t jitter_seed;       /* of the delays between attempts; 0: another one for each link */
  uint32_t ignore_priors;     /* 1: starts from Beta(1,1) whatever the store holds */
  uint32_t batch_interval_ms; /* a batch is sent at the first of these three limits: 1 to 10,000 */
  uint32_t batch_frames;      /* 1 to 240 */
  uint32_t batch_bytes;       /* 512 to 262,144 */
  uint32_t unacknowledged_messages; /* 1 to 4,096; at the bound nothing more is sent, and the
                                       session's queue drops its oldest samples */
  uint32_t backoff_min_ms; /* doubles with each stream that broke up to the maximum, with full */
  uint32_t backoff_max_ms; /* jitter; 1 to 3,600,000. What will not pass soon (a refusal, no stream
                              at all) waits around the maximum, a refused token some six times as
                              long, a daemon that drains what it says, up to four times the maximum
                              and jitter */
  uint32_t reserved;       /* 0 */
} swp_link_options;

/* What the caller is to do with its stream. */
typedef uint32_t swp_link_action;
enum {
  SWP_LINK_NONE = 0,   /* nothing now */
  SWP_LINK_SEND = 1,   /* write the message */
  SWP_LINK_FINISH = 2, /* there are no more messages: end writing, and read until the end */
  SWP_LINK_CANCEL = 3  /* end the stream at once; said again until swp_link_disconnected */
};

typedef uint32_t swp_link_state;
enum {
  SWP_LINK_OFFLINE = 0,
  SWP_LINK_CONNECTING = 1, /* from connected to the daemon's welcome */
  SWP_LINK_ONLINE = 2,
  SWP_LINK_CLOSED = 4 /* after swp_link_goodbye: there is nothing more to do, but to end a stream
                         that SWP_LINK_CANCEL is still said of */
};

/* Since the link was made. */
typedef struct swp_link_stats {
  uint32_t struct_size;
  swp_link_state state;
  uint64_t sent_frame_count;
  uint64_t discarded_frame_count; /* refused by the daemon */
  uint64_t sent_sequence;
  uint64_t acknowledged_sequence; /* messages up to this one are on the daemon's disk */
  uint64_t connection_count;      /* welcomes */
  uint64_t resumed_count;
  uint64_t resent_message_count;
  uint64_t command_count;          /* switches that the daemon commanded */
  uint64_t unknown_message_count;  /* of a newer protocol, passed over */
  uint64_t prior_source_count;     /* sources in the priors it started from */
  uint64_t seed;                   /* of the daemon's draws */
  uint32_t priors_unavailable;     /* 1: the daemon could not read all of its priors */
  uint32_t awaits_acknowledgement; /* 1: nothing is sent before the daemon acknowledges */
} swp_link_stats;

/* A text that a link has. */
typedef uint32_t swp_link_text;
enum {
  SWP_LINK_LAST_ERROR = 0, /* what went wrong most recently and what to do; "": nothing */
  SWP_LINK_REFUSAL = 1, /* why the daemon refused the token, the names or the protocol of the latest
                           attempt; "": it did not (another end is in LAST_ERROR alone) */
  SWP_LINK_SESSION_ID = 2,     /* "" before the first welcome, as the next two */
  SWP_LINK_DAEMON_VERSION = 3, /* of the program */
  SWP_LINK_POLICY = 4          /* that decides */
};

/* In the place of a delay: there must be no other stream. */
#define SWP_LINK_NEVER 0xffffffffU

SWP_API swp_result swp_link_options_init(swp_link_options* options);

/* Attaches a link to the session, whose samples it takes from now on; `options` NULL takes the
 * defaults. SWP_FAILED_PRECONDITION if a decider or another link is attached. Once the session
 * is destroyed or shut down, every call of the link is SWP_FAILED_PRECONDITION, but destroy. */
SWP_API swp_result swp_link_create(swp_session* session, const swp_link_options* options,
                                   swp_link** link);
/* Without swp_link_goodbye before it the daemon keeps the session, and another process may not
 * resume it. No other thread may be in a call of the link. */
SWP_API void swp_link_destroy(swp_link* link);

/* A stream was opened, or is being opened. SWP_FAILED_PRECONDITION if the former one has not been
 * disconnected, or the state is SWP_LINK_CLOSED. */
SWP_API swp_result swp_link_connected(swp_link* link, uint64_t now_ns);
/* Takes the session's samples and says what to do. With SWP_LINK_SEND the next message is in
 * `buffer`, and counts as sent. If `capacity` is too small for it, the result is
 * SWP_RESOURCE_EXHAUSTED, `size` is what it takes, and the message stays the next one; so a caller
 * with a write under way passes NULL and 0, which is no error: `action` is written too, and no last
 * error. batch_bytes or 8 KiB, whichever is more, is enough for nearly all.
 * SWP_LINK_FINISH is said once; with any other action than SWP_LINK_SEND, `size` is 0. Call it
 * every few milliseconds, with and without a stream, until the action is another one than
 * SWP_LINK_SEND.
 */
SWP_API swp_result swp_link_next_message(swp_link* link, uint64_t now_ns, void* buffer,
                                         uint64_t capacity, uint64_t* size,
                                         swp_link_action* action);
/* Acts on a message of the daemon; the bytes may be anything. SWP_DATA_LOSS if they are no message:
 * nothing of the session is lost, the next action is SWP_LINK_CANCEL, and all that was not
 * acknowledged is sent again on the next stream. SWP_FAILED_PRECONDITION without a stream. */
SWP_API swp_result swp_link_on_message(swp_link* link, const void* bytes, uint64_t size,
                                       uint64_t now_ns);
/* The stream has ended, and its last message was passed on: with this code and text of gRPC's
 * status, and the bytes of the trailer grpc-status-details-bin, decoded from base64 (`message` and
 * `details` may be NULL; of the text, the first 256 bytes are kept, and shown as one line of
 * UTF-8). `delay_ms` is how long to wait before the next stream, SWP_LINK_NEVER if there must be
 * none. Without swp_link_connected before it, it says why no stream could be opened at all. */
SWP_API swp_result swp_link_disconnected(swp_link* link, uint32_t grpc_status_code,
                                         const char* message, const void* details,
                                         uint64_t details_size, uint64_t now_ns,
                                         uint32_t* delay_ms);
/* Begins the end: what is left is sent, then a goodbye, and the state becomes SWP_LINK_CLOSED; at
 * the deadline at the latest, with SWP_LINK_CANCEL. There is no further stream: without one, or
 * where it breaks before the end, the state becomes SWP_LINK_CLOSED at once, and what the daemon
 * has not is dropped. So a caller that is offline waits for its next stream before it calls this,
 * if the evidence is worth it. A later call can only bring the deadline forward. */
SWP_API swp_result swp_link_goodbye(swp_link* link, uint64_t deadline_ns);

/* Set stats->struct_size first. */
SWP_API swp_result swp_link_status(swp_link* link, swp_link_stats* stats);
/* Writes a text with its NUL; `size` is its length without it. If `capacity` is too small, the
 * result is SWP_RESOURCE_EXHAUSTED and only `size` is written. */
SWP_API swp_result swp_link_copy_text(swp_link* link, swp_link_text which, char* text,
                                      uint64_t capacity, uint64_t* size);
/* Writes the daemon's latest posteriors in the order of arms; `count` is their number, 0 before the
 * first. If `capacity` is too small, the result is SWP_RESOURCE_EXHAUSTED and only `count` is
 * written. The verdict is swp_session_verdict. */
SWP_API swp_result swp_link_beliefs(swp_link* link, swp_belief* beliefs, uint32_t capacity,
                                    uint32_t* count);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_LINK_H_ */
