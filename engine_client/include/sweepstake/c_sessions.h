/* The part of the C ABI for sessions: the frame path, which switches between backends; c_api.h
 * includes it and says what holds for all: threads, ownership, units, results. The functions mirror
 * sweepstake/adaptive_broad_phase.h.
 *
 * A frame:
 *
 *   swp_session_begin_frame(session);
 *   swp_session_find_pairs(session, boxes, count);
 *   swp_session_pairs(session, &pairs, &pair_count);
 *   swp_session_end_frame(session, frame_time_ns, 0);
 *
 * Threads: a session has a frame thread, that is one caller at a time, and optionally one other,
 * whoever polls the decider (c_deciders.h) or drives the link (c_link.h); each function below says
 * which of them may call it. With a shadow lane it has a thread of its own, which ends with it.
 *
 * Cost: a frame takes what its backend takes, and a few atomic operations and readings of the
 * clock; boxes and pairs are not copied, but for the boxes of the few frames that a shadow lane
 * measures. The frame thread never waits, takes no lock, and in steady state allocates nothing.
 */
/* Before the guard: c_api.h includes the headers in the order in which they need one another. */
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
  SWP_FRAME_REBUILD = 1, /* the backend's structure was rebuilt */
  SWP_FRAME_PAUSED = 2,  /* the game was paused or in the background */
  SWP_FRAME_LOADING = 4, /* a scene was loading */
  SWP_FRAME_BAIL_OUT = 8 /* over the bail-out limit */
};

/* The shadow lane: a thread that measures the arms that are not active, and prepares the next one
 * before a switch, so that the switching frame is an ordinary one (shadow.h). A posted switch then
 * waits some frames; one for a bail-out does not. */
typedef uint32_t swp_shadow_mode;
enum {
  SWP_SHADOW_OFF = 0,
  SWP_SHADOW_AUTO = 1, /* from the first SWP_MODE_AI on, while there is a spare core */
  SWP_SHADOW_ON = 2    /* in a game that has always been manual too */
};

typedef struct swp_session_options {
  uint32_t struct_size;
  swp_mode mode;
  const char* arms;        /* names of backends, each once, at most 32, for example "SAP,DBVT"; NULL
                              or "": all */
  const char* initial_arm; /* NULL or "": the first of `arms`, or KDTree if those are NULL or "" */
  uint64_t bail_out_ns;    /* a longer frame is flagged, and the decider says whether it is a
                              bail-out; without one, and for an operator's order, it is where its
                              arm is to blame: detection took at least half of it, and it was
                              neither paused nor loading; > 0. A daemon's welcome replaces it while
                              there is a link */
  uint64_t settling_ns;    /* how long after a switch the frames' extra cost is the switch's, and
                              nothing is learnt from them; a trial lasts for twice that, and with 0
                              there is none. At most 100 days where a decider is attached. A
                              daemon's welcome replaces it while there is a link */
  const swp_executor* executor; /* as in swp_world_options */
  uint32_t thread_count;        /* as in swp_world_options */
  uint32_t queue_frames;  /* samples kept for a decider or a link, a power of two, 2 to 2^20; full:
                             the oldest is dropped */
  swp_shadow_mode shadow; /* SWP_SHADOW_OFF unless set */
  uint32_t sorted_pairs;  /* 1: pairs ascend by a and then b whatever the arm, so that a lockstep
                             game sees no switch; no part of a sample's detection time */
  double shadow_duty_ratio;     /* the lane's share of one core at most, over 0 to 1; 0.15 */
  uint64_t shadow_memory_bytes; /* the lane's maximum, half of it for copied boxes; 64 MiB. If the
                                   frames do not fit, there is SWP_SHADOW_STATE_TOO_BIG */
  uint64_t memory_budget_bytes; /* of all arms, the pairs and the lane, which takes half of it at
                                   most; 0: no limit. If they take more at a switch or when the
                                   active arm grows, what it does not need is freed */
} swp_session_options;

/* The cost of one frame. Of several searches, times and checks are summed; the counts of bytes,
 * pairs and objects are the latest one's. */
typedef struct swp_frame_sample {
  uint64_t frame_index;
  uint64_t frame_time_ns;
  uint64_t detection_time_ns; /* to take the boxes and search; 0 without a search */
  uint64_t aabb_check_count;
  uint64_t native_bytes;
  uint32_t pair_count;
  uint32_t object_count;
  uint32_t arm;          /* index in the session's list of arms */
  uint32_t switch_epoch; /* executed switches before this frame */
  uint32_t flags;        /* SWP_FRAME_ bits */
  uint32_t reserved;
} swp_frame_sample;

