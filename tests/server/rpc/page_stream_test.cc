// Tests when a stream of pages may be ended from outside.
#include "server/rpc/services/page_stream.h"
#include "sweepstake/v1/priors.pb.h"

#include <gtest/gtest.h>
#include <spdlog/logger.h>

#include <future>

#include "server/rpc/common/event_encoder.h"
#include "server/sessions/session_table.h"
#include "tests/server/sessions/manual_clock.h"

namespace sweepstake::rpc {
namespace {

// An overloaded store, which refuses every job and read.
class BusyStore final : public priors::AsyncPriorStore {
 public:
  void Commit(priors::SourceUpdate /*update*/, CommitCallback /*done*/) override {}
  bool Submit(Job /*job*/) override { return false; }
  bool Read(ReadJob /*job*/) override { return false; }
  bool healthy() const override { return true; }
  priors::StoreLosses losses() const override { return {}; }
};

// The services that a stream needs, without a server.
struct Services {
  // Returns when the loop has run all posted and due tasks.
  void Settle() {
    for (int i = 0; i < 2; ++i) {
      std::promise<void> reached;
      loop.Post([&] { reached.set_value(); });
      reached.get_future().wait();
    }
  }

  sessions::ManualClock clock;
  BusyStore store;
  RpcOptions options;
  Counters counters;
  spdlog::logger log{"test"};
  EventEncoder encoder;
  events::EventBus events{store, loop, sessions, encoder};
  sessions::DecisionLoop loop{clock};
  sessions::SessionTable sessions{{options, loop, store, counters, events}};
  StallSweep stalls{loop, options.watcher_patience_ns};
  AccessControl access{options, clock, log};
  sessions::AdminLog admin{options, loop, store, counters};
  alerts::AlertMonitor alerts{options.alerts, loop, sessions};
  ServiceContext context{options, loop,   store, counters, events, sessions,
                         stalls,  access, log,   admin,    alerts};
};

// Counts the ends of a stream.
struct CountingSink final : PageSink {
  void Write(const std::shared_ptr<const google::protobuf::Message>& /*response*/) override {}
  void Finish(const absl::Status& /*status*/) override { ++finish_count; }
  void Cancel(const absl::Status& /*status*/) override { ++cancel_count; }

  int finish_count = 0;
  int cancel_count = 0;
};

TEST(PageStreamTest, AFinishedStreamIsNotEndedAgainBeforeTheLoopProcessesItsEnd) {
  Services services;
  CountingSink sink;
  const auto stream = std::make_shared<PageStream>(
      services.context, Caller(), [](priors::PriorReader&) { return StreamPage{}; }, sink);
  services.loop.Post([&] { stream->Begin(); });
  services.Settle();
  EXPECT_EQ(sink.finish_count, 1);
  services.clock.Advance(2 * services.options.watcher_patience_ns);
  services.Settle();
  EXPECT_EQ(sink.finish_count, 1);
  EXPECT_EQ(sink.cancel_count, 0);
}

}  // namespace
}  // namespace sweepstake::rpc
