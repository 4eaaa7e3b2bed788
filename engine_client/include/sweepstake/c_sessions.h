/* The part of the C ABI for sessions: the frame path, which switches between backends. c_api.h
 * includes this header and has the rules for threads, ownership, units and results. The functions
 * mirror sweepstake/adaptive_broad_phase.h.
 *
 * A frame:
 *
 *   swp_session_begin_frame(session);
 *   swp_session_find_pairs(session, boxes, count);
 *   swp_session_pairs(session, &pairs, &pair_count);
 *   swp_session_end_frame(session, frame_time_ns, 0);
 *
 * Threads: a session has a frame thread, which means one caller at a time. Optionally it has a
 * second caller, which polls the decider (c_deciders.h) or drives the link (c_link.h). Each
 * function below states which of them may call it. A shadow lane is a thread of the session, and
 * ends with it.
 *
 * Cost: a frame takes the time of its backend, a few atomic operations and a few readings of the
 * clock. Pairs are not copied; boxes are copied only in the few frames that a shadow lane measures.
 * The frame thread never waits, takes no lock, and in steady state allocates nothing. */
/* Included before the guard, so that c_api.h includes its headers in the order of their
 * dependencies. */
#include "sweepstake/c_api.h"

#ifndef SWEEPSTAKE_C_SESSIONS_H_
#define SWEEPSTAKE_C_SESSIONS_H_

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

typedef struct swp_session swp_session;

typedef uint32_t swp_mode;
enum { SWP_MODE_MANUAL = 1, SWP_MODE_AI = 2 };

typedef uint32_t swp_switch_reason;
enum {
  SWP_SWITCH_POLICY = 1,
  SWP_SWITCH_EXPLORATION = 2,
  SWP_SWITCH_BAIL_OUT = 3,
  SWP_SWITCH_MANUAL = 4
};

enum {
  SWP_FRAME_REBUILD = 1,        /* the backend's structure was rebuilt */
  SWP_FRAME_PAUSED = 2,         /* the game was paused or in the background */
  SWP_FRAME_LOADING = 4,        /* a scene was loading */
  SWP_FRAME_BAIL_OUT = 8,       /* the frame was over the bail-out limit */
  SWP_FRAME_SUSPENDED = 16,     /* the system stopped the process; the times are not a cost */
  SWP_FRAME_PAIRS_EXCEEDED = 32 /* a search exceeded max_pairs; the times are not a cost */
};

/* The shadow lane is a thread that measures the inactive arms. It also prepares the next arm
 * before a switch, so that the frame of the switch takes no longer than others (shadow.h). For
 * that, a commanded switch waits some frames. A switch because of a bail-out does not wait. */
typedef uint32_t swp_shadow_mode;
enum {
  SWP_SHADOW_OFF = 0,
  SWP_SHADOW_AUTO = 1, /* runs from the first SWP_MODE_AI on, while there is a spare core; rests
                          with a policy that does not learn from it, such as "paper" */
  SWP_SHADOW_ON = 2    /* runs also in a game that has always been manual, and with each policy */
};

typedef struct swp_session_options {
  uint32_t struct_size;
  swp_mode mode;
  const char* arms;        /* names of backends, each once, at most 32, for example "SAP,DBVT"; NULL
                              or "": all */
  const char* initial_arm; /* NULL or "": the first of `arms`, or KDTree if `arms` is NULL or "" */
  uint64_t bail_out_ns;    /* a longer frame is flagged, and the decider judges whether it is a
                              bail-out. Without a decider, and to end an operator's order, it is one
                              if its arm is to blame: detection took at least half of it, and it was
                              neither paused, loading nor suspended. > 0. A daemon's welcome replaces
                              the value while a link is attached */
  uint64_t settling_ns;    /* the time after a switch whose extra frame time is part of the switch's
                              cost; nothing is learnt from these frames. A trial lasts for twice
                              this time; with 0 no trials are made. At most 100 days if a decider is
                              attached; AI Decides uses at most 1 s of it. A daemon's welcome replaces
                              the value while a link is attached */
  const swp_executor* executor; /* as in swp_world_options */
  uint32_t thread_count;        /* as in swp_world_options */
  uint32_t queue_frames;  /* samples kept for a decider or a link, a power of two, 2 to 2^20; if
                             full, the oldest is dropped */
  swp_shadow_mode shadow; /* default: SWP_SHADOW_AUTO */
  uint32_t sorted_pairs;  /* 1: pairs ascend by a and then b whatever the arm, so that a switch does
                             not change a lockstep game; not part of a sample's detection time */
  double shadow_duty_ratio;     /* the lane's maximum share of one core, over 0 to 1; default:
                                   0.15 */
  uint64_t shadow_memory_bytes; /* the lane's maximum memory, half of it for copied boxes; default:
                                   64 MiB. If the frames do not fit, the state is
                                   SWP_SHADOW_STATE_TOO_BIG */
  uint64_t memory_budget_bytes; /* limit for all arms, the pairs and the lane, which takes at most
                                   half of it; 0: no limit. Above it, at a switch or when the active
                                   arm grows, inactive arms and then the lane are freed */
  uint64_t max_pairs;           /* as in swp_world_options */
} swp_session_options;