typedef struct swp_switch_command {
  uint64_t command_id; /* below 2^48; 0: local */
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
  SWP_SHADOW_STATE_OFF = 0,           /* as asked for */
  SWP_SHADOW_STATE_ONE_ARM = 1,       /* off: there is nothing to compare */
  SWP_SHADOW_STATE_NO_SPARE_CORE = 2, /* at rest: the game's threads leave no core */
  SWP_SHADOW_STATE_PAUSED = 3,        /* SWP_SHADOW_AUTO, and never in SWP_MODE_AI */
  SWP_SHADOW_STATE_RUNNING = 4,
  SWP_SHADOW_STATE_TOO_BIG = 5 /* the scene does not fit in the lane's memory */
};

/* Since the session began. */
typedef struct swp_shadow_stats {
  uint32_t struct_size;
  swp_shadow_state state;
  uint64_t sweep_count; /* over the arms that were due */
  uint64_t visit_count; /* of one arm each */
  uint64_t capped_visit_count;
  uint64_t busy_time_ns; /* of the lane's thread */
  uint64_t memory_bytes; /* now */
  uint64_t copied_frame_count;
  uint64_t copy_time_ns;      /* on the frame thread */
  uint64_t warm_switch_count; /* prepared by the lane */
  uint64_t cold_switch_count;
} swp_shadow_stats;

/* What the decider's beliefs say about the scene. */
typedef uint32_t swp_verdict_kind;
enum {
  SWP_VERDICT_UNKNOWN = 0,   /* nothing decided yet */
  SWP_VERDICT_STABLE = 1,    /* the leader is the best arm with a probability of 0.8 or more */
  SWP_VERDICT_TIE = 2,       /* below 0.8, but choosing the leader loses 0.5 % or less */
  SWP_VERDICT_AMBIGUOUS = 3, /* below 0.8, and it may lose more: expect switches */
  SWP_VERDICT_DEGRADED = 4   /* even the leader misses the frame-rate floor: simplify the scene */
};

typedef struct swp_verdict {
  swp_verdict_kind kind;     /* a later library may have more kinds: treat those as unknown */
  uint32_t leader_arm;       /* the arm most probable to be the best; 0 while nothing is known */
  double leader_probability; /* the probability that it is the best, 0 to 1 */
} swp_verdict;

/* What came of a decision's candidate. A later library may have more. */
typedef uint32_t swp_decision_outcome;
enum {
  SWP_DECISION_NONE = 0,          /* there was no decision yet */
  SWP_DECISION_KEPT = 1,          /* the candidate is active */
  SWP_DECISION_SWITCHED = 2,      /* a switch was commanded */
  SWP_DECISION_HELD_COOLDOWN = 3, /* the cooldown after the latest switch has not passed */
  SWP_DECISION_HELD_SETTLING = 4, /* all frames were settling, or a switch is under way */
  SWP_DECISION_NO_FRAMES = 5,     /* there was nothing to learn from since the decision before */
  SWP_DECISION_MANUAL = 6,        /* SWP_MODE_MANUAL */
  SWP_DECISION_EXPLORING = 7,     /* no candidate; the command goes to the next arm to try */
  SWP_DECISION_REJECTED = 8,      /* a metric is not finite */
  SWP_DECISION_HELD_GATE = 9,     /* the expected gain is not worth the cost of the switch */
  SWP_DECISION_HELD_TIE = 12      /* the candidate is not better by as much as matters */
};

enum { SWP_MAX_ARMS = 32 };
#define SWP_NO_ARM 0xffffffffU

/* A decision and its reasons, for logs and debug views. */
typedef struct swp_decision {
  uint32_t struct_size;
  swp_decision_outcome outcome;
  uint64_t decision_id; /* from 1; 0: a daemon's, which tells its commands alone */
  uint64_t time_ns;     /* on the clock of now_ns, so that its age is the time since then */
  uint32_t active_arm;
  uint32_t candidate_arm;           /* what the policy proposed; SWP_NO_ARM: nothing */
  uint64_t command_id;              /* of the switch that was commanded; 0: none was */
  uint32_t command_arm;             /* SWP_NO_ARM: none */
  swp_switch_reason command_reason; /* 0: none */
  swp_verdict verdict;
  double expected_loss_ratio;  /* of choosing the leader, relative to the best arm's cost */
  double best_probability[32]; /* of each arm to be the best; all 0: nothing is known */
} swp_decision;

/* Fills in the defaults: all arms, KDTree at first, SWP_MODE_AI, a bail-out limit of 5 s, 2 s of
 * settling, 4,096 samples, the calling thread alone, and no shadow lane. */
SWP_API swp_result swp_session_options_init(swp_session_options* options);

/* `options` NULL takes the defaults. SWP_NOT_FOUND lists the backends; SWP_RESOURCE_EXHAUSTED if
 * the system has no more threads. */
SWP_API swp_result swp_session_create(const swp_session_options* options, swp_session** session);
/* No other call may be under way. */
SWP_API void swp_session_destroy(swp_session* session);

