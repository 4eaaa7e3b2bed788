// The mark in a watcher's stream after the complete initial state.
#include <memory>
#include <string>
#include <type_traits>
#include <vector>

#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/sessions.grpc.pb.h"
#include "tests/server/rpc/rpc_test_fixture.h"

namespace sweepstake::rpc {
namespace {

using AllToldTest = RpcTest;

// Reads a stream up to its mark. Returns the number of rows before it, and sets `mark` to the
// response with the mark.
template <typename Reader, typename Response>
int CountToMark(Reader& reader, Response& mark, int (*count)(const Response&)) {
  int told = 0;
  while (reader.Read(&mark) && !mark.all_told()) told += count(mark);
  EXPECT_TRUE(mark.all_told());
  EXPECT_GT(mark.stamp().sequence(), 0u);
  return told;
}

TEST_F(AllToldTest, ComesAfterTheLastScene) {
  const auto stub = v1::PosteriorsService::NewStub(channel_);
  v1::WatchPosteriorsRequest request;
  request.set_mark_all_told(true);
  for (const int count : {0, 1, 100, 130}) {
    std::vector<priors::PriorRecord> records(static_cast<size_t>(count), LearntInHours());
    for (int i = 0; i < count; ++i) records[static_cast<size_t>(i)].key.scene = std::to_string(i);
    Put(records);
    grpc::ClientContext context;
    const auto watcher = stub->WatchPosteriors(&context, request);
    v1::WatchPosteriorsResponse mark;
    const int told =
        CountToMark<std::remove_reference_t<decltype(*watcher)>, v1::WatchPosteriorsResponse>(
            *watcher, mark, [](const auto& event) { return event.has_posterior() ? 1 : 0; });
    EXPECT_EQ(told, count);
    EXPECT_FALSE(mark.has_posterior());
    context.TryCancel();
    // The next records are written without the server. The next watcher must therefore not receive
    // the state that was read for this one.
    ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 0; }));
  }
}

TEST_F(AllToldTest, ComesAfterTheLastSession) {
  options_.max_streams_per_connection = 1'000;
  RestartServer();
  const auto stub = v1::SessionsService::NewStub(channel_);
  v1::WatchSessionsRequest request;
  request.set_mark_all_told(true);
  std::vector<std::unique_ptr<TelemetryClient>> clients;
  for (const size_t count : {size_t{0}, size_t{100}, size_t{101}}) {
    while (clients.size() < count) {
      clients.push_back(std::make_unique<TelemetryClient>(channel_));
      clients.back()->Open(HelloMessage());
    }
    grpc::ClientContext context;
    const auto watcher = stub->WatchSessions(&context, request);
    v1::WatchSessionsResponse mark;
    const int told =
        CountToMark<std::remove_reference_t<decltype(*watcher)>, v1::WatchSessionsResponse>(
            *watcher, mark, [](const auto& event) { return event.sessions_size(); });
    EXPECT_EQ(told, static_cast<int>(count));
    EXPECT_TRUE(mark.sessions().empty());
    context.TryCancel();
    // The bus publishes the next session at its next tick, so that a watcher that joins this one
    // would receive the mark before it.
    ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 0; }));
  }
}

TEST_F(AllToldTest, IsSentOnlyOnRequest) {
  const auto stub = v1::PosteriorsService::NewStub(channel_);
  grpc::ClientContext context;
  const auto watcher = stub->WatchPosteriors(&context, {});
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 1; }));
  TelemetryClient client(channel_);
  LearnOneWindow(client, OneArmHello());
  clock_.Advance(events::EventBus::kIntervalNs);
  v1::WatchPosteriorsResponse event;
  ASSERT_TRUE(watcher->Read(&event));
  EXPECT_FALSE(event.all_told());
  context.TryCancel();
}

}  // namespace
}  // namespace sweepstake::rpc
