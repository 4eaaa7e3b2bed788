/* The part of the C ABI for scenes: moving boxes to try a broad phase on. c_api.h includes this
 * header and has the rules for threads, ownership, units and results. The functions mirror
 * sweepstake/scene.h.
 *
 * Threads: a scene has one caller at a time; while no call runs, any number of threads may read its
 * boxes. Cost: a step is O(objects); the boxes are not copied. */
/* Included before the guard, so that c_api.h includes its headers in the order of their
 * dependencies. */
#include "sweepstake/c_api.h"

#ifndef SWEEPSTAKE_C_SCENES_H_
#define SWEEPSTAKE_C_SCENES_H_

#include <stdint.h>

#ifdef __cplusplus
extern "C" {
#endif

/* NOLINTBEGIN(modernize-use-using): C has none. */

typedef struct swp_scene swp_scene;

/* The same as SceneOptions in sweepstake/scene.h. Call swp_scene_options_init, then change members.
 */
typedef struct swp_scene_options {
  uint32_t struct_size;
  uint32_t object_count;
  uint64_t spawn_seed;
  uint64_t motion_seed;
  float world_half_extent;
  float fixed_step_s;
  float half_extent_min;
  float half_extent_max;
  float speed;
  float gravity;
  float direction_interval_s;
  uint32_t reserved; /* 0 */
} swp_scene_options;

/* The number of scenes, and the name of each. Names stay valid. The name is NULL if `index` is
 * swp_scene_count() or more. Any thread, at any time. */
SWP_API uint32_t swp_scene_count(void);
SWP_API const char* swp_scene_name(uint32_t index);

/* Sets the defaults, which scene.h documents. */
SWP_API swp_result swp_scene_options_init(swp_scene_options* options);

/* Makes a scene. `scene` is one of swp_scene_name() or the path of a .aabbs file. `options` NULL
 * uses the defaults. SWP_NOT_FOUND if there is no such scene; the message lists the names.
 * SWP_DATA_LOSS if the file is broken; the message says where. */
SWP_API swp_result swp_scene_create(const char* scene, const swp_scene_options* options,
                                    swp_scene** out);
SWP_API void swp_scene_destroy(swp_scene* scene);

/* Advances the scene by one fixed step. */
SWP_API swp_result swp_scene_step(swp_scene* scene);

/* The boxes of this frame, valid until the next step. */
SWP_API swp_result swp_scene_boxes(const swp_scene* scene, const swp_aabb** boxes, uint32_t* count);
/* The bounds of the motion; boxes may extend beyond them by their size. */
SWP_API swp_result swp_scene_world(const swp_scene* scene, swp_aabb* world);
/* The number of steps taken. */
SWP_API swp_result swp_scene_frame_index(const swp_scene* scene, uint64_t* frame_index);
/* FNV-1a, 64 bits, over the bytes of this frame's boxes in little-endian order. The same seed and
 * step give the same hash on every platform. */
SWP_API swp_result swp_scene_hash(const swp_scene* scene, uint64_t* hash);

/* NOLINTEND(modernize-use-using) */

#ifdef __cplusplus
}
#endif

#endif /* SWEEPSTAKE_C_SCENES_H_ */
