/* The macros of the files in golden/: the compiler checks each of their lines, on every platform
 * that builds the tests. */
#ifndef SWEEPSTAKE_TESTS_C_API_ABI_H_
#define SWEEPSTAKE_TESTS_C_API_ABI_H_

#include <stddef.h>

#include "sweepstake/c_api.h"
#include "sweepstake/c_daemon.h"

#define ABI_CHANGED "the C ABI is not as it was: run abi_test.py, which says what to do"

#define SIZE(type, bytes) _Static_assert(sizeof(type) == (bytes), ABI_CHANGED);
#define FIELD(type, field, offset, ...)                                                      \
  _Static_assert(                                                                            \
      offsetof(type, field) == (offset) && sizeof(((type*)0)->field) == sizeof(__VA_ARGS__), \
      ABI_CHANGED);
#define VALUE(name, value) _Static_assert((name) == (value), ABI_CHANGED);
#define HANDLE(type) _Static_assert(sizeof(type*) == 8, ABI_CHANGED);
#define ALIAS(type, ...) \
  _Static_assert(_Generic((type*)0, __VA_ARGS__ * : 1, default : 0), ABI_CHANGED);
#define CALLBACK(type, ...) \
  _Static_assert(_Generic((type)0, __VA_ARGS__ : 1, default : 0), ABI_CHANGED);
#define FUNCTION(name, ...) \
  _Static_assert(_Generic(&(name), __VA_ARGS__ : 1, default : 0), ABI_CHANGED);

#endif