/* The cost of one frame. If it had several searches, times and checks are summed; the counts of
 * bytes, pairs and objects come from the latest search. */
typedef struct swp_frame_sample {
  uint64_t frame_index;
  uint64_t frame_time_ns;
  uint64_t detection_time_ns; /* time to update and search; 0 without a search */
  uint64_t aabb_check_count;
  uint64_t native_bytes;
  uint32_t pair_count;
  uint32_t object_count;
  uint32_t arm;               /* index in the session's list of arms */
  uint32_t switch_epoch;      /* executed switches before this frame */
  uint32_t flags;             /* SWP_FRAME_ bits */
  uint32_t invalid_box_count; /* objects that overlap nothing because their boxes are NaN, infinite
                                 or inverted; a box with min > max on all axes is an unused place
                                 and does not count. Boxes that were added count at once; a box that
                                 changes later counts within object_count / 4 frames */
} swp_frame_sample;

typedef struct swp_switch_command {
  uint64_t command_id; /* id of the decider's command, below 2^40; 0: not from a decider */
  uint32_t arm;
  swp_switch_reason reason;
} swp_switch_command;

typedef struct swp_switch_outcome {
  uint64_t command_id;
  uint32_t arm;
  uint32_t switch_epoch;
  uint64_t rebuild_time_ns;
  uint64_t settling_cost_ns; /* frame time above the settled mean, over the settling frames */
  swp_switch_reason reason;
  uint32_t executed; /* 0: refused */
} swp_switch_outcome;

typedef uint32_t swp_shadow_state;
enum {
  SWP_SHADOW_STATE_OFF = 0,           /* the options disable the lane */
  SWP_SHADOW_STATE_ONE_ARM = 1,       /* off: there is only one arm */
  SWP_SHADOW_STATE_NO_SPARE_CORE = 2, /* resting: the game's threads use all cores */
  SWP_SHADOW_STATE_PAUSED = 3,        /* SWP_SHADOW_AUTO rests: see swp_shadow_mode */
  SWP_SHADOW_STATE_RUNNING = 4,
  SWP_SHADOW_STATE_TOO_BIG = 5 /* the scene does not fit in the lane's memory */
};

/* The shadow lane's counters since the session began. */
typedef struct swp_shadow_stats {
  uint32_t struct_size;
  swp_shadow_state state;
  uint64_t sweep_count; /* sweeps: passes over the arms that were due */
  uint64_t visit_count; /* visits: measurements of one arm each */
  uint64_t capped_visit_count;
  uint64_t busy_time_ns; /* busy time of the lane's thread */
  uint64_t memory_bytes; /* memory of the lane now */
  uint64_t copied_frame_count;
  uint64_t copy_time_ns;      /* time of copying boxes on the frame thread */
  uint64_t warm_switch_count; /* switches whose arm the lane had prepared */
  uint64_t cold_switch_count;
} swp_shadow_stats;

