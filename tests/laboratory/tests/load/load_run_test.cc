// Tests that the counts of the load generator equal the counts of the daemon.
#include "tests/laboratory/load/load_run.h"
#include "server/storage/sqlite_prior_store.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <spdlog/logger.h>

#include <atomic>
#include <chrono>
#include <future>
#include <memory>
#include <string>
#include <thread>

#include "engine_client/cli/daemon/daemon_calls.h"
#include "server/rpc/rpc_server.h"
#include "server/storage/store_thread.h"
#include "tests/server/rpc/holding_store.h"

namespace sweepstake::cli {
namespace {

using rpc::RpcServer;

class LoadRunTest : public ::testing::Test {
 protected:
  void SetUp() override { Start("127.0.0.1:0"); }
  void TearDown() override { Stop(); }

  void Start(const std::string& listen) {
    thread_ = std::make_unique<storage::StoreThread>(*storage::OpenMemoryPriorStore());
    store_ = std::make_unique<rpc::HoldingStore>(*thread_);
    auto server = RpcServer::Start(listen, {}, clock_, *store_, log_);
    ASSERT_TRUE(server.ok()) << server.status();
    server_ = *std::move(server);
    plan_.daemon.address = "127.0.0.1:" + std::to_string(server_->port());
  }
  void Stop() {
    server_->Drain(std::chrono::seconds(2));
    thread_->Close();
    server_.reset();
  }
  Result<LoadResult> Run(
      const std::function<bool()>& stop = [] { return false; },
      const std::function<void(const std::string&)>& progress = [](const std::string&) {}) {
    return RunLoad(plan_, stop, progress);
  }
  void AwaitStreams() {
    const auto deadline = std::chrono::steady_clock::now() + std::chrono::seconds(60);
    while (server_->counters().connected_stream_count < plan_.stream_count) {
      ASSERT_LT(std::chrono::steady_clock::now(), deadline);
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
    }
  }

