/* c_hooks.h as it is in ABI 3. Written by abi_test.py, which says what may change. */
#include "tests/engine_client/c_api/abi.h"

/* clang-format off */
SIZE(swp_hooks, 64)
FIELD(swp_hooks, struct_size, 0, uint32_t)
FIELD(swp_hooks, reserved, 4, uint32_t)
FIELD(swp_hooks, user, 8, void*)
FIELD(swp_hooks, allocate, 16, void* (*)(uint64_t, uint64_t, void*))
FIELD(swp_hooks, release, 24, void (*)(void*, uint64_t, uint64_t, void*))
FIELD(swp_hooks, zone_begin, 32, void (*)(const char*, void*))
FIELD(swp_hooks, zone_end, 40, void (*)(const char*, void*))
FIELD(swp_hooks, thread_started, 48, void (*)(const char*, void*))
FIELD(swp_hooks, out_of_memory, 56, void (*)(void*))
FUNCTION(swp_hooks_init, swp_result (*)(swp_hooks*))
FUNCTION(swp_set_hooks, swp_result (*)(const swp_hooks*))
