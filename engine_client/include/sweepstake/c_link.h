/* The part of the C ABI for a session with a daemon over the caller's own transport. c_api.h
 * includes this header and has the rules for ownership, units and results.
 *
 * A link implements the whole protocol of a session, without network, clock or thread. The caller
 * opens the gRPC stream sweepstake.v1.TelemetryService/StreamTelemetry (or another transport of its
 * messages) and moves bytes. The link does the rest: batches, numbering, resending, back-off,
 * resuming, orders of operators, and commands to the frame path:
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
 * c_daemon.h has such a caller: a thread with gRPC.
 *
 * Threads: any thread may call any function except create and destroy at any time, even beside the
 * frame thread's calls of the session. The calls share one lock. Of the frame thread's calls, only
 * swp_session_destroy takes it.
 * Times are of a steady clock of the caller that never goes back: the same clock in all calls, from
 * any origin. */
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

/* An interval in swp_link_options that the daemon's configuration determines. */
#define SWP_DAEMON_VALUE 0xffffffffffffffffU

/* The same options as SessionOptions in session.h. The texts are names of at most 128 bytes. */
typedef struct swp_link_options {
  uint32_t struct_size;
  uint32_t allow_operator_orders; /* 1: operators may choose mode and arm; 0 in shipped games */
  const char* daemon;         /* name of the daemon in messages, such as its address; NULL or "":
                                 none */
  const char* project;        /* NULL: "default" */
  const char* scene;          /* NULL: "default" */
  const char* build;          /* NULL: unknown */
  const char* machine_class;  /* NULL: detected from processor, threads and memory */
  const char* policy;         /* NULL: the daemon's default */
  uint64_t seed;              /* of the exploration and the draws; 0: the daemon chooses */
  double time_scale;          /* 1 to 1000: divides the decider's intervals; a daemon refuses values
                                 above 1 unless it is configured to allow them */
  uint64_t jitter_seed;       /* seed of the delays between attempts; 0: a new one for each link */
  uint32_t ignore_priors;     /* 1: starts from Beta(1,1) whatever the store holds */
  uint32_t batch_interval_ms; /* a batch is sent at the first of these three limits: 1 to 10,000 */
  uint32_t batch_frames;      /* 1 to 240 */
  uint32_t batch_bytes;       /* 512 to 262,144 */
  uint32_t unacknowledged_messages; /* 1 to 4,096; at this bound sending pauses, and the session's
                                       queue drops its oldest samples */
  uint32_t backoff_min_ms; /* 1 to 3,600,000; doubles with each broken stream, with full jitter */
  uint32_t backoff_max_ms; /* 1 to 3,600,000. After a refusal, or if no
                              stream can be opened, the delay is around the maximum. After a refused
                              token it is about six times the maximum. A daemon that drains sets the
                              delay: at most four times the maximum, plus jitter */
  uint32_t reserved;       /* 0 */
  /* Rules for this session instead of those of the daemon's configuration: SWP_DAEMON_VALUE, the
   * default, keeps the daemon's. The daemon refuses values out of range. */
  uint64_t decision_interval_ns; /* time between decisions, 250 ms to 100 days */
  uint64_t cooldown_ns;          /* as in swp_decider_options */
  uint64_t settling_ns;       /* as in swp_session_options; the welcome sets the session's value */
  swp_reward_weights weights; /* all 0, the default, keeps the daemon's */
} swp_link_options;

/* The action that the caller must perform on its stream. */
typedef uint32_t swp_link_action;
enum {
  SWP_LINK_NONE = 0,   /* there is nothing to do now */
  SWP_LINK_SEND = 1,   /* write the message */
  SWP_LINK_FINISH = 2, /* there are no more messages: end writing, and read until the end */
  SWP_LINK_CANCEL = 3  /* end the stream at once; repeated until swp_link_disconnected */
};

typedef uint32_t swp_link_state;
enum {
  SWP_LINK_OFFLINE = 0,
  SWP_LINK_CONNECTING = 1, /* from swp_link_connected to the daemon's welcome */
  SWP_LINK_ONLINE = 2,
  SWP_LINK_CLOSED = 4 /* after swp_link_goodbye: nothing is left to do, except to end a stream while
                         the action is SWP_LINK_CANCEL */
};

/* The statistics of a link since it was created. */
typedef struct swp_link_stats {
  uint32_t struct_size;
  swp_link_state state;
  uint64_t sent_frame_count;
  uint64_t discarded_frame_count; /* frames that the daemon refused */
  uint64_t sent_sequence;
  uint64_t acknowledged_sequence; /* messages up to this one are on the daemon's disk */
  uint64_t connection_count;      /* welcome messages received */
  uint64_t resumed_count;
  uint64_t resent_message_count;
  uint64_t command_count;          /* switches that the daemon commanded */
  uint64_t unknown_message_count;  /* messages of a newer protocol, ignored */
  uint64_t prior_source_count;     /* sources in the priors that the session started from */
  uint64_t seed;                   /* seed of the exploration and the draws of policy "paper" */
  uint32_t priors_unavailable;     /* 1: the daemon could not read all of its priors */
  uint32_t awaits_acknowledgement; /* 1: sending pauses until the daemon acknowledges */
} swp_link_stats;

