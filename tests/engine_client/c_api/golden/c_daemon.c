/* c_daemon.h as it is in ABI 3. Written by abi_test.py, which says what may change. */
#include "tests/engine_client/c_api/abi.h"

/* clang-format off */
HANDLE(swp_daemon)
SIZE(swp_daemon_options, 72)
FIELD(swp_daemon_options, struct_size, 0, uint32_t)
FIELD(swp_daemon_options, tls, 4, uint32_t)
FIELD(swp_daemon_options, ca_file, 8, const char*)
FIELD(swp_daemon_options, cert_file, 16, const char*)
FIELD(swp_daemon_options, key_file, 24, const char*)
FIELD(swp_daemon_options, server_name, 32, const char*)
FIELD(swp_daemon_options, address, 40, const char*)
FIELD(swp_daemon_options, token, 48, const char*)
FIELD(swp_daemon_options, token_file, 56, const char*)
FIELD(swp_daemon_options, link, 64, const swp_link_options*)
FUNCTION(swp_session_connect, swp_result (*)(swp_session*, const swp_daemon_options*, swp_daemon**))
FUNCTION(swp_daemon_link, swp_link* (*)(const swp_daemon*))
FUNCTION(swp_daemon_destroy, void (*)(swp_daemon*, uint32_t))
