/* The part of the C ABI for objects by handle, filters, static objects, pair events and queries.
 * c_api.h includes this header and has the rules for threads, ownership, units and results.
 *
 * The functions mirror sweepstake/proxy_set.h, which states the cost of each. A frame, with a world
 * or a session:
 *
 *   swp_proxies_set_boxes(proxies, handles, boxes, count);
 *   swp_proxies_moving_boxes(proxies, &moving, &moving_count);
 *   swp_world_update(world, moving, moving_count);
 *   swp_world_find_pairs(world);
 *   swp_world_pairs(world, &found, &found_count);
 *   swp_proxies_resolve(proxies, found, found_count);
 *   swp_proxies_pairs(proxies, &pairs, &pair_count);
 *
 * A set has one caller at a time. Calls that take a const set are the exception: they may run on
 * any number of threads at the same time, if no other call runs. A handle of a removed proxy, or
 * one that never had a proxy, is SWP_NOT_FOUND and changes nothing. */
/* Included before the guard, so that c_api.h includes its headers in the order of their
 * dependencies. */
#include "sweepstake/c_api.h"

#ifndef SWEEPSTAKE_C_PROXIES_H_
#define SWEEPSTAKE_C_PROXIES_H_

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

typedef struct swp_proxies swp_proxies;

/* A handle of a proxy; 0 means no proxy. The low 32 bits are the proxy's id in pairs while it
 * exists. A new proxy gets the lowest free id, so that ids may index an array of the caller. The
 * high 32 bits count the added proxies; they begin at 1 again after 2^32 - 1. */
typedef uint64_t swp_proxy;
#define SWP_PROXY_ID(proxy) ((uint32_t)(proxy))

/* An id has this bit if and only if its proxy was added as static. */
#define SWP_STATIC_PROXY_BIT 0x80000000U

/* Two proxies may form a pair if the category of each shares a bit with the mask of the other. The
 * default, also of a function that gets NULL, has all bits set: it passes every proxy that has a
 * category and a mask. */
typedef struct swp_filter {
  uint32_t category;
  uint32_t mask;
} swp_filter;

enum {
  SWP_PROXY_STATIC = 1,  /* paired with moving and sleeping proxies only */
  SWP_PROXY_SLEEPING = 2 /* only swp_proxies_get sets it; see swp_proxies_set_sleeping */
};

typedef struct swp_proxy_options {
  swp_filter filter; /* {0, 0} passes with nothing; {~0u, ~0u} with everything */
  uint32_t flags;    /* SWP_PROXY_ bits */
  uint32_t reserved; /* 0 */
  uint64_t user;     /* any value of the caller */
} swp_proxy_options;

/* Two proxies; the id of a is below the id of b. */
typedef struct swp_proxy_pair {
  swp_proxy a;
  swp_proxy b;
} swp_proxy_pair;

/* A ray is the points origin + t * direction, t from 0 to max_distance; all values are finite. */
typedef struct swp_ray {
  float origin[3];
  float direction[3];
  float max_distance;
} swp_ray;

/* The points up to `radius` (0 to 1e19) from the center; all values are finite. */
typedef struct swp_sphere {
  float center[3];
  float radius;
} swp_sphere;

/* A valid box swept along a finite translation, and all points it covers on the way. */
typedef struct swp_box_sweep {
  swp_aabb box;
  float translation[3];
} swp_box_sweep;

typedef struct swp_ray_hit {
  swp_proxy proxy;
  float distance;    /* the t at which the ray enters the box; for a sweep the fraction of the
                      * translation after which the boxes touch; 0 if it starts inside */
  uint32_t reserved; /* 0 */
} swp_ray_hit;

typedef struct swp_proxies_options {
  uint32_t struct_size;
  uint32_t pair_events;         /* 1: fills swp_proxies_added and _removed */
  uint32_t sorted_pairs;        /* 1: pairs ascend, whatever the backend; pair events imply it */
  uint32_t thread_count;        /* as in swp_world_options */
  const swp_executor* executor; /* as in swp_world_options */
  float event_margin;           /* a pair ends when its boxes are farther apart than this on an
                                 * axis; the pairs themselves stay exact; not negative */
  uint32_t reserved;            /* 0 */
  uint64_t max_pairs;           /* the maximum number of pairs of a resolve, before the filters;
                                 * 0: no limit, even if the world or session has one. With more
                                 * pairs, swp_proxies_resolve ends early and returns
                                 * SWP_RESOURCE_EXHAUSTED */
} swp_proxies_options;

/* Sets the defaults: no events, unsorted pairs, and the calling thread alone. */
SWP_API swp_result swp_proxies_options_init(swp_proxies_options* options);
/* Makes an empty set. `options` NULL uses the defaults. SWP_RESOURCE_EXHAUSTED if the system has no
 * more threads. */
SWP_API swp_result swp_proxies_create(const swp_proxies_options* options, swp_proxies** proxies);
SWP_API void swp_proxies_destroy(swp_proxies* proxies);