/* The decider's conclusion about the scene. */
typedef uint32_t swp_verdict_kind;
enum {
  SWP_VERDICT_UNKNOWN = 0,   /* nothing decided yet */
  SWP_VERDICT_STABLE = 1,    /* the leader is the best arm with a probability of 0.8 or more */
  SWP_VERDICT_TIE = 2,       /* the leader has less than 0.8, but choosing it loses at most 0.5 % */
  SWP_VERDICT_AMBIGUOUS = 3, /* the leader has less than 0.8, with a larger loss: expect switches */
  SWP_VERDICT_DEGRADED = 4   /* even with the leader, detection makes the game miss the frame-rate
                                floor: simplify the scene */
};

typedef struct swp_verdict {
  swp_verdict_kind kind;     /* a later library may have more kinds: treat them as unknown */
  uint32_t leader_arm;       /* most probably the best arm; 0 while nothing is known */
  double leader_probability; /* the probability that it is the best, 0 to 1 */
} swp_verdict;

/* The outcome of a decision's candidate. A later library may have more values. */
typedef uint32_t swp_decision_outcome;
enum {
  SWP_DECISION_NONE = 0,          /* no decision yet */
  SWP_DECISION_KEPT = 1,          /* the candidate is active */
  SWP_DECISION_SWITCHED = 2,      /* a switch was commanded */
  SWP_DECISION_HELD_COOLDOWN = 3, /* the cooldown after the latest switch has not passed */
  SWP_DECISION_HELD_SETTLING = 4, /* all frames were settling, or a switch is in progress */
  SWP_DECISION_NO_FRAMES = 5,     /* no frame to learn from since the previous decision */
  SWP_DECISION_MANUAL = 6,        /* the mode is SWP_MODE_MANUAL */
  SWP_DECISION_EXPLORING = 7,     /* no candidate; the command goes to the next arm to try */
  SWP_DECISION_REJECTED = 8,      /* a metric is not finite */
  SWP_DECISION_HELD_GATE = 9      /* the expected gain is less than the cost of the switch */
};

enum { SWP_MAX_ARMS = 32 };
#define SWP_NO_ARM 0xffffffffU

/* A decision and its reasons, for logs and debug views. */
typedef struct swp_decision {
  uint32_t struct_size;
  swp_decision_outcome outcome;
  uint64_t decision_id; /* counts from 1; 0: made by a daemon, which sends only commands */
  uint64_t time_ns;     /* on the clock of now_ns; the decision's age is the time since then */
  uint32_t active_arm;
  uint32_t candidate_arm;           /* the arm that the policy proposed; SWP_NO_ARM: none */
  uint64_t command_id;              /* id of the commanded switch; 0: none */
  uint32_t command_arm;             /* SWP_NO_ARM: none */
  swp_switch_reason command_reason; /* 0: none */
  swp_verdict verdict;
  double expected_loss_ratio;  /* expected loss of choosing the leader / the best arm's cost */
  double best_probability[32]; /* each arm's probability of being the best; all 0: unknown */
} swp_decision;

/* Sets the defaults: all arms, KDTree at first, SWP_MODE_AI, a bail-out limit of 5 s, 2 s of
 * settling, 4,096 samples, the calling thread alone, and SWP_SHADOW_AUTO. */
SWP_API swp_result swp_session_options_init(swp_session_options* options);

/* Makes a session. `options` NULL uses the defaults. SWP_NOT_FOUND for an unknown arm; the
 * message lists the backends. SWP_RESOURCE_EXHAUSTED if the system cannot create a thread. */
SWP_API swp_result swp_session_create(const swp_session_options* options, swp_session** session);
/* Destroys the session. No other call of the session may be in progress. */
SWP_API void swp_session_destroy(swp_session* session);

/* The frame thread calls these functions in this order. begin_frame and end_frame are called once
 * per frame, find_pairs any number of times between them. They do not wait, lock, or allocate in
 * steady state. */

/* Executes a pending switch, if any. */
SWP_API swp_result swp_session_begin_frame(swp_session* session);
/* Passes the boxes to the active backend and searches for pairs. The number of boxes may change
 * as in swp_world_update. In a frame with substeps or several fixed updates, call it for each of
 * them; together they are one sample. After SWP_RESOURCE_EXHAUSTED (memory, or more pairs than
 * max_pairs) there are no pairs until the next search, which rebuilds; end the frame as usual. */
