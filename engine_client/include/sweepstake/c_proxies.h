/* The part of the C ABI for objects by handle, filters, static objects, pair events and queries;
 * c_api.h includes it and says what holds for all: threads, ownership, units, results.
 *
 * The functions mirror sweepstake/proxy_set.h, which says what each of them costs. A frame, with a
 * world or a session:
 *
 *   swp_proxies_move(proxies, handles, boxes, count);
 *   swp_proxies_moving_boxes(proxies, &moving, &moving_count);
 *   swp_world_update(world, moving, moving_count);
 *   swp_world_find_pairs(world, pairs, capacity, &pair_count);
 *   swp_proxies_resolve(proxies, pairs, pair_count, resolved, resolved_capacity, &resolved_count);
 *
 * One caller at a time may use a set. A handle of a removed proxy, or one that never had a proxy,
 * is SWP_NOT_FOUND and changes nothing.
 */
#ifndef SWEEPSTAKE_C_PROXIES_H_
#define SWEEPSTAKE_C_PROXIES_H_

#include <stdint.h>

#include "sweepstake/c_api.h"

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

typedef struct swp_proxies swp_proxies;

/* A handle of a proxy; 0 means no proxy. The low 32 bits are its id in pairs while it lives, the
 * high ones count the owners of that id. */
typedef uint64_t swp_proxy;
#define SWP_PROXY_ID(proxy) ((uint32_t)(proxy))

/* This bit is set in the ids of static proxies, and only there. */
#define SWP_STATIC_PROXY_BIT 0x80000000U

/* Two proxies may form a pair when the category of each shares a bit with the mask of the other.
 * Where a function takes a filter, NULL is the one of all bits: everything passes but a proxy
 * without a category or a mask. */
typedef struct swp_filter {
  uint32_t category;
  uint32_t mask;
} swp_filter;

enum {
  SWP_PROXY_STATIC = 1 /* paired with moving proxies only */
};

typedef struct swp_proxy_options {
  swp_filter filter;
  uint32_t flags;    /* SWP_PROXY_ bits */
  uint32_t reserved; /* 0 */
  uint64_t user;     /* any value of the caller */
} swp_proxy_options;

/* The id of a is below that of b. */
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

typedef struct swp_ray_hit {
  swp_proxy proxy;
  float distance;    /* the t at which the ray enters the box; 0 if it starts inside */
  uint32_t reserved; /* 0 */
} swp_ray_hit;

typedef struct swp_proxies_options {
  uint32_t struct_size;
  uint32_t pair_events;         /* 1: fills swp_proxies_added and _removed */
  uint32_t sorted_pairs;        /* 1: ascending pairs, whatever the backend; implied by events */
  uint32_t thread_count;        /* as in swp_world_options */
  const swp_executor* executor; /* as in swp_world_options */
} swp_proxies_options;

SWP_API swp_result swp_proxies_options_init(swp_proxies_options* options);
/* `options` NULL takes the defaults. */
SWP_API swp_result swp_proxies_create(const swp_proxies_options* options, swp_proxies** proxies);
SWP_API void swp_proxies_destroy(swp_proxies* proxies);

/* `options` NULL makes a moving proxy with category 1, all bits in its mask and user 0. */
SWP_API swp_result swp_proxies_add(swp_proxies* proxies, const swp_aabb* box,
                                   const swp_proxy_options* options, swp_proxy* proxy);
SWP_API swp_result swp_proxies_remove(swp_proxies* proxies, swp_proxy proxy);
/* Gives boxes[k] to moved[k]. If one handle is SWP_NOT_FOUND, no proxy is moved. */
SWP_API swp_result swp_proxies_move(swp_proxies* proxies, const swp_proxy* moved,
                                    const swp_aabb* boxes, uint32_t count);
SWP_API swp_result swp_proxies_set_filter(swp_proxies* proxies, swp_proxy proxy,
                                          const swp_filter* filter);
SWP_API swp_result swp_proxies_set_user(swp_proxies* proxies, swp_proxy proxy, uint64_t user);
/* Either output may be NULL. */
SWP_API swp_result swp_proxies_get(const swp_proxies* proxies, swp_proxy proxy, swp_aabb* box,
                                   swp_proxy_options* options);
/* Gives the handle of the proxy that has this id now. */
SWP_API swp_result swp_proxies_handle(const swp_proxies* proxies, uint32_t id, swp_proxy* proxy);
/* The numbers of living proxies, and the bytes held. Each output may be NULL. */
SWP_API swp_result swp_proxies_counts(const swp_proxies* proxies, uint32_t* moving_count,
                                      uint32_t* static_count, uint64_t* native_bytes);

/* The boxes to give to a world or a session, valid until the next add. A free place holds an
 * invalid box, which overlaps nothing. */
SWP_API swp_result swp_proxies_moving_boxes(const swp_proxies* proxies, const swp_aabb** boxes,
                                            uint32_t* count);
/* To be called once per frame with all pairs that were found in those boxes. Gives the pairs of ids
 * that pass the filters, including those with static proxies, by the rules of buffers of
 * swp_world_find_pairs; if the room was too small, swp_proxies_copy_pairs gives them.
 * SWP_INVALID_ARGUMENT for a pair that is not of those boxes. */
SWP_API swp_result swp_proxies_resolve(swp_proxies* proxies, const swp_pair* moving_pairs,
                                       uint64_t moving_pair_count, swp_pair* pairs,
                                       uint64_t capacity, uint64_t* pair_count);
/* Gives the pairs of the latest resolve again. */
SWP_API swp_result swp_proxies_copy_pairs(const swp_proxies* proxies, swp_pair* pairs,
                                          uint64_t capacity, uint64_t* pair_count);
/* The pairs that began and ended between the latest two resolves, in ascending order, by the rules
 * of buffers of swp_world_find_pairs; none without pair_events. Pairs of a removed proxy have
 * ended. */
SWP_API swp_result swp_proxies_added(const swp_proxies* proxies, swp_proxy_pair* added,
                                     uint64_t capacity, uint64_t* count);
SWP_API swp_result swp_proxies_removed(const swp_proxies* proxies, swp_proxy_pair* removed,
                                       uint64_t capacity, uint64_t* count);

/* Queries over the current moving and static proxies whose filter and the query's filter pass. The
 * rules of buffers are as above; a second call with more room searches again. */

/* Gives all proxies that overlap the box, by ascending index. */
SWP_API swp_result swp_proxies_query_box(swp_proxies* proxies, const swp_aabb* box,
                                         const swp_filter* filter, swp_proxy* found,
                                         uint64_t capacity, uint64_t* count);
/* Gives all hits by ascending distance, at equal distance by index. SWP_INVALID_ARGUMENT for a ray
 * that is not finite or has a negative max_distance. */
SWP_API swp_result swp_proxies_cast_ray(swp_proxies* proxies, const swp_ray* ray,
                                        const swp_filter* filter, swp_ray_hit* hits,
                                        uint64_t capacity, uint64_t* count);
/* Gives the nearest hit. If there is none, `found` is 0 and `hit` is unchanged. */
SWP_API swp_result swp_proxies_cast_ray_nearest(swp_proxies* proxies, const swp_ray* ray,
                                                const swp_filter* filter, swp_ray_hit* hit,
                                                uint32_t* found);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_PROXIES_H_ */
