// Tests a system that starts no more threads. The test replaces pthread_create for the whole
// program.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <cstring>
#include <thread>

#include "sweepstake/c_api.h"
#include "tests/support/sanitizers/active.h"

// ThreadSanitizer intercepts pthread_create, too, and needs its real caller.
#if !SWEEPSTAKE_TSAN

namespace {

std::atomic<bool> has_threads = true;

}  // namespace

extern "C" __attribute__((visibility("default"))) int pthread_create(
    pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
    void* argument) noexcept {
  if (!has_threads) return EAGAIN;
  void* const next = dlsym(RTLD_NEXT, "pthread_create");
  if (next == nullptr) std::abort();
  return reinterpret_cast<decltype(&pthread_create)>(next)(thread, attributes, start, argument);
}

namespace {

class ThreadLimitTest : public testing::Test {
 protected:
  ThreadLimitTest() {
    options_.struct_size = sizeof options_;
    EXPECT_EQ(swp_session_options_init(&options_), SWP_OK);
    has_threads = false;
  }
  ~ThreadLimitTest() override { has_threads = true; }

  void ExpectRefused(const char* advice) {
    const uint32_t before = swp_live_count(SWP_KIND_ANY);
    swp_session* session = nullptr;
    EXPECT_EQ(swp_session_create(&options_, &session), SWP_RESOURCE_EXHAUSTED);
    EXPECT_NE(std::strstr(swp_last_error(), advice), nullptr) << swp_last_error();
    EXPECT_EQ(session, nullptr);
    EXPECT_EQ(swp_live_count(SWP_KIND_ANY), before);
  }
  void ExpectMadeWithThreads() {
    has_threads = true;
    swp_session* session = nullptr;
    EXPECT_EQ(swp_session_create(&options_, &session), SWP_OK);
    swp_session_destroy(session);
  }

  swp_session_options options_{};
};

TEST_F(ThreadLimitTest, ASessionIsRefusedIfItsPoolCannotStart) {
  options_.thread_count = 2;
  ExpectRefused("use a lower thread_count");
  ExpectMadeWithThreads();
}

TEST_F(ThreadLimitTest, ASessionIsRefusedIfItsLaneCannotStart) {
  if (std::thread::hardware_concurrency() < 2) GTEST_SKIP() << "a lane needs a spare core";
  options_.shadow = SWP_SHADOW_ON;
  ExpectRefused("turn the lane off");
  ExpectMadeWithThreads();
}

}  // namespace

#endif
