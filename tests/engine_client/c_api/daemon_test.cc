// Tests a game in C against a daemon that each test scripts: what arrives, who may be destroyed
// first, and what the frame thread does not do. Tests wait for conditions, not for fixed times.
#include <dlfcn.h>
#include <gtest/gtest.h>
#include <pthread.h>
#include <sys/wait.h>
#include <unistd.h>

#include <atomic>
#include <cerrno>
#include <cstdlib>
#include <string>
#include <thread>

extern "C" {
#include "tests/engine_client/c_api/check.h"
}

#include "tests/engine_client/c_api/daemon_game.h"
#include "tests/support/fake_daemon.h"
#include "tests/support/sanitizers/active.h"
#include "tests/support/wait_counter.h"

int failure_count = 0;

// The same as in thread_limit_test.cc, which is another program. ThreadSanitizer intercepts
// pthread_create, too, and needs its real caller.
#if !SWEEPSTAKE_TSAN

static std::atomic<bool> has_threads = true;

extern "C" __attribute__((visibility("default"))) int pthread_create(
    pthread_t* thread, const pthread_attr_t* attributes, void* (*start)(void*),
    void* argument) noexcept {
  if (!has_threads) return EAGAIN;
  void* const next = dlsym(RTLD_NEXT, "pthread_create");
  if (next == nullptr) std::abort();
  return reinterpret_cast<decltype(&pthread_create)>(next)(thread, attributes, start, argument);
}

#endif

namespace sweepstake {
namespace {

using test_support::FakeDaemon;
using test_support::WaitCounter;

TEST(DaemonTest, ItsArgumentsAreChecked) {
  test_daemon();
  EXPECT_EQ(failure_count, 0);
}

class DaemonGameTest : public ::testing::Test {
 protected:
  void SetUp() override {
    fake_.Start();
    address_ = fake_.address();
    swp_daemon_options options = {};
    options.struct_size = sizeof options;
    options.address = address_.c_str();
    ASSERT_EQ(daemon_game_start(&game_, &options), SWP_OK) << swp_last_error();
    while (daemon_game_stats(&game_).state != SWP_LINK_ONLINE) std::this_thread::yield();
  }

  void TearDown() override { daemon_game_end(&game_, 0); }

  void RunFrames(int count) {
    for (int i = 0; i < count; ++i) daemon_game_frame(&game_);
  }
  // Waits until the daemon has lost the stream.
  void WaitForTheEndOfTheStream() {
    fake_.WaitUntil([](const FakeDaemon& daemon) { return daemon.open_stream_count == 0; });
  }
  uint64_t ArrivedFrameCount() {
    uint64_t count = 0;
    for (const v1::StreamTelemetryRequest& message : fake_.Evidence())
      count += static_cast<uint64_t>(message.frame_batch().frame_time_ns_size());
    return count;
  }

  FakeDaemon fake_;
  std::string address_;
  daemon_game game_ = {};
};

TEST_F(DaemonGameTest, EveryFrameArrivesBeforeDestroyReturns) {
  RunFrames(1234);
  daemon_game_end(&game_, 60'000);
  EXPECT_EQ(ArrivedFrameCount(), 1234U);
  EXPECT_EQ(fake_.goodbyes.size(), 1U);
}

TEST_F(DaemonGameTest, TheFrameThreadDoesNotBlock) {
  RunFrames(10);
  const WaitCounter waits;
  RunFrames(2000);
  EXPECT_EQ(waits.count(), 0U) << waits.last_call();
}

TEST_F(DaemonGameTest, ASilentDaemonDoesNotHoldBackTheEnd) {
  fake_.SetScript([](FakeDaemon::Script& script) { script.acknowledges = false; });
  RunFrames(100);
  daemon_game_end(&game_, 0);
  WaitForTheEndOfTheStream();
}

TEST_F(DaemonGameTest, TheSessionMayBeDestroyedFirst) {
  RunFrames(100);
  swp_session_destroy(game_.session);
  game_.session = nullptr;
  WaitForTheEndOfTheStream();
  swp_link_stats stats = {};
  stats.struct_size = sizeof stats;
  EXPECT_EQ(swp_link_status(swp_daemon_link(game_.daemon), &stats), SWP_FAILED_PRECONDITION);
  daemon_game_end(&game_, 60'000);
  EXPECT_TRUE(fake_.goodbyes.empty());
}

TEST_F(DaemonGameTest, AHostThatLostItsHandlesEndsTheConnection) {
  RunFrames(100);
  ASSERT_EQ(swp_shutdown_all(60'000), SWP_OK);
  WaitForTheEndOfTheStream();
  daemon_game_end(&game_, 60'000);
  EXPECT_EQ(swp_live_count(SWP_KIND_ANY), 0U);
}

TEST_F(DaemonGameTest, TheErrorOfABrokenStreamNamesTheAddress) {
  const int port = fake_.port();
  fake_.Kill();
  while (daemon_game_stats(&game_).state == SWP_LINK_ONLINE) daemon_game_frame(&game_);
  EXPECT_NE(std::string(daemon_game_text(&game_, SWP_LINK_LAST_ERROR)).find(address_),
            std::string::npos);
  fake_.Start(port);
  while (daemon_game_stats(&game_).resumed_count == 0) daemon_game_frame(&game_);
}

TEST_F(DaemonGameTest, AForkedChildMayDestroyItsCopies) {
  const pid_t child = fork();
  if (child == 0) {
    daemon_game_end(&game_, 60'000);
    _exit(0);
  }
  int status = -1;
  EXPECT_EQ(waitpid(child, &status, 0), child);
  EXPECT_EQ(status, 0);
  RunFrames(100);
  daemon_game_end(&game_, 60'000);
  EXPECT_EQ(ArrivedFrameCount(), 100U);
}

#if !SWEEPSTAKE_TSAN
TEST_F(DaemonGameTest, ASystemWithoutThreadsIsAnError) {
  swp_session* session = nullptr;
  swp_daemon* daemon = nullptr;
  ASSERT_EQ(swp_session_create(nullptr, &session), SWP_OK);
  swp_daemon_options options = {};
  options.struct_size = sizeof options;
  options.address = address_.c_str();
  has_threads = false;
  EXPECT_EQ(swp_session_connect(session, &options, &daemon), SWP_RESOURCE_EXHAUSTED);
  has_threads = true;
  EXPECT_NE(std::string(swp_last_error()).find("cannot start a thread"), std::string::npos);
  EXPECT_EQ(daemon, nullptr);
  EXPECT_EQ(swp_live_count(SWP_KIND_LINK), 1U) << "the first game's link";
  swp_session_destroy(session);
}
#endif

TEST_F(DaemonGameTest, ARefusalHasTheDaemonsReason) {
  fake_.SetScript([](FakeDaemon::Script& script) {
    script.refusal = grpc::Status(grpc::StatusCode::INVALID_ARGUMENT, "no such policy");
  });
  const int port = fake_.port();
  fake_.Kill();
  fake_.Start(port);
  while (*daemon_game_text(&game_, SWP_LINK_REFUSAL) == '\0') std::this_thread::yield();
  EXPECT_STREQ(daemon_game_text(&game_, SWP_LINK_REFUSAL), "no such policy");
}

}  // namespace
}  // namespace sweepstake