/* Adds a proxy for each box and writes their handles to `added`. `options` has one element per box;
 * NULL makes moving proxies with the default filter and user 0. Cost: O(1) per moving
 * proxy; for static ones see ProxySet::Add. If memory runs out, no proxy is added, and the content
 * of `added` is undefined. */
SWP_API swp_result swp_proxies_add_many(swp_proxies* proxies, const swp_aabb* boxes,
                                        const swp_proxy_options* options, uint32_t count,
                                        swp_proxy* added);
/* Removes these proxies. If one handle is SWP_NOT_FOUND, none is removed. A handle may be given
 * twice. */
SWP_API swp_result swp_proxies_remove_many(swp_proxies* proxies, const swp_proxy* removed,
                                           uint32_t count);
/* Gives boxes[k] to moved[k]. If one handle is SWP_NOT_FOUND, no proxy is moved. Cost: O(1) each;
 * almost nothing for an unchanged box. A resting proxy with a new box costs an add at the next use.
 */
SWP_API swp_result swp_proxies_set_boxes(swp_proxies* proxies, const swp_proxy* moved,
                                         const swp_aabb* boxes, uint32_t count);
/* Sets the filter. It applies from the next resolve and the next query on. */
SWP_API swp_result swp_proxies_set_filter(swp_proxies* proxies, swp_proxy proxy,
                                          const swp_filter* filter);
/* Sets the user value, which swp_proxies_get returns. */
SWP_API swp_result swp_proxies_set_user(swp_proxies* proxies, swp_proxy proxy, uint64_t user);
/* 1 makes a moving proxy static; 0 makes a static one moving and awake. Handle and id stay the
 * same. Cost: as an add. */
SWP_API swp_result swp_proxies_set_static(swp_proxies* proxies, swp_proxy proxy,
                                          uint32_t is_static);
/* 1 marks a proxy that will not move. Its pairs with other resting (static or sleeping) proxies are
 * kept, and no search starts from it. Setting a different box wakes it. Pairs, events and queries
 * are the same as without the mark. Does nothing for a static proxy. Cost: as an add; the next
 * resolve searches once among all resting proxies. */
SWP_API swp_result swp_proxies_set_sleeping(swp_proxies* proxies, swp_proxy proxy,
                                            uint32_t is_sleeping);
/* Subtracts offset[0..2] from all coordinates. No pair ends. Boxes whose gap is below the rounding
 * of coordinates may begin to touch. A box that the shift takes beyond the largest float is invalid
 * until it gets another box; an invalid box stays invalid. SWP_INVALID_ARGUMENT for an offset that
 * is not finite, which changes nothing. Cost: O(proxies). */
SWP_API swp_result swp_proxies_shift_origin(swp_proxies* proxies, const float* offset);

/* The bytes that a snapshot of the current state takes. */
SWP_API swp_result swp_proxies_snapshot_bytes(const swp_proxies* proxies, uint64_t* bytes);
/* Writes the whole state to the caller's memory, without pointers, for a game that rolls back.
 * SWP_INVALID_ARGUMENT if `capacity` is below swp_proxies_snapshot_bytes. */
SWP_API swp_result swp_proxies_save(const swp_proxies* proxies, void* snapshot, uint64_t capacity);
/* Restores the state: handles, pairs, events and queries are again as they were at the save.
 * Handles made since the save are given out again. `bytes` may exceed the size of the snapshot.
 * Invalidates pointers to pairs and boxes.
 *
 * The set is unchanged if the snapshot is refused. The result is SWP_DATA_LOSS if it is cut off or
 * damaged, SWP_INVALID_ARGUMENT if it is of another version of the library or of a set with other
 * options. Do not restore untrusted snapshots. If memory runs out, part of the state is lost: only
 * another restore or swp_proxies_destroy may follow. */
SWP_API swp_result swp_proxies_restore(swp_proxies* proxies, const void* snapshot, uint64_t bytes);

/* Writes the current box and options. Either output may be NULL. */
SWP_API swp_result swp_proxies_get(const swp_proxies* proxies, swp_proxy proxy, swp_aabb* box,
                                   swp_proxy_options* options);
/* Writes the handle of the proxy that has this id now. */
SWP_API swp_result swp_proxies_handle(const swp_proxies* proxies, uint32_t id, swp_proxy* proxy);
/* The numbers of living proxies, and the memory that the set holds, in bytes. Every 256th resolve
 * frees memory that was not needed since then; the next add or removal frees that of the proxies.
 * Each output may be NULL. */
SWP_API swp_result swp_proxies_counts(const swp_proxies* proxies, uint32_t* moving_count,
                                      uint32_t* static_count, uint64_t* native_bytes);

/* The boxes to give to a world or a session, valid until the next change of the set. Changes are
 * adds, removals, new boxes, filters or flags, a shift and restore. Up to 1 in 32 boxes is invalid
 * and belongs to no proxy. An index is not an id; swp_proxies_resolve converts it. */