SWP_API swp_result swp_session_find_pairs(swp_session* session, const swp_aabb* boxes,
                                          uint32_t box_count);
/* The pairs of the latest search, in the library's memory, which any thread may read until the next
 * find_pairs or begin_frame. SWP_FAILED_PRECONDITION if this frame has not searched, or its latest
 * search failed. */
SWP_API swp_result swp_session_pairs(const swp_session* session, const swp_pair** pairs,
                                     uint64_t* count);
/* Ends the frame. `frame_time_ns` is the unscaled time since the previous end_frame. `flags` may
 * contain SWP_FRAME_PAUSED and SWP_FRAME_LOADING. */
SWP_API swp_result swp_session_end_frame(swp_session* session, uint64_t frame_time_ns,
                                         uint32_t flags);

/* Functions of the frame thread. */

/* Frees the buffers that the next frame does not need: the buffers of inactive arms and of the
 * pairs. The shadow lane frees its memory soon after, on its own thread. Call it at the end of a
 * level, or when memory is low. SWP_FAILED_PRECONDITION between begin_frame and end_frame. The
 * pairs of the latest search become invalid; the next frame and later switches allocate again.
 * Cost: the time to free it. */
SWP_API swp_result swp_session_trim(swp_session* session);

/* Chooses an arm manually, from the next begin_frame on; the mode does not change. The message of
 * SWP_NOT_FOUND lists the arms. */
SWP_API swp_result swp_session_select_arm(swp_session* session, const char* arm);
/* Sets the mode. In SWP_MODE_MANUAL posted commands are refused unless their reason is
 * SWP_SWITCH_MANUAL. */
SWP_API swp_result swp_session_set_mode(swp_session* session, swp_mode mode);
/* The session's current mode, active arm, and number of executed switches. */
SWP_API swp_result swp_session_mode(const swp_session* session, swp_mode* mode);
SWP_API swp_result swp_session_active_arm(const swp_session* session, uint32_t* arm);
SWP_API swp_result swp_session_switch_epoch(const swp_session* session, uint32_t* switch_epoch);
/* The sample of the latest end_frame; all 0 before the first. */
SWP_API swp_result swp_session_last_sample(const swp_session* session, swp_frame_sample* sample);

/* Functions for any thread. */

/* The session's arms, which never change. */
SWP_API swp_result swp_session_arm_count(const swp_session* session, uint32_t* count);
/* The name of an arm, valid until the session is destroyed. */
SWP_API swp_result swp_session_arm_name(const swp_session* session, uint32_t arm,
                                        const char** name);
SWP_API swp_result swp_session_arm_version(const swp_session* session, uint32_t arm,
                                           uint32_t* backend_version);
/* The latest verdict of the attached decider or of the link's daemon; SWP_VERDICT_UNKNOWN before
 * the first. Reading it is one atomic load, so a game may call this function in each frame and
 * react:
 *
 *   swp_verdict verdict;
 *   if (swp_session_verdict(session, &verdict) == SWP_OK && verdict.kind == SWP_VERDICT_DEGRADED) {
 *     spawn_fewer_objects();
 *   } */
SWP_API swp_result swp_session_verdict(const swp_session* session, swp_verdict* verdict);
/* The latest decision of the attached decider, with its reasons, or the latest command of the
 * daemon. The outcome is SWP_DECISION_NONE before the first. The value is kept when the decider
 * is detached. Lock-free; the frame thread does not wait for it. */
SWP_API swp_result swp_session_last_decision(const swp_session* session, swp_decision* decision);
/* The latest outcome: of a switch that has settled or was refused, or of the end of a trial. All
 * 0 before the first. Lock-free. */
SWP_API swp_result swp_session_last_outcome(const swp_session* session,
                                            swp_switch_outcome* outcome);
/* The numbers of items that full queues have dropped since the session began: samples, and
 * switch outcomes and descriptors together. Either pointer may be NULL. */
SWP_API swp_result swp_session_dropped(const swp_session* session, uint64_t* sample_count,
                                       uint64_t* note_count);

/* The shadow lane's counters, and its state, which gives the reason if the lane does not run. */
SWP_API swp_result swp_session_shadow_stats(const swp_session* session, swp_shadow_stats* stats);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_SESSIONS_H_ */
