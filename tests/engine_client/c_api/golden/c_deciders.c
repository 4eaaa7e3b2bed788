/* c_deciders.h as it is in ABI 3. Written by abi_test.py, which says what may change. */
#include "tests/engine_client/c_api/abi.h"

/* clang-format off */
SIZE(swp_decider_options, 64)
FIELD(swp_decider_options, struct_size, 0, uint32_t)
FIELD(swp_decider_options, reserved, 4, uint32_t)
FIELD(swp_decider_options, policy, 8, const char*)
FIELD(swp_decider_options, project, 16, const char*)
FIELD(swp_decider_options, scene, 24, const char*)
FIELD(swp_decider_options, machine_class, 32, const char*)
FIELD(swp_decider_options, priors_file, 40, const char*)
FIELD(swp_decider_options, seed, 48, uint64_t)
FIELD(swp_decider_options, time_scale, 56, double)
SIZE(swp_belief, 16)
FIELD(swp_belief, alpha, 0, double)
FIELD(swp_belief, beta, 8, double)
FUNCTION(swp_decider_options_init, swp_result (*)(swp_decider_options*))
FUNCTION(swp_session_attach_decider, swp_result (*)(swp_session*, const swp_decider_options*, uint64_t))
FUNCTION(swp_session_detach_decider, swp_result (*)(swp_session*))
FUNCTION(swp_session_poll_decider, swp_result (*)(swp_session*, uint64_t, swp_switch_command*, uint32_t*))
FUNCTION(swp_session_beliefs, swp_result (*)(const swp_session*, swp_belief*, uint32_t, uint32_t*))
FUNCTION(swp_session_decision_count, swp_result (*)(const swp_session*, uint64_t*))
FUNCTION(swp_session_prior_source_count, swp_result (*)(const swp_session*, uint64_t*))
