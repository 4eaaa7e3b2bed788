// A watcher first receives every scene or session, for numbers below and above one page.
#include <memory>
#include <string>
#include <vector>

#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using InitialStateTest = RpcTest;

TEST_F(InitialStateTest, HasEveryScene) {
  const auto stub = v1::PosteriorsService::NewStub(channel_);
  for (const int count : {1, 100, 130}) {
    std::vector<priors::PriorRecord> records(static_cast<size_t>(count), LearntInHours());
    for (int i = 0; i < count; ++i) records[static_cast<size_t>(i)].key.scene = std::to_string(i);
    Put(records);
    grpc::ClientContext context;
    const auto watcher = stub->WatchPosteriors(&context, {});
    v1::WatchPosteriorsResponse event;
    for (int i = 0; i < count; ++i) {
      ASSERT_TRUE(watcher->Read(&event));
      EXPECT_TRUE(event.has_posterior());
      EXPECT_GT(event.stamp().sequence(), 0u);
    }
    context.TryCancel();
    // The next records are written without the server. The next watcher must therefore not receive
    // the state that was read for this watcher.
    ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 0; }));
  }
}

TEST_F(InitialStateTest, HasEverySession) {
  options_.max_streams_per_connection = 1'000;
  RestartServer();
  const auto stub = v1::SessionsService::NewStub(channel_);
  std::vector<std::unique_ptr<TelemetryClient>> clients;
  for (const size_t count : {size_t{1}, size_t{100}, size_t{101}}) {
    while (clients.size() < count) {
      clients.push_back(std::make_unique<TelemetryClient>(channel_));
      clients.back()->Open(HelloMessage());
    }
    grpc::ClientContext context;
    const auto watcher = stub->WatchSessions(&context, {});
    v1::WatchSessionsResponse event;
    for (size_t received = 0; received < count;) {
      ASSERT_TRUE(watcher->Read(&event));
      received += static_cast<size_t>(event.sessions_size());
      EXPECT_LE(received, count);
    }
    context.TryCancel();
    // A watcher that joins this watcher would not read the sessions again.
    ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 0; }));
  }
}

}  // namespace
}  // namespace sweepstake::rpc
