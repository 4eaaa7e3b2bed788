// The sanitizers with which a file is compiled, as macros with the value 0 or 1. GCC and Clang name
// them differently.
#pragma once

#if defined(__has_feature)
#define SWEEPSTAKE_HAS_FEATURE(feature) __has_feature(feature)
#else
#define SWEEPSTAKE_HAS_FEATURE(feature) 0
#endif

#if defined(__SANITIZE_ADDRESS__) || SWEEPSTAKE_HAS_FEATURE(address_sanitizer)
#define SWEEPSTAKE_ASAN 1
#else
#define SWEEPSTAKE_ASAN 0
#endif

#if defined(__SANITIZE_THREAD__) || SWEEPSTAKE_HAS_FEATURE(thread_sanitizer)
#define SWEEPSTAKE_TSAN 1
#else
#define SWEEPSTAKE_TSAN 0
#endif