/* Selects a text of a link. */
typedef uint32_t swp_link_text;
enum {
  SWP_LINK_LAST_ERROR = 0, /* the latest error and its remedy; "": none */
  SWP_LINK_REFUSAL = 1, /* why the daemon refused the token, the names or the protocol of the latest
                           attempt; "": it did not (LAST_ERROR has other failures) */
  SWP_LINK_SESSION_ID = 2,     /* "" before the first welcome, like the next two */
  SWP_LINK_DAEMON_VERSION = 3, /* version of the daemon's program */
  SWP_LINK_POLICY = 4          /* name of the policy that decides */
};

/* Value of delay_ms: no further stream may be opened. */
#define SWP_LINK_NEVER 0xffffffffU

/* Sets the defaults of swp_link_options. */
SWP_API swp_result swp_link_options_init(swp_link_options* options);

/* Attaches a link to the session. From now on the link sends the session's samples. `options`
 * NULL uses the defaults. SWP_FAILED_PRECONDITION if a decider or another link is attached.
 * After the session is destroyed or shut down, every function of the link except destroy returns
 * SWP_FAILED_PRECONDITION. */
SWP_API swp_result swp_link_create(swp_session* session, const swp_link_options* options,
                                   swp_link** link);
/* Destroys the link. Call swp_link_goodbye before; without it the daemon keeps the session,
 * which no other process may resume. No other thread may be in a call of the link. */
SWP_API void swp_link_destroy(swp_link* link);

/* Reports that a stream was opened, or is being opened. SWP_FAILED_PRECONDITION if the previous
 * stream was not reported as disconnected, or the state is SWP_LINK_CLOSED. */
SWP_API swp_result swp_link_connected(swp_link* link, uint64_t now_ns);
/* Reads the session's samples and returns the caller's next action. With SWP_LINK_SEND the next
 * message is in `buffer` and counts as sent; with any other action `size` is 0. SWP_LINK_FINISH is
 * returned once. Every few milliseconds, with and without a stream, call it until the action is not
 * SWP_LINK_SEND.
 *
 * If `capacity` is too small for the message, the result is SWP_RESOURCE_EXHAUSTED, `size` is the
 * size that it needs, and the message stays the next one. `action` is written too, and no last
 * error is set. A caller with a write in progress therefore passes NULL and 0. A capacity of
 * batch_bytes or 8 KiB, whichever is more, is enough for nearly all messages. */
SWP_API swp_result swp_link_next_message(swp_link* link, uint64_t now_ns, void* buffer,
                                         uint64_t capacity, uint64_t* size,
                                         swp_link_action* action);
/* Processes a message of the daemon; any bytes are safe. SWP_DATA_LOSS if they are not a valid
 * message. The session then loses nothing: the next action is SWP_LINK_CANCEL, and everything
 * unacknowledged is sent again on the next stream. SWP_FAILED_PRECONDITION without a stream. */
SWP_API swp_result swp_link_on_message(swp_link* link, const void* bytes, uint64_t size,
                                       uint64_t now_ns);
/* Reports that the stream has ended, after its last message was passed to swp_link_on_message.
 * `message` and the code come from gRPC's status. `details` are the bytes of the trailer
 * grpc-status-details-bin, decoded from base64. `message` and `details` may be NULL. If the details
 * have the daemon's own code and message, those count: a proxy may reset the stream. The first 256
 * bytes of the message are kept, and shown as one line of UTF-8. `delay_ms` is the time to wait
 * before the next stream, or SWP_LINK_NEVER. Without a previous swp_link_connected, the call
 * reports that no stream could be opened. */
SWP_API swp_result swp_link_disconnected(swp_link* link, uint32_t grpc_status_code,
                                         const char* message, const void* details,
                                         uint64_t details_size, uint64_t now_ns,
                                         uint32_t* delay_ms);
/* Starts to end the session: the remaining evidence is sent, then a goodbye, and the state becomes
 * SWP_LINK_CLOSED. At the deadline at the latest, SWP_LINK_CANCEL ends the stream. No further
 * stream follows. If no stream is open, or it breaks before the end, the state becomes
 * SWP_LINK_CLOSED at once and unsent evidence is dropped. To keep the evidence, an offline caller
 * waits for its next stream before it calls this function. A later call can only bring the deadline
 * forward. */
SWP_API swp_result swp_link_goodbye(swp_link* link, uint64_t deadline_ns);

/* Writes the statistics. Set stats->struct_size before. */
SWP_API swp_result swp_link_status(swp_link* link, swp_link_stats* stats);
/* Writes a text with its NUL; `size` is its length without it. If `capacity` is too small, the
 * result is SWP_RESOURCE_EXHAUSTED and only `size` is written. */
SWP_API swp_result swp_link_copy_text(swp_link* link, swp_link_text which, char* text,
                                      uint64_t capacity, uint64_t* size);
/* Writes the daemon's latest posteriors in the order of arms. `count` is their number; it is 0
 * before the first posteriors arrive. If `capacity` is too small, the result is
 * SWP_RESOURCE_EXHAUSTED and only `count` is written. For the verdict use swp_session_verdict. */
SWP_API swp_result swp_link_beliefs(swp_link* link, swp_belief* beliefs, uint32_t capacity,
                                    uint32_t* count);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_LINK_H_ */