SWP_API swp_result swp_proxies_moving_boxes(const swp_proxies* proxies, const swp_aabb** boxes,
                                            uint32_t* count);
/* Call it once per frame with all pairs found in the boxes of swp_proxies_moving_boxes; the set
 * must be unchanged since they were read. Keeps the pairs whose filters pass, and adds the pairs of
 * moving and static proxies. SWP_INVALID_ARGUMENT unless each pair has a < b and both are indices
 * of these boxes. After SWP_RESOURCE_EXHAUSTED (memory or max_pairs) there are no pairs and no
 * events. The next successful resolve reports all events since the latest successful one. Skip it
 * in a frame whose search exceeded max_pairs; no pair ends then. */
SWP_API swp_result swp_proxies_resolve(swp_proxies* proxies, const swp_pair* moving_pairs,
                                       uint64_t moving_pair_count);
/* The pairs of the latest resolve, valid until the next one. They may share memory with
 * moving_pairs, and are then valid only while that memory is. SWP_FAILED_PRECONDITION before the
 * first resolve, and after restore or a resolve with SWP_RESOURCE_EXHAUSTED. */
SWP_API swp_result swp_proxies_pairs(const swp_proxies* proxies, const swp_pair** pairs,
                                     uint64_t* count);
/* The pairs that began (added) and ended (removed) between the latest two successful resolves,
 * ascending; empty without pair_events. Pairs of a removed proxy have ended. Valid until the next
 * resolve. */
SWP_API swp_result swp_proxies_added(const swp_proxies* proxies, const swp_proxy_pair** added,
                                     uint64_t* count);
SWP_API swp_result swp_proxies_removed(const swp_proxies* proxies, const swp_proxy_pair** removed,
                                       uint64_t* count);

/* Queries find the current moving and static proxies whose filter and the query's filter pass. They
 * take a const set and write to the caller's memory, so any number of threads may query at the same
 * time. Queries do not allocate. SWP_FAILED_PRECONDITION if the set has changed since
 * swp_proxies_prepare_queries. */

/* Prepares the queries, as ProxySet::PrepareQueries. Cost: O(1) if nothing has changed, O(moving
 * proxies) if a moving proxy has changed, otherwise O(changes). */
SWP_API swp_result swp_proxies_prepare_queries(swp_proxies* proxies);
/* Finds all proxies that overlap each box, by ascending id. The proxies of box k are in `found`
 * from index ends[k - 1] (0 for the first box) up to, but not including, ends[k]. If the
 * capacity of `found` is too small, the result is SWP_RESOURCE_EXHAUSTED. `ends` is correct even
 * then: its last value is the needed capacity. The content of `found` is undefined then. */
SWP_API swp_result swp_proxies_query_boxes(const swp_proxies* proxies, const swp_aabb* boxes,
                                           uint32_t box_count, const swp_filter* filter,
                                           swp_proxy* found, uint64_t capacity, uint64_t* ends);
/* Like swp_proxies_query_boxes, but finds the proxies that overlap spheres. */
SWP_API swp_result swp_proxies_query_spheres(const swp_proxies* proxies, const swp_sphere* spheres,
                                             uint32_t sphere_count, const swp_filter* filter,
                                             swp_proxy* found, uint64_t capacity, uint64_t* ends);
/* Finds the nearest hit of each ray; proxy and distance are 0 if there is none.
 * SWP_INVALID_ARGUMENT for a ray that is not finite or has a negative max_distance. */
SWP_API swp_result swp_proxies_cast_rays(const swp_proxies* proxies, const swp_ray* rays,
                                         uint32_t ray_count, const swp_filter* filter,
                                         swp_ray_hit* hits);
/* Like swp_proxies_cast_rays, but for swept boxes. */
SWP_API swp_result swp_proxies_sweep_boxes(const swp_proxies* proxies, const swp_box_sweep* sweeps,
                                           uint32_t sweep_count, const swp_filter* filter,
                                           swp_ray_hit* hits);
/* Finds all hits of one ray by ascending distance, then by id. If the capacity is too small, the
 * result is SWP_RESOURCE_EXHAUSTED, `count` is the needed capacity, and the content of `hits` is
 * undefined. */
SWP_API swp_result swp_proxies_cast_ray(const swp_proxies* proxies, const swp_ray* ray,
                                        const swp_filter* filter, swp_ray_hit* hits,
                                        uint64_t capacity, uint64_t* count);

/* Writes the smallest box of floats that contains the box of doubles min[0..2] to max[0..2]: min is
 * rounded down and max up. A coordinate beyond the range of float becomes infinite, which makes the
 * box invalid. A box that violates min <= max gives an invalid box too. */
SWP_API swp_result swp_round_outward(const double* min, const double* max, swp_aabb* box);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_PROXIES_H_ */
