/* A C program that loads the shared library. */
#include <stdio.h>

#include "sweepstake/c_api.h"

int main(void) {
  const swp_aabb boxes[2] = {{{0, 0, 0}, {1, 1, 1}}, {{0, 0, 0}, {2, 2, 2}}};
  swp_world* world = NULL;
  const swp_pair* pairs = NULL;
  uint64_t count = 0;
  if (swp_abi_version() != SWP_ABI_VERSION || swp_world_create("KDTree", NULL, &world) != SWP_OK ||
      swp_world_build(world, boxes, 2) != SWP_OK || swp_world_find_pairs(world) != SWP_OK ||
      swp_world_pairs(world, &pairs, &count) != SWP_OK) {
    fprintf(stderr, "%s\n", swp_last_error());
    return 1;
  }
  const int right = count == 1 && pairs[0].a == 0 && pairs[0].b == 1;
  swp_world_destroy(world);
  return right ? 0 : 1;
}
