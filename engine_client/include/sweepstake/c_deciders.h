/* The part of the C ABI for the embedded decider: "AI Decides" without a daemon. c_api.h includes
 * this header and has the rules for threads, ownership, units and results. The functions mirror
 * sweepstake/embedded_decider.h. Beside the frame thread:
 *
 *   swp_session_attach_decider(session, NULL, now_ns);
 *   ... every 250 ms: swp_session_poll_decider(session, now_ns, NULL, NULL);
 *
 * Threads: these functions have one caller at a time, which may be the frame thread. Attach and
 * detach while no frame runs. Cost: a poll is linear in the frames since the last one, and takes
 * longer if a decision is due. It allocates, so a game with tight frame times polls on another
 * thread. */
/* Included before the guard, so that c_api.h includes its headers in the order of their
 * dependencies. */
#include "sweepstake/c_api.h"

#ifndef SWEEPSTAKE_C_DECIDERS_H_
#define SWEEPSTAKE_C_DECIDERS_H_

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

/* Weights of the four scores in the paper's reward. Each is >= 0; their sum is 1. Only policy
 * "paper" uses them. Other weights than the default have a reward version of their own: their
 * evidence is never merged with that of the default. */
typedef struct swp_reward_weights {
  double fps;       /* default: 0.55 */
  double detection; /* default: 0.25 */
  double memory;    /* default: 0.12 */
  double checks;    /* default: 0.08 */
} swp_reward_weights;

typedef struct swp_decider_options {
  uint32_t struct_size;
  uint32_t reserved;         /* 0 */
  const char* policy;        /* NULL: the default */
  const char* project;       /* NULL: "default" */
  const char* scene;         /* NULL: "default" */
  const char* machine_class; /* NULL: detected from processor, threads and memory */
  const char* build; /* the game's build; priors of other builds count less. NULL: unknown */
  /* The name under which swp_session_export_priors exports what is learnt. A game that keeps a name
   * per installation has records that grow from run to run. An installation that loses its save
   * needs a new name: the sequence numbers of its records begin at 1 again, and a store that has
   * higher numbers ignores these records. NULL: a new name each time. A save that is loaded and
   * exported again then grows by the records of each run; above 200,000 records it is refused. */
  const char* source_id;
  /* Priors to start from, as `sweepstake priors export` and swp_session_export_priors write them: a
   * file, its content, or both, which are then merged. NULL: Beta(1,1). */
  const char* priors_file;
  const char* priors_data;    /* read during the call only; it needs no NUL at its end */
  uint64_t priors_data_bytes; /* 0 if priors_data is NULL */
  uint64_t seed;
  double time_scale;             /* 1 to 1000: divides every interval except the bail-out limit */
  uint64_t decision_interval_ns; /* time between decisions, 1 ns to 100 days; default: 2 s; AI
                                    Decides decides at least every second */
  uint64_t cooldown_ns; /* minimum time between switches that the policy chooses, at most 100
                           days; default: 40 s; AI Decides waits only for the settling time plus
                           one interval */
  double fps_floor; /* frame-rate floor in frames/s, 0 to 1000; a scene that misses it because of
                       the broad phase is SWP_VERDICT_DEGRADED; default: 30 */
  swp_reward_weights weights;
} swp_decider_options;

/* A posterior of an arm's reward, Beta(alpha, beta). */
typedef struct swp_belief {
  double alpha;
  double beta;
} swp_belief;

/* Sets the defaults of swp_decider_options, seed 1 and time scale 1. */
SWP_API swp_result swp_decider_options_init(swp_decider_options* options);

/* `now_ns` is a time of the caller's steady clock: the same clock in all calls, which never goes
 * back. Its zero point does not matter. */

/* Attaches an embedded decider. `options` NULL uses the defaults. SWP_FAILED_PRECONDITION if a
 * decider is already attached, SWP_NOT_FOUND if the file does not exist, SWP_DATA_LOSS if the
 * priors are broken; the message names the first broken record. */
SWP_API swp_result swp_session_attach_decider(swp_session* session,
                                              const swp_decider_options* options, uint64_t now_ns);
/* Ends the decider and discards what it has learnt. After that the session handles bail-outs
 * itself, and the time scale does not divide its settling time any more. */
SWP_API swp_result swp_session_detach_decider(swp_session* session);
/* Chooses the arm that the priors of `options` expect to cost least, from the next begin_frame
 * on. With NULL the session keeps its arm. Sets SWP_MODE_MANUAL and disables everything that
 * depends on time, so that runs repeat bit for bit (builds, replays, tournaments): the clock is
 * not read, samples have no detection time, the lane gets no frames, and commands and orders are
 * refused. swp_session_select_arm still works. swp_session_set_mode ends this state.
 * SWP_NOT_FOUND if the priors have no evidence of the project with the session's arms; the
 * session is unchanged then. Frame thread. */
SWP_API swp_result swp_session_freeze(swp_session* session, const swp_decider_options* options);
/* Passes the frames since the last poll to the decider, makes a decision if one is due
 * (decision_interval_ns), and posts its command, if any, to the frame thread. Sets `commanded`
 * to 1 if a command was posted, and writes the command to `command`; both may be NULL. Poll
 * every 250 ms or more often. */
SWP_API swp_result swp_session_poll_decider(swp_session* session, uint64_t now_ns,
                                            swp_switch_command* command, uint32_t* commanded);
/* Writes the posteriors in the order of arms; `count` is the number of arms. If `capacity` is
 * too small, the result is SWP_RESOURCE_EXHAUSTED and only `count` is written. */
SWP_API swp_result swp_session_beliefs(const swp_session* session, swp_belief* beliefs,
                                       uint32_t capacity, uint32_t* count);
/* The number of decisions since the decider was attached. */
SWP_API swp_result swp_session_decision_count(const swp_session* session, uint64_t* count);
/* The number of sources in the decider's priors; 0: it started from Beta(1,1). */
SWP_API swp_result swp_session_prior_source_count(const swp_session* session, uint64_t* count);
/* Writes the content of a priors file: all records that the decider started from, and what it
 * has learnt since. Use it as the next run's priors_data, or with `sweepstake priors import`.
 * Both count each piece of evidence only once, however often it is exported. `bytes` is the
 * length without a NUL. If `capacity` is too small, the result is SWP_RESOURCE_EXHAUSTED and
 * only `bytes` is written. Call it before the decider is detached, because detaching discards
 * the evidence. */
SWP_API swp_result swp_session_export_priors(const swp_session* session, char* data,
                                             uint64_t capacity, uint64_t* bytes);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_DECIDERS_H_ */