/* The frame thread calls these in this order: once per frame the first and the last, find_pairs any
 * number of times between them. None waits, locks, or allocates in steady state. */

/* Executes a pending switch, if there is one. */
SWP_API swp_result swp_session_begin_frame(swp_session* session);
/* The active backend takes these boxes, whose count may change as in swp_world_update, and
 * searches. A frame with substeps or several fixed updates calls it for each; together they are one
 * sample. After SWP_RESOURCE_EXHAUSTED (memory) there are no pairs until the next search, which
 * rebuilds; the frame ends as any other. */
SWP_API swp_result swp_session_find_pairs(swp_session* session, const swp_aabb* boxes,
                                          uint32_t box_count);
/* The pairs of the latest search, in the library's memory, where any thread may read them until the
 * next find_pairs or begin_frame. SWP_FAILED_PRECONDITION if this frame has not searched, or
 * its latest search failed. */
SWP_API swp_result swp_session_pairs(const swp_session* session, const swp_pair** pairs,
                                     uint64_t* count);
/* `frame_time_ns` is the unscaled time since the previous end; `flags` of SWP_FRAME_PAUSED and
 * SWP_FRAME_LOADING. */
SWP_API swp_result swp_session_end_frame(swp_session* session, uint64_t frame_time_ns,
                                         uint32_t flags);

/* Functions of the frame thread. */

/* Frees what the next frame does not need: the buffers of inactive arms, the pairs, and soon, on
 * its own thread, what the shadow lane keeps; for the end of a level, or where the system is short
 * of memory. SWP_FAILED_PRECONDITION between begin_frame and end_frame. The pairs of the latest
 * search are gone; the next frame and later switches allocate again. Cost: it frees memory. */
SWP_API swp_result swp_session_trim(swp_session* session);

/* Chooses an arm by hand, from the next begin_frame on; the mode stays. SWP_NOT_FOUND lists the
 * arms.
 */
SWP_API swp_result swp_session_select_arm(swp_session* session, const char* arm);
/* In SWP_MODE_MANUAL posted commands are refused unless their reason is SWP_SWITCH_MANUAL. */
SWP_API swp_result swp_session_set_mode(swp_session* session, swp_mode mode);
/* What is so now; each is a read of a few bytes. */
SWP_API swp_result swp_session_mode(const swp_session* session, swp_mode* mode);
SWP_API swp_result swp_session_active_arm(const swp_session* session, uint32_t* arm);
SWP_API swp_result swp_session_switch_epoch(const swp_session* session, uint32_t* switch_epoch);
/* The sample of the latest end_frame; all 0 before it. */
SWP_API swp_result swp_session_last_sample(const swp_session* session, swp_frame_sample* sample);

/* Functions for any thread. */

/* The arms, which stay as they were given. */
SWP_API swp_result swp_session_arm_count(const swp_session* session, uint32_t* count);
/* The name is valid until the session is destroyed. */
SWP_API swp_result swp_session_arm_name(const swp_session* session, uint32_t arm,
                                        const char** name);
SWP_API swp_result swp_session_arm_version(const swp_session* session, uint32_t arm,
                                           uint32_t* backend_version);
/* The latest verdict, for the game to react to: of the attached decider, or the link's daemon;
 * SWP_VERDICT_UNKNOWN before the first. It is one atomic read, so a game may call it each
 * frame:
 *
 *   swp_verdict verdict;
 *   if (swp_session_verdict(session, &verdict) == SWP_OK && verdict.kind == SWP_VERDICT_DEGRADED) {
 *     spawn_fewer_objects();
 *   }
 */
SWP_API swp_result swp_session_verdict(const swp_session* session, swp_verdict* verdict);
/* The latest decision of the attached decider, or command of the daemon, with its reasons; its
 * outcome is SWP_DECISION_NONE before the first. It stays when the decider is detached. Lock-free,
 * and the frame thread does not wait for it. */
SWP_API swp_result swp_session_last_decision(const swp_session* session, swp_decision* decision);
/* The outcome of the latest switch that has settled, was refused, or has ended a trial just now,
 * whoever asked for it; all 0 before the first. Lock-free, and draining does not take it away. */
SWP_API swp_result swp_session_last_outcome(const swp_session* session,
                                            swp_switch_outcome* outcome);
/* The numbers of samples, and of switch outcomes and descriptors together, that full queues dropped
 * since the session began. Either pointer may be NULL. */
SWP_API swp_result swp_session_dropped(const swp_session* session, uint64_t* sample_count,
                                       uint64_t* note_count);

/* What the shadow lane has done, and why it runs or does not. */
SWP_API swp_result swp_session_shadow_stats(const swp_session* session, swp_shadow_stats* stats);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_SESSIONS_H_ */
