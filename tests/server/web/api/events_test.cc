// Tests the daemon's events as server-sent events, for one watcher and for many.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <memory>
#include <string>
#include <thread>
#include <vector>

#include "server/host/descriptor_limit.h"
#include "sweepstake/v1/posteriors.grpc.pb.h"
#include "sweepstake/v1/priors.grpc.pb.h"
#include "tests/server/web/api/api_fixture.h"

namespace sweepstake::server {
namespace {

using rpc::Eventually;
using rpc::TelemetryClient;
using test_support::HttpSocket;
using ::testing::AllOf;
using ::testing::HasSubstr;
using ::testing::MatchesRegex;
using ::testing::Not;
using ::testing::StartsWith;

constexpr char kPosteriors[] = "/events/sweepstake.v1.PosteriorsService/WatchPosteriors";
constexpr char kSessions[] = "/events/sweepstake.v1.SessionsService/WatchSessions";
constexpr char kBegin[] = "event: snapshot-begin\ndata: {}\n\n";
constexpr char kEnd[] = "event: snapshot-end\ndata: {}\n\n";

size_t CountOf(const std::string& text, const std::string& part) {
  size_t count = 0;
  for (size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++count;
  return count;
}

// A watcher.
class EventReader {
 public:
  EventReader(int port, const std::string& target, const std::string& more = "",
              int receive_bytes = 0)
      : socket_(port, receive_bytes) {
    socket_.Send("GET " + target + " HTTP/1.1\r\nHost: localhost\r\n" + more + "\r\n");
  }
  std::string Until(const std::string& text) { return socket_.ReadUntil(text); }
  // Reads a snapshot, and returns it with its id.
  std::string Snapshot() {
    std::string state = Until(kBegin);
    return state += Until(kEnd);
  }
  std::string All() { return socket_.ReadAll(); }

 private:
  HttpSocket socket_;
};

// Returns the last id of the events.
std::string LastIdIn(const std::string& events) {
  const size_t start = events.rfind("id: ") + 4;
  return events.substr(start, events.find('\n', start) - start);
}

template <typename Base>
class EventsOf : public Base {
 protected:
  EventReader Watch(const std::string& target = kPosteriors, const std::string& more = "",
                    int receive_bytes = 0) {
    return {this->http_->port(), target, more, receive_bytes};
  }
  EventsOf() { this->options_.watcher_patience_ns = 3'600 * rpc::kSecondNs; }
  // Advances the event bus tick by tick until the condition is true. Each tick leaves the server
  // time for its work, so that the clock does not run ahead while the server has no processor.
  template <typename Condition>
  [[nodiscard]] bool TickUntil(Condition condition) {
    return Eventually([&] {
      this->clock_.Advance(events::EventBus::kIntervalNs);
      const auto next_tick = std::chrono::steady_clock::now() + std::chrono::milliseconds(20);
      while (!condition() && std::chrono::steady_clock::now() < next_tick)
        std::this_thread::yield();
      return condition();
    });
  }
  // Adds evidence to the scene, and returns when its events have been encoded as JSON.
  void LearnAndPublish(TelemetryClient& client, uint64_t sequence) {
    const uint64_t before = this->events_->encoded_count;
    this->Learn(client, sequence);
    ASSERT_TRUE(TickUntil([&] { return this->events_->encoded_count >= before + 2; }))
        << "a decision, and a posterior";
  }
};
using EventsTest = EventsOf<ApiTest>;
using EventTokensTest = EventsOf<ApiTokensTest>;

TEST_F(EventsTest, AWatcherSeesTheStateAndThenWhatChanges) {
  PutScene("desert");
  TelemetryClient client(channel_);
  client.Open(rpc::HelloMessage());
  EventReader watch = Watch();
  EXPECT_THAT(watch.Until("\r\n\r\n"),
              AllOf(HasSubstr("200 OK"), HasSubstr("Content-Type: text/event-stream\r\n")));
  const std::string state = watch.Snapshot();
  EXPECT_THAT(state,
              AllOf(HasSubstr("data: {\"posterior\":{\"project\":\"game\",\"scene\":\"desert\""),
                    HasSubstr("\"alpha\":9001,\"beta\":1001")));
  EXPECT_EQ(CountOf(state, "id: "), 1u) << "the id of the end";
  EXPECT_THAT(LastIdIn(state), MatchesRegex("[0-9a-f]{16}:[0-9]+"));
  Learn(client, 1);
  ASSERT_TRUE(TickUntil([&] { return events_->encoded_count >= 3; }));
  const std::string news = watch.Until("\"windowCount\":\"1\",");
  EXPECT_THAT(news, AllOf(HasSubstr("data: {\"decisions\":[{\"sessionId\""), HasSubstr("\nid: "),
                          HasSubstr("\"scene\":\"harbour\"")));
  EXPECT_EQ(LastIdIn(news).substr(0, 16), LastIdIn(state).substr(0, 16)) << "the same boot";
}

TEST_F(EventsTest, NumbersAreThoseOfGrpc) {
  PutScene("desert", 32);
  grpc::ClientContext context;
  const auto reader = v1::PosteriorsService::NewStub(channel_)->WatchPosteriors(&context, {});
  v1::WatchPosteriorsResponse expected;
  ASSERT_TRUE(reader->Read(&expected));
  context.TryCancel();
  EXPECT_THAT(Watch().Snapshot(),
              HasSubstr("data: {\"posterior\":" + JsonOf(expected.posterior()) + ","));
}

TEST_F(EventsTest, AnEmptyStateHasASnapshotToo) {
  for (const char* target : {kPosteriors, kSessions})
    EXPECT_THAT(Watch(target).Snapshot(), AllOf(HasSubstr(kBegin), HasSubstr(kEnd)));
}

TEST_F(EventsTest, TheRequestSaysWhatIsWatched) {
  PutScene("desert");
  PutScene("harbour");
  const std::string state =
      Watch(std::string(kPosteriors) + "?request=%7B%22scene%22%3A%22desert%22%7D").Snapshot();
  EXPECT_THAT(state, AllOf(HasSubstr("desert"), Not(HasSubstr("harbour"))));
}

TEST_F(EventsTest, ALaterWatcherSharesTheSubscription) {
  TelemetryClient client(channel_);
  client.Open(rpc::HelloMessage());
  EventReader first = Watch();
  first.Snapshot();
  LearnAndPublish(client, 1);
  const uint64_t encoded = events_->encoded_count;
  // The text of this request differs, but its content is the same.
  EventReader second = Watch(std::string(kPosteriors) + "?request=%7B%22project%22:%22%22%7D");
  EXPECT_THAT(second.Snapshot(),
              AllOf(HasSubstr("\"windowCount\":\"1\""), Not(HasSubstr("decisions"))));
  EXPECT_EQ(events_->open_topic_count, 1u);
  EXPECT_EQ(events_->open_watcher_count, 2u);
  EXPECT_EQ(server_->counters().open_watcher_count, 1u);
  EXPECT_EQ(events_->encoded_count, encoded) << "nothing is encoded again";
}

TEST_F(EventsTest, AWatcherThatComesBackReceivesWhatItMissed) {
  TelemetryClient client(channel_);
  client.Open(rpc::HelloMessage());
  std::string last_id;
  {
    EventReader watch = Watch();
    last_id = LastIdIn(watch.Snapshot());
  }
  ASSERT_TRUE(Eventually([&] { return events_->open_watcher_count == 0; }));
  LearnAndPublish(client, 1);
  EventReader again = Watch(kPosteriors, "Last-Event-ID: " + last_id + "\r\n");
  const std::string missed = again.Until("\"windowCount\":\"1\",");
  EXPECT_THAT(missed, AllOf(HasSubstr("decisions"), Not(HasSubstr("snapshot"))));
  LearnAndPublish(client, 2);
  EXPECT_THAT(again.Until("\"windowCount\":\"2\","), Not(HasSubstr("snapshot")));
  EventReader unknown = Watch(kPosteriors, "Last-Event-ID: 0000000000000000:7\r\n");
  EXPECT_THAT(unknown.Snapshot(), HasSubstr("\"windowCount\":\"2\""));
}

class FewKeptTest : public EventsTest {
 protected:
  FewKeptTest() { event_limits_.kept_bytes = 1; }
};

TEST_F(FewKeptTest, AWatcherThatMissedMoreThanIsKeptReceivesASnapshot) {
  TelemetryClient client(channel_);
  client.Open(rpc::HelloMessage());
  EventReader watch = Watch();
  const std::string last_id = LastIdIn(watch.Snapshot());
  LearnAndPublish(client, 1);
  EXPECT_THAT(Watch(kPosteriors, "Last-Event-ID: " + last_id + "\r\n").Snapshot(),
              HasSubstr("\"windowCount\":\"1\""));
}

TEST_F(EventsTest, ARevokedSceneLeavesThePagesOfOldAndNewWatchers) {
  PutScene("desert");
  EventReader old = Watch();
  const std::string before = old.Snapshot();
  EXPECT_THAT(before, HasSubstr("desert"));
  EventReader also_old = Watch();
  EXPECT_THAT(also_old.Snapshot(), HasSubstr("desert"));

  grpc::ClientContext context;
  v1::RevokePriorsRequest request;
  request.mutable_sources()->set_source_id(rpc::LearntInHours().source_id);
  v1::RevokePriorsResponse revoked;
  ASSERT_TRUE(v1::PriorsService::NewStub(channel_)->RevokePriors(&context, request, &revoked).ok());
  ASSERT_EQ(revoked.source_count(), 1u);
  for (EventReader* watch : {&old, &also_old})
    EXPECT_THAT(watch->Snapshot(), Not(HasSubstr("desert")));
  EXPECT_THAT(Watch().Snapshot(), Not(HasSubstr("desert")));
  EventReader again = Watch(kPosteriors, "Last-Event-ID: " + LastIdIn(before) + "\r\n");
  EXPECT_THAT(again.Snapshot(), Not(HasSubstr("desert"))) << "not only what it missed";
  EXPECT_EQ(events_->open_topic_count, 1u);
}

TEST_F(EventsTest, TheNumberOfConnectedSessionsOfASceneIsKeptUpToDate) {
  Put({rpc::LearntInHours()});
  EventReader watch = Watch();
  EXPECT_THAT(watch.Snapshot(), Not(HasSubstr("activeSessionCount")));
  const std::string one = "\"activeSessionCount\":1";
  const auto shown = [&] { return CountOf(Watch().Snapshot(), one); };  // to a new watcher
  {
    TelemetryClient client(channel_);
    client.Open(rpc::OneArmHello());
    ASSERT_TRUE(TickUntil([&] { return shown() == 1; }));
    EXPECT_THAT(watch.Until(one), Not(HasSubstr("snapshot")));
  }
  ASSERT_TRUE(TickUntil([&] { return shown() == 0; }));
}

TEST_F(EventsTest, SessionsComeAndGo) {
  TelemetryClient first(channel_);
  const std::string first_id = first.Open(rpc::HelloMessage()).session_id();
  EventReader watch = Watch(kSessions);
  EXPECT_THAT(watch.Snapshot(), HasSubstr("data: {\"sessions\":[{\"sessionId\":\"" + first_id));
  TelemetryClient second(channel_);
  const std::string second_id = second.Open(rpc::HelloMessage()).session_id();
  ASSERT_TRUE(TickUntil([&] { return events_->encoded_count >= 2; }));
  EXPECT_THAT(watch.Until(second_id), HasSubstr("\nid: "));
  first.Send(rpc::Goodbye());
  EXPECT_TRUE(first.Finish().ok());
  ASSERT_TRUE(TickUntil([&] { return events_->encoded_count >= 3; }));
  watch.Until("\"ended\":[{\"sessionId\":\"" + first_id);
  EXPECT_THAT(Watch(kSessions).Snapshot(),
              AllOf(HasSubstr(second_id), Not(HasSubstr(first_id)), HasSubstr("],\"stamp\":{")));
}

TEST_F(EventsTest, AMethodWithoutEventsIsRefusedBeforeTheStreamBegins) {
  const std::string service = "/events/sweepstake.v1.";
  EXPECT_EQ(Get(service + "PosteriorsService/ListPosteriors").status, 404);
  EXPECT_EQ(Get(service + "PriorsService/ExportPriors").status, 404);
  EXPECT_EQ(Get(service + "TelemetryService/StreamTelemetry").status, 404);
  EXPECT_EQ(Get(std::string(kPosteriors) + "?request=%7B").status, 400);
  EXPECT_EQ(Get(std::string(kPosteriors) + "?request=%").status, 400);
  EXPECT_EQ(Get(std::string(kPosteriors) + "?request=%7B%22nope%22:1%7D").status, 400);
  options_.max_watchers = 0;
  server_->Adjust(options_);
  const Answer full = Get(kPosteriors);
  EXPECT_EQ(full.status, 429);
  EXPECT_THAT(full.body, HasSubstr("TOO_MANY_WATCHERS"));
}

TEST_F(EventsTest, ADrainEndsTheStreamsWithTheReason) {
  EventReader watch = Watch();
  watch.Snapshot();
  server_->Drain(std::chrono::seconds(10));
  EXPECT_THAT(watch.All(),
              AllOf(HasSubstr("event: error\ndata: {\"error\":{\"code\":\"UNAVAILABLE\","),
                    HasSubstr("\"message\":\"the daemon is draining; watch again later\""),
                    ::testing::EndsWith("0\r\n\r\n")));
}

// The buffers of a connection are bounded, so a watcher that does not read falls behind.
class SlowReaderTest : public EventsTest {
 protected:
  static constexpr int kScenes = 100;
  SlowReaderTest() { event_limits_.moment = std::chrono::milliseconds(0); }
  // Publishes all scenes again as a snapshot, some 600 kB of JSON.
  void PublishAllScenes() {
    const auto stub = v1::PriorsService::NewStub(channel_);
    grpc::ClientContext context;
    v1::ImportPriorsResponse response;
    const auto writer = stub->ImportPriors(&context, &response);
    v1::ImportPriorsRequest request;
    request.set_promote(true);
    v1::PriorRecord& record = *request.add_records();
    record.set_project("game");
    record.set_scene("again");
    record.set_arm("Grid");
    record.set_backend_version(1);
    record.set_reward_version(1);
    record.set_source_id("elsewhere");
    record.set_source_sequence(++sequence_);
    record.set_alpha_increment(static_cast<double>(sequence_));
    writer->Write(request);
    writer->WritesDone();
    EXPECT_TRUE(writer->Finish().ok());
  }

  uint64_t sequence_ = 0;
};

TEST_F(SlowReaderTest, ASlowWatcherReceivesASnapshotInPlaceOfWhatItMissed) {
  for (int i = 0; i < kScenes; ++i) PutScene("scene " + std::to_string(i), 32);
  EventReader slow = Watch(kPosteriors, "", 4096);
  slow.Snapshot();
  EventReader other = Watch();
  other.Snapshot();
  uint64_t encoded = events_->encoded_count;
  while (events_->skip_count == 0) {
    PublishAllScenes();
    encoded += kScenes + 1;
    ASSERT_TRUE(Eventually([&] { return events_->encoded_count == encoded; }))
        << events_->encoded_count << " of " << encoded << " at " << sequence_;
    ASSERT_LT(sequence_, 1'000u);
    // This watcher reads, so it receives all events.
    other.Until("\"alpha\":" + std::to_string(sequence_ + 1) + ",");
  }
  const std::string latest = "\"alpha\":" + std::to_string(sequence_ + 1) + ",";
  uint64_t received = 1;
  while (slow.Snapshot().find(latest) == std::string::npos) ASSERT_LT(++received, sequence_);
  EXPECT_LT(received, sequence_) << "it did not receive all of them";
}

TEST_F(EventTokensTest, ATopicIsOfOneTokenAndEndsWithIt) {
  PutScene("desert");
  EXPECT_EQ(Get(kPosteriors).status, 401);
  EXPECT_EQ(Get(kPosteriors, Bearer("nobodys-token")).status, 401);
  EventReader first = Watch(kPosteriors, Bearer("ann-token"));
  EventReader second = Watch(kPosteriors, LogIn("ann-token"));
  EventReader other = Watch(kPosteriors, Bearer("root-token"));
  first.Snapshot();
  second.Snapshot();
  other.Snapshot();
  EXPECT_EQ(events_->open_topic_count, 2u);
  tokens_.Revoke("ann");
  clock_.Advance(rpc::kSecondNs);
  for (EventReader* watch : {&first, &second}) {
    EXPECT_THAT(watch->All(),
                AllOf(HasSubstr("event: error\ndata: {\"error\":{\"code\":\"UNAUTHENTICATED\","),
                      HasSubstr("this token was revoked or has expired")));
  }
  EXPECT_EQ(Get(kPosteriors, Bearer("ann-token")).status, 401);
  ASSERT_TRUE(Eventually([&] { return events_->open_topic_count == 1; }));
}

TEST_F(EventTokensTest, AProjectsTokenSeesItsProjects) {
  PutScene("desert");
  std::vector<priors::PriorRecord> theirs = {rpc::LearntInHours()};
  theirs[0].key.project = "theirs";
  Put(theirs);
  EXPECT_THAT(Watch(kPosteriors, Bearer("mine-token")).Snapshot(),
              AllOf(HasSubstr("desert"), Not(HasSubstr("theirs"))));
  EXPECT_THAT(Watch(kPosteriors, Bearer("root-token")).Snapshot(), HasSubstr("theirs"));
  EXPECT_EQ(Get(std::string(kPosteriors) + "?request=%7B%22project%22:%22theirs%22%7D",
                Bearer("mine-token"))
                .status,
            403);
}

class BusyTest : public EventsTest {
 protected:
  BusyTest() { event_limits_.heartbeat = std::chrono::milliseconds(1); }
};

TEST_F(BusyTest, AWatcherThatHasNothingToReadGetsAComment) {
  EventReader watch = Watch();
  watch.Snapshot();
  EXPECT_THAT(watch.Until("\r\n:\n\n\r\n"), HasSubstr("3\r\n:\n\n\r\n"));
}

class FewWatchersTest : public EventsTest {
 protected:
  FewWatchersTest() {
    event_limits_.max_watchers = 1;
    event_limits_.idle_patience = std::chrono::milliseconds(1);
  }
};

TEST_F(FewWatchersTest, WatchersAreLimitedAndOneThatLeavesMakesRoom) {
  {
    EventReader watch = Watch();
    watch.Snapshot();
    const Answer refused = Get(kPosteriors);
    EXPECT_EQ(refused.status, 429);
    EXPECT_THAT(refused.body, HasSubstr("the maximum number of watchers"));
  }
  ASSERT_TRUE(Eventually([&] { return events_->open_watcher_count == 0; }));
  ASSERT_TRUE(Eventually([&] { return events_->open_topic_count == 0; })) << "it has no watcher";
  ASSERT_TRUE(Eventually([&] { return server_->counters().open_watcher_count == 0; }));
  Watch().Snapshot();
}

class ShortLivedTest : public EventsTest {
 protected:
  ShortLivedTest() { event_limits_.idle_patience = std::chrono::milliseconds(0); }
};

TEST_F(ShortLivedTest, AWatcherThatJoinsAnEndingTopicIsServed) {
  PutScene("desert");
  for (int i = 0; i < 200; ++i) EXPECT_THAT(Watch().Snapshot(), HasSubstr("desert")) << i;
  ASSERT_TRUE(Eventually([&] { return events_->open_topic_count == 0; }));
}

class LittleStateTest : public EventsTest {
 protected:
  LittleStateTest() { event_limits_.max_snapshot_bytes = 6'000; }
};

TEST_F(LittleStateTest, ASnapshotAboveTheLimitEndsTheTopic) {
  PutScene("desert", 5);
  Watch().Snapshot();
  PutScene("harbour", 32);
  const std::string harbour = std::string(kPosteriors) + "?request=%7B%22scene%22:%22harbour%22%7D";
  const Answer refused = Get(harbour);
  EXPECT_EQ(refused.status, 429);
  EXPECT_THAT(refused.body, HasSubstr("too large to show at once"));
}

TEST_F(EventsTest, AThousandWatchersShareOneSubscriptionAndOneEncoding) {
  constexpr size_t kWatchers = 1'000;
  ASSERT_GT(RaiseDescriptorLimit(), 3 * kWatchers);
  PutScene("desert", 7);
  TelemetryClient client(channel_);
  client.Open(rpc::HelloMessage());
  std::vector<std::unique_ptr<EventReader>> watchers;
  for (size_t i = 0; i < kWatchers; ++i)
    watchers.push_back(std::make_unique<EventReader>(http_->port(), kPosteriors));
  for (const auto& watcher : watchers) watcher->Snapshot();
  EXPECT_EQ(events_->open_watcher_count, kWatchers);
  EXPECT_EQ(server_->counters().open_watcher_count, 1u);
  EXPECT_EQ(events_->encoded_count, 1u);
  LearnAndPublish(client, 1);
  EXPECT_EQ(events_->encoded_count, 3u);
  for (const auto& watcher : watchers) watcher->Until("\"windowCount\":\"1\",");
}

}  // namespace
}  // namespace sweepstake::server