  sessions::SteadyLoopClock clock_;
  spdlog::logger log_{"test"};
  std::unique_ptr<storage::StoreThread> thread_;
  std::unique_ptr<rpc::HoldingStore> store_;
  std::unique_ptr<RpcServer> server_;
  LoadPlan plan_{.daemon = {},
                 .stream_count = 50,
                 .scene_count = 4,
                 .batches_per_second = 10,
                 .batch_frames = 30,
                 .duration_ns = 120'000'000'000,
                 .bail_out_share = 0.1};
};

TEST_F(LoadRunTest, TheDaemonHasReceivedExactlyWhatWasSent) {
  // Four commits per stream mean that every stream has had at least two ticks and has received the
  // acknowledgements of the first tick.
  const auto result =
      Run([&] { return server_->counters().stored_commit_count >= 4 * plan_.stream_count; });
  ASSERT_TRUE(result.ok()) << result.status().message();
  const rpc::Counters& counters = server_->counters();
  EXPECT_EQ(counters.connected_stream_count, 50U);
  EXPECT_EQ(counters.goodbye_count, 50U);
  EXPECT_EQ(result->finished_count, 50U);
  EXPECT_EQ(result->welcome_count, 50U);
  EXPECT_EQ(result->hello_latency_ms.size(), 50U);
  EXPECT_EQ(result->rejected_count, 0U);
  EXPECT_EQ(counters.accepted_frame_count, 30 * result->batch_count);
  EXPECT_EQ(counters.applied_message_count,
            result->batch_count + result->bail_out_count + result->switch_count);
  EXPECT_EQ(counters.invalid_message_count, 0U);
  // At most ten batches per second and stream; fewer if the machine is too slow.
  EXPECT_LE(result->measured_batch_count, result->tick_lateness_ms.size());
  EXPECT_GT(result->measured_batch_count, 0U);
  EXPECT_LE(static_cast<double>(result->measured_batch_count), 500 * (result->measured_s + 1));
  EXPECT_GT(result->bail_out_count, 0U);
  EXPECT_GT(result->acknowledged_count, 0U);
  EXPECT_LE(result->acknowledged_count, counters.applied_message_count);
  EXPECT_TRUE(result->shortfall.ok()) << result->shortfall.message();
  EXPECT_FALSE(result->decision_latency_ms.empty());
  EXPECT_FALSE(result->commit_lag_ms.empty());
  EXPECT_LE(result->commit_lag_ms.size(), result->measured_batch_count + 50);
  EXPECT_FALSE(result->reconnect_s);
}

TEST_F(LoadRunTest, WhatTheLastCommitBringsIsWaitedFor) {
  plan_.bail_out_share = 0;
  plan_.commit_patience_ns = 60'000'000'000;
  // The store holds back all commits, and thus all acknowledgements, until the end of the
  // measurement.
  store_->Hold();
  const auto result = Run([&] {
    const bool ends = server_->counters().accepted_frame_count >= 30U * 100;
    if (ends) store_->Release();
    return ends;
  });
  ASSERT_TRUE(result.ok()) << result.status().message();
  EXPECT_GT(result->measured_batch_count, 0U);
  EXPECT_GE(result->acknowledged_count, result->measured_batch_count);
}

TEST_F(LoadRunTest, StreamsComeBackToARestartedDaemon) {
  std::atomic<bool> restarted{false};
  bool stop = false;  // used only by the run
  auto result = std::async(std::launch::async, [&] {
    return Run([&] { return stop; },
               [&](const std::string& text) { stop = restarted && text.starts_with("50 of 50"); });
  });
  AwaitStreams();
  const int port = server_->port();
  Stop();
  Start("127.0.0.1:" + std::to_string(port));
  AwaitStreams();
  restarted = true;
  const auto ended = result.get();
  ASSERT_TRUE(ended.ok()) << ended.status().message();
  ASSERT_TRUE(ended->reconnect_s);
  EXPECT_GT(*ended->reconnect_s, 0.5);
  EXPECT_EQ(ended->finished_count, 50U);
  EXPECT_TRUE(ended->shortfall.ok()) << ended->shortfall.message();
}

TEST_F(LoadRunTest, ADaemonThatDoesNotComeBackIsAShortfall) {
  bool stop = false;  // used only by the run
  std::atomic<bool> gone{false};
  auto result = std::async(std::launch::async, [&] {
    return Run([&] { return stop; },
               [&](const std::string& text) { stop = gone && text.starts_with("0 of 50"); });
  });
  AwaitStreams();
  Stop();
  gone = true;
  const auto ended = result.get();
  Start("127.0.0.1:0");
  ASSERT_TRUE(ended.ok()) << ended.status().message();
  EXPECT_EQ(ended->finished_count, 0U);
  EXPECT_EQ(ended->shortfall.code(), StatusCode::kUnavailable);
  EXPECT_THAT(ended->shortfall.message(), testing::StartsWith("0 of 50 games finished; the "));
}

TEST_F(LoadRunTest, AKickedGameDoesNotComeBack) {
  int progress_count = 0;  // since the kick; used only by the run
  std::atomic<bool> kicked{false};
  auto result = std::async(std::launch::async, [&] {
    // A kicked stream must not reconnect. It would do so within a second, which is the interval of
    // the progress.
    return Run([&] { return progress_count == 3; },
               [&](const std::string&) { progress_count += kicked ? 1 : 0; });
  });
  AwaitStreams();
  const auto sessions = ListSessions(plan_.daemon, plan_.project, "");
  ASSERT_TRUE(sessions.ok()) << sessions.status().message();
  EXPECT_TRUE(KickSession(plan_.daemon, sessions->front().session_id(), false).ok());
  kicked = true;
  const auto ended = result.get();
  ASSERT_TRUE(ended.ok()) << ended.status().message();
  EXPECT_EQ(ended->rejected_count, 1U) << "it has tried once";
  EXPECT_EQ(ended->welcome_count, 50U);
  EXPECT_EQ(ended->finished_count, 49U);
  EXPECT_THAT(ended->shortfall.message(), testing::HasSubstr("(SESSION_KICKED)"));
}

TEST_F(LoadRunTest, ADaemonsProcessThatIsNotThereIsAnErrorAtOnce) {
  plan_.server_pid = 1 << 30;  // above Linux's largest process id, 4,194,304
  const Status status = Run().status();
  EXPECT_EQ(status.code(), StatusCode::kInvalidArgument);
  EXPECT_THAT(status.message(), testing::HasSubstr("--server-pid"));
}

TEST_F(LoadRunTest, NobodyThereIsAnErrorAtOnce) {
  plan_.daemon.address = "127.0.0.1:1";
  EXPECT_EQ(Run().status().code(), StatusCode::kUnavailable);
}

}  // namespace
}  // namespace sweepstake::cli
